//! Ctrl-C as a wish, so that work ends in order.

use std::sync::atomic::{AtomicBool, Ordering};

use super::Failure;

static WISHED: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C, or a request to end, only makes the returned function true.
pub fn handle() -> Result<fn() -> bool, Failure> {
    ctrlc::set_handler(|| WISHED.store(true, Ordering::Relaxed)).map_err(Failure::work)?;
    Ok(|| WISHED.load(Ordering::Relaxed))
}
