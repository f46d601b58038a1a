//! Keeps one small record, the settings of the device, on two flash sectors, over a loss of power at any instant.
//!
//! The newest record that was completely written is what [`Store::load`] gives. A save that is cut short leaves either
//! the record before it or the new one, never none and never a mixture.
//!
//! # How
//!
//! A sector is a row of slots of [`SLOT_BYTES`] that are filled from the first to the last, one for every save:
//!
//! ```text
//! slot:   format (1) │ sequence (4) │ length (2) │ record (0 … 512) │ CRC-32 (4) │ erased
//! sector: slot │ slot │ slot │ …
//! ```
//!
//! - Integers are little-endian. The CRC-32 (that of Ethernet and zip) covers everything before it, and is computed over
//!   the very bytes that are handed back: a half-programmed slot that reads differently every time is not believed.
//! - Slots have fixed places: what a torn slot pretends to be cannot hide the slots after it.
//! - The newest record is the last whole slot of the sector whose last whole slot has the later sequence number.
//! - A save appends to the sector that holds the newest record. Only when that sector is full, or does not take the
//!   record, is the other one erased; it holds nothing but older records.
//! - A sector is always erased in full before its first slot is written: an erase that was cut short may look finished.
//! - After every write the store is read again as [`Store::load`] would, so what was saved is what will be loaded.
//!
//! What no format can decide is whether a slot that was torn in its last bits will read as whole the next time; as long
//! as it does, it is the newest record. The one before stays beside it, unless as many saves in a row as a sector has
//! slots were all torn so.
//!
//! # Wear
//!
//! A sector of 128 KiB (STM32F405) has 240 slots: one erase for 240 saves, taking turns. At 10 000 erases each, two
//! sectors last 4.8 million saves. Such an erase takes up to 4 s, and the processor waits for it when it executes from
//! the same flash; so does the first save on an empty store.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(
        clippy::arithmetic_side_effects,
        clippy::indexing_slicing,
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable
    )
)]

mod error;
mod slot;
mod store;

pub use error::StoreError;
pub use slot::{MAX_RECORD_BYTES, SLOT_BYTES};
pub use store::Store;
