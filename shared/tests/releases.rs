//! What was said by any release is understood for ever: every message of each, byte for byte.

use palpate_shared::adaptation::Relaxation;
use palpate_shared::pipeline::{self, GAUGES};
use palpate_shared::wire::{
    Answer, ClockSource, Columns, ConverterFault, Counters, Done, FRAME_MAX, Formats, Head, Hello,
    HelloToDevice, Inject, Log, Oversampling, Refusal, ResetCause, SelfTestOfFour, Settings,
    SettingsByRatio, Source, Start, StatusOfFour, StoreFault, ToDevice, ToHost, decode, encode,
};

const HEAD: Head = Head { sequence: 7, time_us: 1_234_567 };
const RELEASE_0_1: &str = include_str!("../../tests/golden/release-0.1/messages.txt");

fn counters() -> Counters {
    Counters {
        conversions_missed: 1,
        conversions_damaged: 2,
        queue_full: 3,
        link_full: 4,
        log_full: 5,
        bytes_lost: 6,
        frames_damaged: 7,
        frames_missed: 8,
    }
}

/// Every message that release 0.1 had from the device; blocks of rows are in its recording.
fn from_the_device() -> Vec<ToHost<'static>> {
    let gauge =
        pipeline::Counters { converter_at_rail: 1, strain_saturated: 2, filter_saturated: 3 };
    let hello = Hello {
        schema: 0xdaca_3958_96b2_8455,
        version: "0.1.0",
        git: "0123456789+",
        board: "feather-stm32f405",
        serial: [1, 2, 3],
        channels: 4,
        converter_clock_hz: 8_000_000,
        clock: ClockSource::Internal,
        formats: Formats::OURS,
        reset: ResetCause::Watchdog,
        panic: "main.rs:1: the end",
        counters: counters(),
    };
    let status = StatusOfFour {
        counters: counters(),
        gauges: [gauge; GAUGES],
        rows: 1 << 33,
        streaming: Some(Source::Link { interval_ns: 1_000_000 }),
        temperature: Some(-300),
        converter: Some(ConverterFault::Wrong(0x2203)),
        stack_used: 7_192,
        queue_most: 9,
    };
    let tested = SelfTestOfFour {
        converter: Err(ConverterFault::Stuck),
        noise_counts: [1.5; GAUGES],
        mean_counts: [-5; GAUGES],
        samples: 256,
        rate_ratio: 0.99,
    };
    let outcomes = [
        Ok(Done::Carried),
        Ok(Done::Injected { taken: 1, lost: 2, room: 3 }),
        Ok(Done::TestedOfFour(tested)),
        Err(Refusal::NoHello),
        Err(Refusal::Schema(1 << 40)),
        Err(Refusal::Streaming),
        Err(Refusal::NotStreaming),
        Err(Refusal::NotFromLink),
        Err(Refusal::Gauge(4)),
        Err(Refusal::Interval),
        Err(Refusal::Gain),
        Err(Refusal::Filter),
        Err(Refusal::Thresholds),
        Err(Refusal::Calibration),
        Err(Refusal::Rows),
        Err(Refusal::NoSample),
        Err(Refusal::Converter(ConverterFault::Missing)),
        Err(Refusal::Converter(ConverterFault::Register)),
        Err(Refusal::Converter(ConverterFault::Damaged)),
        Err(Refusal::Converter(ConverterFault::Bus)),
        Err(Refusal::Store(StoreFault::NotWritten)),
        Err(Refusal::Store(StoreFault::Flash)),
        Err(Refusal::NotHere),
    ];
    let by_ratio = SettingsByRatio::of(&Settings::DEFAULT, hello.converter_clock_hz);
    let mut all = vec![
        ToHost::Hello(hello),
        ToHost::StatusOfFour(status),
        ToHost::SettingsByRatio { generation: 3, settings: by_ratio },
        ToHost::Log(Log { bytes: &[1, 2, 3] }),
    ];
    all.extend(outcomes.map(|outcome| ToHost::Answer(Answer { to: 9, outcome })));
    all
}

/// Every message that release 0.1 had from the host.
fn from_the_host() -> Vec<ToDevice<'static>> {
    let start = |source, columns| ToDevice::Start(Start { source, columns });
    let [sheet, ..] = Settings::DEFAULT.calibration;
    vec![
        ToDevice::Hello(HelloToDevice { schema: 0xdaca_3958_96b2_8455, version: "0.1.0" }),
        start(Source::Converter, Columns::Parts),
        start(Source::Link { interval_ns: 5 }, Columns::All),
        ToDevice::Stop,
        ToDevice::SetRatio(Oversampling::X16384),
        ToDevice::SetGainOfFour([1, 2, 64, 128]),
        ToDevice::SetFilter(Relaxation { c1: 0.25, v1: 4.0, c2: 0.27, v2: 0.5 }),
        ToDevice::SetThresholds(Settings::DEFAULT.thresholds),
        ToDevice::SetCalibration { gauge: 2, sheet },
        ToDevice::Tare,
        ToDevice::Untare,
        ToDevice::Save,
        ToDevice::LoadDefaults,
        ToDevice::Inject(Inject { temperature: Some(1), counts: &[4, 5, 6] }),
        ToDevice::Settings,
        ToDevice::Status,
        ToDevice::SelfTest,
        ToDevice::Reboot,
        ToDevice::Bootloader,
    ]
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn every_message_of_release_0_1_is_understood_and_said_in_the_same_bytes() {
    let mut said = Vec::new();
    for message in from_the_device() {
        let mut room = [0; FRAME_MAX];
        let bytes = encode(HEAD, &message, &mut room).unwrap();
        said.push(hex(bytes));
        let length = bytes.len() - 1;
        assert_eq!(decode::<ToHost<'_>>(&mut room[..length]), Ok((HEAD, message)));
    }
    for message in from_the_host() {
        let mut room = [0; FRAME_MAX];
        let bytes = encode(HEAD, &message, &mut room).unwrap();
        said.push(hex(bytes));
        let length = bytes.len() - 1;
        assert_eq!(decode::<ToDevice<'_>>(&mut room[..length]), Ok((HEAD, message)));
    }
    let kept: Vec<_> = RELEASE_0_1.lines().collect();
    assert_eq!(said, kept, "\n{}", said.join("\n"));
}
