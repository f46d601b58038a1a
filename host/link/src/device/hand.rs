//! From several devices into one file, on one clock: that of the host, under which the clock of each device is fitted.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use shared::wire::{Felt, ToDevice};

use super::record::{
    Beside, Plan, RecordError, Recorder, View, begin, check_absent, not_created, since_us,
};
use super::session::Session;
use super::share::File;
use palpate_trace::recording::Opened;

/// Time between two looks at all devices.
const LOOK: Duration = Duration::from_millis(50);

/// What goes on beside a recording of several devices, which count from 0.
pub trait BesideAll {
    /// Whether the recording shall end.
    fn ended(&mut self) -> bool;

    /// Sees all devices about twenty times in a second, and at the end.
    fn watch(&mut self, views: &[View]);

    /// Hears of a touch, a release or a slip soon after a device reported it.
    fn feel(&mut self, device: usize, felt: &Felt);
}

/// Records several devices until the plans or `beside` say so; a device that fails ends the recording of all.
///
/// # Errors
/// [`RecordError`], with the place of the device, from 0.
pub fn record_all(
    mut devices: Vec<(Session, Plan)>,
    file: &Path,
    overwrite: bool,
    beside: &mut dyn BesideAll,
) -> Result<Vec<View>, (usize, RecordError)> {
    let began = Instant::now();
    check_absent(file, overwrite).map_err(|error| (0, error))?;
    begin_all(&mut devices)?;
    let ports: Vec<_> = devices.iter().map(|(_, plan)| plan.port.to_string_lossy()).collect();
    let opened = File::create(file, overwrite, &Opened::now(&ports.join(", ")), true);
    let shared = opened.map_err(|error| {
        stop(&mut devices);
        (0, not_created(file, error))
    })?;
    let (plans, sessions): (Vec<_>, Vec<_>) =
        devices.into_iter().map(|(session, plan)| (plan, session)).unzip();
    let seen = Seen { ended: AtomicBool::new(false), fingers: Mutex::default() };
    let outcomes = thread::scope(|scope| {
        let mut running = Vec::new();
        for (device, (session, plan)) in sessions.into_iter().zip(&plans).enumerate() {
            let share = shared.of_device(device as u8);
            let mut recorder = Recorder::new(plan, share, began, session.identity().clone());
            seen.fingers().push((recorder.view(), Vec::new()));
            let one = One { device, seen: &seen };
            running.push(scope.spawn(move || one.follow(recorder, session, file)));
        }
        while !running.iter().all(thread::ScopedJoinHandle::is_finished) {
            thread::sleep(LOOK);
            seen.show(beside);
            if beside.ended() {
                seen.ended.store(true, Ordering::Relaxed);
            }
        }
        running.into_iter().map(thread::ScopedJoinHandle::join).collect::<Vec<_>>()
    });
    let closed = shared.close(since_us(began, Instant::now()));
    seen.show(beside);
    for outcome in outcomes {
        outcome.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
    }
    closed.map_err(|source| (0, RecordError::File { path: file.into(), source }))?;
    Ok(seen.views())
}

/// Begins all streams, or none: a device that refuses leaves no file.
fn begin_all(devices: &mut [(Session, Plan)]) -> Result<(), (usize, RecordError)> {
    for device in 0..devices.len() {
        let (session, plan) = &mut devices[device];
        if let Err(error) = begin(session, plan.start) {
            stop(&mut devices[..device]);
            return Err((device, error.into()));
        }
    }
    Ok(())
}

fn stop(devices: &mut [(Session, Plan)]) {
    for (session, _) in devices {
        // The reason to stop is what there is to tell.
        let _ = session.command(&ToDevice::Stop);
    }
}

/// What those that follow the devices tell the one that shows them.
struct Seen {
    ended: AtomicBool,
    /// Of each device how it goes, and what it felt that was not shown.
    fingers: Mutex<Vec<(View, Vec<Felt>)>>,
}

impl Seen {
    fn fingers(&self) -> MutexGuard<'_, Vec<(View, Vec<Felt>)>> {
        self.fingers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn views(&self) -> Vec<View> {
        self.fingers().iter().map(|(view, _)| *view).collect()
    }

    fn show(&self, beside: &mut dyn BesideAll) {
        let felt: Vec<_> =
            self.fingers().iter_mut().map(|(_, felt)| std::mem::take(felt)).collect();
        for (device, felt) in felt.iter().enumerate() {
            felt.iter().for_each(|felt| beside.feel(device, felt));
        }
        beside.watch(&self.views());
    }
}

/// Beside one of the devices.
struct One<'s> {
    device: usize,
    seen: &'s Seen,
}

impl One<'_> {
    fn follow(
        mut self,
        mut recorder: Recorder<'_>,
        session: Session,
        file: &Path,
    ) -> Result<(), (usize, RecordError)> {
        let outcome = recorder.run(session, &mut self);
        self.watch(&recorder.view());
        outcome.map_err(|stop| {
            // It ends the recording of all.
            self.seen.ended.store(true, Ordering::Relaxed);
            (self.device, recorder.failed(stop, file))
        })
    }
}

impl Beside for One<'_> {
    fn ended(&mut self) -> bool {
        self.seen.ended.load(Ordering::Relaxed)
    }

    fn watch(&mut self, view: &View) {
        self.seen.fingers()[self.device].0 = *view;
    }

    fn feel(&mut self, felt: &Felt) {
        self.seen.fingers()[self.device].1.push(*felt);
    }
}
