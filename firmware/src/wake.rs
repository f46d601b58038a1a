//! How one task wakes another: any may call, the one that is meant waits.

use core::future::poll_fn;
use core::task::Poll;

use rtic_sync::signal::Signal;

/// Someone to wake. Calls that come before it looks count as one.
pub type Sleeper = Signal<()>;

/// There are samples, or injected rows.
pub static FILTER: Sleeper = Signal::new();
/// There are bytes of the host.
pub static COMMAND: Sleeper = Signal::new();
/// There is something to send, or room to send it.
pub static SEND: Sleeper = Signal::new();
/// Something happened on the USB bus, or there is something for it.
pub static USB: Sleeper = Signal::new();

/// Wakes it.
pub fn wake(sleeper: &Sleeper) {
    sleeper.writer().write(());
}

/// Lets other tasks of the same priority run.
pub async fn give_way() {
    let mut gave = false;
    poll_fn(|context| {
        if core::mem::replace(&mut gave, true) {
            return Poll::Ready(());
        }
        context.waker().wake_by_ref();
        Poll::Pending
    })
    .await;
}
