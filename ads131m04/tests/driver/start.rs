//! Reset, identity and settings: what `init` sends, verifies and refuses.

use crate::script::{NULL, READ_ID, READY, RESET, Script, config, no_delay};
use ads131m04::{Ads131m04, Clock, Config, Error, Inputs, PowerMode, Register};
use embedded_hal_mock::eh1::{
    MockError,
    delay::{CheckedDelay, Transaction as Wait},
    digital::{Mock as Pin, State, Transaction as PinEvent},
    spi::Mock as Spi,
};

const MODE: u16 = 2;
const CLOCK: u16 = 3;
const GAIN1: u16 = 4;
const CFG: u16 = 6;

fn settings(script: Script) -> Script {
    script
        .written(MODE, 0x1110, 0x1110)
        .written(CLOCK, 0x0F16, 0x0F16)
        .written(GAIN1, 0x7531, 0x7531)
        .written(CFG, 0x0600, 0x0600)
}

#[test]
fn init_resets_identifies_and_configures_with_every_setting_read_back() {
    let script = settings(Script::default().reset_and_identity()).stale();
    assert_eq!(script.meet_init(|chip| chip.init(&mut no_delay(), &config())), Ok(()));
}

#[test]
fn the_reset_pulse_is_2048_periods_of_whatever_clock_there_is_and_little_more() {
    // 6826.7 µs and 250 µs.
    for (hz, power, us) in
        [(300_000, PowerMode::HighResolution, 6_828), (8_192_000, PowerMode::HighResolution, 252)]
    {
        let mut delay = CheckedDelay::new(&[
            Wait::delay_us(250),
            Wait::delay_us(us),
            Wait::delay_us(5),
            Wait::delay_us(5),
        ]);
        let config = Config { clock: Clock::new(hz, power).unwrap(), ..config() };
        let script = settings(Script::default().reset_and_identity()).stale();
        script.meet_init(|chip| chip.init(&mut delay, &config)).unwrap();
        delay.done();
    }
}

#[test]
fn a_missing_chip_is_named_as_such_with_advice() {
    for byte in [0x00, 0xFF] {
        let script = Script::default().raw(RESET, vec![byte; 18]);
        let error = script.meet_init(|chip| chip.init(&mut no_delay(), &config())).unwrap_err();
        assert_eq!(error, Error::NoChip { read: byte });
        let message = error.to_string();
        assert!(
            message.contains(&format!("{byte:02X}h")) && message.contains("check"),
            "{message}"
        );
    }
}

#[test]
fn a_chip_that_does_not_acknowledge_its_reset_is_refused() {
    let script = Script::default().frame(RESET, READY).frame(NULL, 0x0011);
    let error = script.meet_init(|chip| chip.init(&mut no_delay(), &config())).unwrap_err();
    assert_eq!(error, Error::NotReset { response: 0x0011 });
    assert!(error.to_string().contains("0011h"));
}

#[test]
fn a_sibling_with_two_channels_is_told_by_its_reset_though_its_checksum_stands_elsewhere() {
    let mut short = crate::script::reply(0xFF22, [0; 4]);
    short[17] ^= 0x40;
    short[10] ^= 0x01;
    let script = Script::default().frame(RESET, READY).raw(NULL, short);
    let error = script.meet_init(|chip| chip.init(&mut no_delay(), &config())).unwrap_err();
    assert_eq!(error, Error::WrongChip { read: 0xFF22, channels: 2 });
    assert!(error.to_string().contains("2 channels"));
}

#[test]
fn a_chip_that_names_another_number_of_channels_is_refused() {
    let script =
        Script::default().frame(RESET, READY).frame(NULL, 0xFF24).exchange(READ_ID, 0x2803);
    let error = script.meet_init(|chip| chip.init(&mut no_delay(), &config())).unwrap_err();
    assert_eq!(error, Error::WrongChip { read: 0x2803, channels: 8 });
}

#[test]
fn a_register_that_reads_back_differently_is_named_with_both_values() {
    let script = Script::default().written(MODE, 0x1110, 0x1110).written(CLOCK, 0x0F16, 0x0F0E);
    let error = script.meet(|chip| chip.configure(&config())).unwrap_err();
    assert_eq!(error, Error::ReadBack { register: Register::Clock, written: 0x0F16, read: 0x0F0E });
    let message = error.to_string();
    assert!(message.contains("Clock") && message.contains("0F16h") && message.contains("0F0Eh"));
}

#[test]
fn inputs_are_chosen_for_every_channel_and_read_back() {
    for (inputs, code) in [(Inputs::Pins, 0), (Inputs::Shorted, 1), (Inputs::TestSignal, 2)] {
        let channels = [0x09, 0x0E, 0x13, 0x18];
        let script = channels
            .iter()
            .fold(Script::default(), |script, &channel| script.written(channel, code, code))
            .stale();
        assert_eq!(script.meet(|chip| chip.select(inputs)), Ok(()));
    }
}

#[test]
fn a_locked_chip_refuses_settings_and_says_so() {
    let script = Script::default().frame(&[0x6100, 0x1110], READY).frame(&[0xA100], 0x810F);
    let error = script.meet(|chip| chip.configure(&config())).unwrap_err();
    assert_eq!(error, Error::Refused { command: 0x6100, expected: 0x4100, response: 0x810F });
}

#[test]
fn a_damaged_answer_is_never_taken_for_a_setting() {
    let mut damaged = crate::script::reply(0x4100, [0; 4]);
    damaged[4] ^= 0x10;
    let script = Script::default().frame(&[0x6100, 0x1110], READY).raw(&[0xA100], damaged);
    let error = script.meet(|chip| chip.configure(&config())).unwrap_err();
    assert!(matches!(error, Error::Crc { .. }));
}

#[test]
fn standby_wakeup_lock_and_unlock_are_acknowledged() {
    let script = [0x0022, 0x0033, 0x0555, 0x0655]
        .iter()
        .fold(Script::default(), |script, &word| script.exchange(&[word], word));
    script.meet(|chip| {
        chip.standby().unwrap();
        chip.wakeup().unwrap();
        chip.lock().unwrap();
        chip.unlock().unwrap();
    });
}

#[test]
fn a_broken_reset_pin_is_reported_before_anything_is_sent() {
    let failure = MockError::Io(std::io::ErrorKind::NotConnected);
    let mut spi = Spi::new(&[]);
    let mut pin = Pin::new(&[PinEvent::set(State::High).with_error(failure.clone())]);
    let outcome = Ads131m04::new(&mut spi, &mut pin).init(&mut no_delay(), &config());
    assert_eq!(outcome, Err(Error::ResetPin(failure)));
    spi.done();
    pin.done();
}
