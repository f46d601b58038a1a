//! What releases may differ in, and what never changes.
//!
//! Messages only grow: a new one comes at the end of its enumeration, and so does a new variant of anything in them; what is
//! there keeps its place and its form. So messages of an earlier release are read by every later one, recordings too, and each
//! side speaks the older schema of the two. `tests/releases.rs` holds every message of every release to its bytes.

use super::SCHEMA;

/// Schemas of the releases before this one: all that they say is understood, and spoken to them.
pub const EARLIER: [u64; 1] = [
    // 0.1
    0xdaca_3958_96b2_8455,
];

/// Whether messages of this schema are understood.
#[must_use]
pub fn is_understood(schema: u64) -> bool {
    schema == SCHEMA || EARLIER.contains(&schema)
}

/// Types of the commands that a device of any release carries out for a host of any release: `Stop`, `Status`, `Reboot` and
/// `Bootloader`, which carry nothing.
const CORE: [u8; 4] = [2, 14, 16, 17];

/// Whether a message, as [`super::open`] gives it, is a command of the core.
#[must_use]
pub fn is_of_core(message: &[u8]) -> bool {
    matches!(message, [kind] if CORE.contains(kind))
}
