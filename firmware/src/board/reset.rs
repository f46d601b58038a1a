//! Why the chip began, how it begins again, and what is kept over that.

use core::fmt::Write;
use core::mem::MaybeUninit;
use core::ptr::{addr_of, addr_of_mut};

use device::Restart;
use shared::wire::{Hello, ResetCause};
use stm32f4xx_hal::pac::{RCC, SYSCFG};

unsafe extern "C" {
    static _stack_end: u32;
    static _stack_start: u32;
}

/// A note to the program after the reset, in memory that the reset does not touch.
#[derive(Clone, Copy)]
#[repr(C)]
struct Note {
    /// Says that this is a note and not what was in memory at power-on.
    mark: u32,
    bootloader: bool,
    length: usize,
    text: [u8; Hello::PANIC],
}

const MARK: u32 = 0x7061_6c70;
const SYSTEM_MEMORY: *const u32 = 0x1fff_0000 as *const _;

#[unsafe(link_section = ".uninit.note")]
static mut NOTE: MaybeUninit<Note> = MaybeUninit::uninit();

fn write(note: Note) {
    // SAFETY: only before interrupts are enabled, and with them disabled just before a reset: nothing else looks.
    unsafe { addr_of_mut!(NOTE).write(MaybeUninit::new(note)) };
}

/// Takes the note of the program before the reset.
fn take() -> Option<Note> {
    // SAFETY: as in `write`; any bytes are a `u32`.
    let marked = unsafe { addr_of!(NOTE).cast::<u32>().read() } == MARK;
    // SAFETY: as in `write`; whoever wrote the mark wrote the note.
    let note = marked.then(|| unsafe { addr_of!(NOTE).cast::<Note>().read() });
    write(Note { mark: 0, bootloader: false, length: 0, text: [0; Hello::PANIC] });
    note
}

/// What the last panic said, now in `text`. Goes on to the loader in ROM instead of returning, if that was asked for.
pub fn last_words<'t>(text: &'t mut [u8; Hello::PANIC], rcc: &RCC, syscfg: &SYSCFG) -> &'t str {
    let Some(note) = take() else { return "" };
    if note.bootloader {
        enter_loader(rcc, syscfg);
    }
    *text = note.text;
    let said = text.get(..note.length).unwrap_or_default();
    match core::str::from_utf8(said) {
        Ok(said) => said,
        Err(error) => {
            core::str::from_utf8(said.get(..error.valid_up_to()).unwrap_or_default()).unwrap_or("")
        }
    }
}

/// Begins the loader in ROM, as the boot pin would: its memory at address 0, interrupts on (AN2606).
fn enter_loader(rcc: &RCC, syscfg: &SYSCFG) -> ! {
    rcc.apb2enr().modify(|_, w| w.syscfgen().enabled());
    // The clock of a peripheral runs two cycles after it was enabled (RM0090 §7.3.13).
    cortex_m::asm::delay(2);
    syscfg.memrmp().modify(|_, w| w.mem_mode().system_flash());
    // SAFETY: no interrupt of ours is enabled yet. The system memory of the STM32F405 begins with the loader's stack pointer
    // and entry; nothing was set up that it would not expect.
    unsafe {
        cortex_m::interrupt::enable();
        cortex_m::asm::bootload(SYSTEM_MEMORY)
    }
}

/// Begins again.
pub fn restart(into: Restart) -> ! {
    cortex_m::interrupt::disable();
    if into == Restart::Bootloader {
        write(Note { mark: MARK, bootloader: true, length: 0, text: [0; Hello::PANIC] });
    }
    cortex_m::peripheral::SCB::sys_reset()
}

/// Keeps these words and begins again.
pub fn die(words: impl core::fmt::Display) -> ! {
    cortex_m::interrupt::disable();
    let mut note = Note { mark: MARK, bootloader: false, length: 0, text: [0; Hello::PANIC] };
    // What does not fit is cut.
    let _ = write!(Cut(&mut note), "{words}");
    write_note_and_reset(note)
}

fn write_note_and_reset(note: Note) -> ! {
    write(note);
    cortex_m::peripheral::SCB::sys_reset()
}

struct Cut<'a>(&'a mut Note);

impl Write for Cut<'_> {
    fn write_str(&mut self, more: &str) -> core::fmt::Result {
        let Note { length, text, .. } = self.0;
        for (place, byte) in text.iter_mut().skip(*length).zip(more.bytes()) {
            *place = byte;
            *length = length.saturating_add(1);
        }
        Ok(())
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    die(Said(info))
}

/// Place and message of a panic, the file without its folders.
struct Said<'a>(&'a core::panic::PanicInfo<'a>);

impl core::fmt::Display for Said<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        if let Some(place) = self.0.location() {
            let file = place.file().rsplit(['/', '\\']).next().unwrap_or_default();
            write!(f, "{file}:{}: ", place.line())?;
        }
        write!(f, "{}", self.0.message())
    }
}

/// A fault of the processor. The stack may have left its memory, and whatever is pushed onto it then is a second fault, which
/// stops the processor for good: this takes all of the stack's memory anew before anything else.
///
/// # Safety
/// Called by the processor alone.
#[unsafe(naked)]
#[unsafe(export_name = "HardFault")]
unsafe extern "C" fn hard_fault() -> ! {
    core::arch::naked_asm!(
        "mrs r0, msp",
        "ldr r1, ={top}",
        "msr msp, r1",
        "b {fault}",
        top = sym _stack_start,
        fault = sym fault,
    )
}

/// Words of a fault, with the stack pointer at the frame that the processor pushed, if it could.
extern "C" fn fault(frame: *const [u32; 8]) -> ! {
    let (end, start) = ((&raw const _stack_end).cast(), (&raw const _stack_start).cast());
    if frame < end || frame.wrapping_add(1) > start {
        die("the stack left its memory");
    }
    // SAFETY: the frame lies within the memory of the stack, as the line above has found.
    let pushed = unsafe { frame.read() };
    // Registers 0 to 3 and 12, link register, program counter, status (ARMv7-M architecture, B1.5.6).
    let [.., program_counter, _] = pushed;
    die(format_args!("hard fault at {program_counter:#010x}"))
}

/// Why the chip began; the answer is cleared for the next time.
pub fn cause(rcc: &RCC) -> ResetCause {
    let flags = rcc.csr().read();
    let cause = if flags.wdgrstf().bit_is_set() || flags.wwdgrstf().bit_is_set() {
        ResetCause::Watchdog
    } else if flags.sftrstf().bit_is_set() {
        ResetCause::Software
    } else if flags.porrstf().bit_is_set() {
        ResetCause::PowerOn
    } else if flags.borrstf().bit_is_set() {
        ResetCause::BrownOut
    } else if flags.padrstf().bit_is_set() {
        ResetCause::Pin
    } else {
        ResetCause::PowerOn
    };
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    cause
}
