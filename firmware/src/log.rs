//! The log, in the encoding of defmt, kept until the link has time for it.

#[cfg(feature = "rtt")]
use defmt_rtt as _;

#[cfg(feature = "rtt")]
pub use probe::{Waiting, lost};

/// A probe reads the log; the link has nothing of it.
#[cfg(feature = "rtt")]
mod probe {
    /// Nothing waits for the link.
    pub struct Waiting;

    impl device::Log for Waiting {
        fn is_waiting(&self) -> bool {
            false
        }

        fn take(&mut self, _: &mut [u8]) -> usize {
            0
        }
    }

    /// Bytes that found no room since the last call.
    pub fn lost() -> u32 {
        0
    }
}

#[cfg(not(feature = "rtt"))]
pub use link::{Waiting, lost};

#[cfg(not(feature = "rtt"))]
mod link {
    use core::cell::RefCell;
    use core::mem::take as replace;

    use critical_section::{Mutex, RestoreState};
    use heapless::Deque;

    /// Bytes kept.
    const KEPT: usize = 1_024;

    struct Kept {
        bytes: Deque<u8, KEPT>,
        encoder: defmt::Encoder,
        lost: u32,
        /// How interrupts were before the message that is written now.
        before: Option<RestoreState>,
    }

    static LOG: Mutex<RefCell<Kept>> = Mutex::new(RefCell::new(Kept {
        bytes: Deque::new(),
        encoder: defmt::Encoder::new(),
        lost: 0,
        before: None,
    }));

    impl Kept {
        fn encode(&mut self, step: impl FnOnce(&mut defmt::Encoder, &mut dyn FnMut(&[u8]))) {
            let Self { bytes, encoder, lost, .. } = self;
            step(encoder, &mut |more| {
                for byte in more {
                    if bytes.push_back(*byte).is_err() {
                        *lost = lost.saturating_add(1);
                    }
                }
            });
        }
    }

    /// What was logged and is not sent yet.
    pub struct Waiting;

    impl device::Log for Waiting {
        fn is_waiting(&self) -> bool {
            critical_section::with(|section| !LOG.borrow_ref(section).bytes.is_empty())
        }

        fn take(&mut self, room: &mut [u8]) -> usize {
            critical_section::with(|section| {
                let mut log = LOG.borrow_ref_mut(section);
                let mut taken = 0;
                for place in room {
                    let Some(byte) = log.bytes.pop_front() else { break };
                    *place = byte;
                    taken += 1;
                }
                taken
            })
        }
    }

    /// Bytes that found no room since the last call.
    pub fn lost() -> u32 {
        critical_section::with(|section| replace(&mut LOG.borrow_ref_mut(section).lost))
    }

    #[defmt::global_logger]
    struct Logger;

    fn with(step: impl FnOnce(&mut Kept)) {
        critical_section::with(|section| {
            if let Ok(mut log) = LOG.borrow(section).try_borrow_mut() {
                step(&mut log);
            }
        });
    }

    // SAFETY: interrupts are off from `acquire` to `release`, so messages do not mix.
    unsafe impl defmt::Logger for Logger {
        fn acquire() {
            // SAFETY: released in `release`, which defmt calls after every `acquire`.
            let before = unsafe { critical_section::acquire() };
            with(|log| {
                log.before = Some(before);
                log.encode(|encoder, write| encoder.start_frame(write));
            });
        }

        unsafe fn flush() {}

        unsafe fn release() {
            let mut before = None;
            with(|log| {
                log.encode(|encoder, write| encoder.end_frame(write));
                before = log.before.take();
            });
            if let Some(before) = before {
                // SAFETY: the state of the `acquire` before.
                unsafe { critical_section::release(before) };
            }
        }

        unsafe fn write(bytes: &[u8]) {
            with(|log| log.encode(|encoder, write| encoder.write(bytes, write)));
        }
    }
}
