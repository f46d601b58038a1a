//! Follows a fingertip for two seconds: here a simulated one, behind a pseudo-terminal; give a port for a real one.
//!
//! `cargo run --package palpate --example live` or `cargo run --example live -- /dev/ttyACM0`

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use palpate::device::session::Session;
use palpate::device::simulate::{Simulated, Simulation};
use palpate::device::watch::watch;
use palpate::fingertip::fixed::microstrain;

/// Every so many rows one is shown.
const EVERY_ROWS: u64 = 500;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    match std::env::args().nth(1) {
        Some(port) => follow(Path::new(&port)),
        None => without_hardware(),
    }
}

/// Follows a fingertip that the computer simulates.
fn without_hardware() -> Result<(), Box<dyn std::error::Error>> {
    let mut simulated = Simulated::new(&Simulation::default())?;
    let port: PathBuf = simulated.path().into();
    let ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| simulated.run(|| ended.load(Ordering::Relaxed)));
        let followed = follow(&port);
        ended.store(true, Ordering::Relaxed);
        followed
    })
}

/// Shows the fast and slow adapting part of the first gauge for two seconds.
fn follow(port: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut session = Session::open(port, Duration::from_secs(3))?;
    let until = Instant::now() + Duration::from_secs(2);
    let tally = watch(
        &mut session,
        || Instant::now() > until,
        |row| {
            if row.number % EVERY_ROWS == 0 {
                let (fa, sa) = (microstrain(row.fa[0]), microstrain(row.sa[0]));
                println!("{:>7.2} s  FA {fa:>8.1} µε  SA {sa:>8.1} µε", row.time_us as f64 / 1e6);
            }
            ControlFlow::Continue(())
        },
    )?;
    println!("{tally:?}");
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn it_runs() {
        super::without_hardware().unwrap();
    }
}
