//! Processor time of one answer.

use std::time::Instant;

/// Runs something on one thread by itself, with the processor time that it took there, s; the time of
/// the clock where the system does not tell.
pub fn timed<T: Send>(run: impl FnOnce() -> T + Send) -> (T, f64) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    pool.install(|| {
        let (clock, before) = (Instant::now(), of_this_thread());
        let result = run();
        let spent = before.zip(of_this_thread()).map(|(before, after)| after - before);
        (result, spent.unwrap_or_else(|| clock.elapsed().as_secs_f64()))
    })
}

/// Processor time of this thread so far, s, where Linux tells.
fn of_this_thread() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(1e-9 * nanoseconds)
}
