//! How much stack was ever used: it is painted before the program begins.

use cortex_m_rt::STACK_PAINT_VALUE;

unsafe extern "C" {
    static _stack_end: u32;
    static _stack_start: u32;
}

/// Most bytes of stack that were ever used.
pub fn used() -> u32 {
    let (end, start) = (&raw const _stack_end, &raw const _stack_start);
    let mut lowest = end;
    // SAFETY: reads words of the stack's own memory, between the two symbols of the linker; a word that changes meanwhile
    // is one in use, and the search ends below it.
    while lowest < start && unsafe { lowest.read_volatile() } == STACK_PAINT_VALUE {
        lowest = lowest.wrapping_add(1);
    }
    (start as u32).wrapping_sub(lowest as u32)
}
