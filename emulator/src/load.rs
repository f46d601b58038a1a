//! What the processor is busy with: a look at it every few microseconds, while rows and commands come and go.

use std::collections::BTreeMap;

use crate::{Board, MS};

/// Time between two looks, ns: no interval of the converter is a multiple of it.
const LOOK_NS: u64 = 1_700;
/// Numbers of exceptions (ARMv7-M architecture, table B1-4; RM0090 table 62): interrupt `n` is exception 16 + n.
const PARTS: [(u16, &str); 6] =
    [(15, "timer"), (22, "exti0"), (23, "exti1"), (39, "read"), (55, "line"), (83, "on_usb")];

/// Where the processor's time went, as shares of it.
#[derive(Clone, Debug)]
pub struct Load {
    /// All but sleep.
    pub whole: f64,
    /// By interrupt; what is none of these is `"idle"`, on its way into sleep and out of it.
    pub parts: BTreeMap<&'static str, f64>,
}

impl Board {
    /// Looks at the processor for so many milliseconds.
    pub fn load(&mut self, ms: u64) -> Load {
        let looks = ms * MS / LOOK_NS;
        let mut parts = BTreeMap::new();
        for _ in 0..looks {
            self.run_ns(LOOK_NS);
            if !self.cpu().is_asleep() {
                let number = self.cpu().current_exception().0;
                let part = PARTS.iter().find(|(exception, _)| *exception == number);
                *parts.entry(part.map_or("idle", |(_, name)| name)).or_insert(0.0) +=
                    1.0 / looks as f64;
            }
        }
        self.listen();
        Load { whole: parts.values().sum(), parts }
    }
}
