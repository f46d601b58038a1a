//! What the processor is busy with: looks at random instants, while rows and commands come and go.

use std::collections::BTreeMap;

use crate::{Board, MS};

/// Mean time between two looks, ns. Each look ends a round of the scheduler, at which events come: only at random instants with nothing
/// between them but chance (exponential intervals) is an interrupt that begins with a look seen as often as any other.
const LOOK_NS: f64 = 1_500.0;
/// Numbers of exceptions (ARMv7-M architecture, table B1-4; RM0090 table 62): interrupt `n` is exception 16 + n.
const PARTS: [(u16, &str); 6] =
    [(15, "timer"), (22, "filter"), (23, "tasks"), (39, "read"), (55, "line"), (83, "on_usb")];

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
        let (until, mut random, mut looks) = (self.now_ns() + ms * MS, 1_u64, 0.0);
        let mut parts = BTreeMap::new();
        while self.now_ns() < until {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let chance = ((random >> 33) as f64 + 1.0) / (1_u64 << 31) as f64;
            self.run_ns((-chance.ln() * LOOK_NS) as u64 + 1);
            looks += 1.0;
            if !self.cpu().is_asleep() {
                let number = self.cpu().current_exception().0;
                let part = PARTS.iter().find(|(exception, _)| *exception == number);
                *parts.entry(part.map_or("idle", |(_, name)| name)).or_insert(0.0) += 1.0;
            }
        }
        parts.values_mut().for_each(|count| *count /= looks);
        self.listen();
        Load { whole: parts.values().sum(), parts }
    }
}
