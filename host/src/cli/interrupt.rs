//! What Ctrl-C and a request to end do: work that ends in order is told so, any other ends at once and leaves no litter.

use std::sync::atomic::{AtomicBool, Ordering};

use super::Failure;
use crate::files::remove_unfinished;

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

/// From now on a signal to end removes unfinished files first. Where one is ignored, as under `nohup`, it stays so.
pub fn prepare() {
    PREPARED.store(ctrlc::try_set_handler(end).is_ok(), Ordering::SeqCst);
}

/// From now on Ctrl-C, or a request to end, only makes the returned function true.
pub fn handle() -> Result<fn() -> bool, Failure> {
    IN_ORDER.store(true, Ordering::SeqCst);
    if !PREPARED.load(Ordering::SeqCst) {
        ctrlc::set_handler(end).map_err(Failure::work)?;
    }
    Ok(|| WISHED.load(Ordering::SeqCst))
}
