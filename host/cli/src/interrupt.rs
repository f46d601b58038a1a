//! What Ctrl-C and a request to end do: work that ends in order is told so, any other ends at once and leaves no litter.

use std::sync::atomic::{AtomicBool, Ordering};

use super::Failure;
use palpate_trace::files::remove_unfinished;

/// Exit status of a program that was interrupted, as shells have it.
const INTERRUPTED: i32 = 130;

/// Whether signals come here.
static PREPARED: AtomicBool = AtomicBool::new(false);
/// Whether what runs ends in order by itself.
static IN_ORDER: AtomicBool = AtomicBool::new(false);
static WISHED: AtomicBool = AtomicBool::new(false);

fn end() {
    WISHED.store(true, Ordering::SeqCst);
    if !IN_ORDER.load(Ordering::SeqCst) {
        remove_unfinished();
        std::process::exit(INTERRUPTED);
    }
}

/// From now on a signal to end removes unfinished files first. One that is ignored, as under `nohup` or in the background of a
/// script, stays so; on Linux the others are heard all the same.
pub fn prepare() {
    let heard = ctrlc::try_set_handler(end).is_ok() || hear_others();
    PREPARED.store(heard, Ordering::SeqCst);
}

/// Hears those signals to end that are not ignored, of which there must be one; whether that was possible.
#[cfg(target_os = "linux")]
fn hear_others() -> bool {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let Some(Ok(ignored)) = ignored.map(|mask| u64::from_str_radix(mask.trim(), 16)) else {
        return false;
    };
    let heard =
        [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    let Ok(mut signals) = signal_hook::iterator::Signals::new(heard) else { return false };
    std::thread::spawn(move || signals.forever().for_each(|_| end()));
    true
}

#[cfg(not(target_os = "linux"))]
fn hear_others() -> bool {
    false
}

/// From now on Ctrl-C, or a request to end, only makes the returned function true.
pub fn handle() -> Result<fn() -> bool, Failure> {
    IN_ORDER.store(true, Ordering::SeqCst);
    if !PREPARED.load(Ordering::SeqCst) {
        ctrlc::set_handler(end).map_err(Failure::work)?;
    }
    Ok(|| WISHED.load(Ordering::SeqCst))
}
