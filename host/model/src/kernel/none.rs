//! `none`: nothing relaxes.

use super::{Kernel, MemoryOf};

/// g = 1.
pub(super) static KERNEL: Kernel = Kernel {
    name: "none",
    meaning: "nothing relaxes",
    formula: "g = 1",
    memory: MemoryOf::Nothing,
    parameters: |_| Vec::new(),
    constants: |_, elastic| elastic,
    values: |_| Vec::new(),
};
