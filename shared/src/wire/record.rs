//! Settings as they are kept over a loss of power, and over a change of the firmware.
//!
//! A record is a mark and two parts, each with its version and its length. The first is the calibration with the gains it is true
//! for: it was measured, with weights or gauge blocks, so every later release reads it. The second is everything else, which can be
//! set again in a minute; a release to which its version is foreign takes its defaults instead, and says so ([`Kept`]).

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use super::by_ratio::SettingsByRatio;
use super::settings::Settings;
use crate::adaptation::Relaxation;
use crate::calibration::Sheet;
use crate::phase::Thresholds;
use crate::pipeline::GAUGES;

/// What became of the settings that were kept when the device began.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Kept {
    /// None were: the settings are those the device was made with.
    None,
    /// All are as they were saved.
    All,
    /// Gains, calibration and tare are as they were saved; the rest is of another release and was set to its defaults.
    Calibration,
    /// They cannot be read, or are out of range: the settings are those the device was made with.
    Discarded,
}

/// Version 1 of what was measured. It never changes; another comes beside it.
#[derive(Serialize, Deserialize)]
struct Measured {
    gain: [u8; GAUGES],
    calibration: [Sheet; GAUGES],
    tare: [i32; GAUGES],
}

/// Version 1 of the rest.
#[derive(Serialize, Deserialize)]
struct Rest {
    interval_ns: u32,
    relaxation: Relaxation,
    thresholds: Thresholds,
}

const MARK: [u8; 4] = *b"palp";
const VERSION: u8 = 1;
/// What the records of release 0.1 begin with; all of its settings follow.
const RELEASE_0_1: [u8; 8] = [0x35, 0xc3, 0x6f, 0x7e, 0x95, 0xdb, 0xb1, 0x52];

impl Settings {
    /// Most bytes of a record.
    pub const RECORD: usize = 256;

    /// The settings as they are kept: the record, and how many of its bytes are used.
    #[must_use]
    pub fn record(&self) -> ([u8; Self::RECORD], usize) {
        let Self { interval_ns, gain, calibration, tare, relaxation, thresholds } = *self;
        let mut record = [0; Self::RECORD];
        let length = record.split_first_chunk_mut().and_then(|(mark, parts)| {
            *mark = MARK;
            let measured = write_part(parts, &Measured { gain, calibration, tare })?;
            let rest = parts.get_mut(measured..)?;
            let rest = write_part(rest, &Rest { interval_ns, relaxation, thresholds })?;
            Some(MARK.len().saturating_add(measured).saturating_add(rest))
        });
        (record, length.unwrap_or(0))
    }

    /// Settings from a record of any release, and what became of them.
    #[must_use]
    pub fn from_record(record: &[u8]) -> (Self, Kept) {
        Self::of_release_0_1(record)
            .map(|settings| (settings, Kept::All))
            .or_else(|| Self::of_parts(record.strip_prefix(&MARK)?))
            .unwrap_or((Self::DEFAULT, Kept::Discarded))
    }

    fn of_release_0_1(record: &[u8]) -> Option<Self> {
        let all: SettingsByRatio = postcard::from_bytes(record.strip_prefix(&RELEASE_0_1)?).ok()?;
        Some(all.settings(SettingsByRatio::CLOCK_HZ))
    }

    fn of_parts(parts: &[u8]) -> Option<(Self, Kept)> {
        let (measured, parts) = read_part::<Measured>(parts)?;
        let Measured { gain, calibration, tare } = measured?;
        let measured = Self { gain, calibration, tare, ..Self::DEFAULT };
        let Some((Some(Rest { interval_ns, relaxation, thresholds }), _)) = read_part(parts) else {
            return Some((measured, Kept::Calibration));
        };
        Some((Self { interval_ns, relaxation, thresholds, ..measured }, Kept::All))
    }
}

/// Writes version, length and content: how many bytes.
fn write_part(room: &mut [u8], part: &impl Serialize) -> Option<usize> {
    let ([version, length], content) = room.split_first_chunk_mut()?;
    let written = postcard::to_slice(part, content).ok()?.len();
    (*version, *length) = (VERSION, u8::try_from(written).ok()?);
    written.checked_add(2)
}

/// A part, none if its version is another, and what follows it.
fn read_part<'r, P: Deserialize<'r>>(record: &'r [u8]) -> Option<(Option<P>, &'r [u8])> {
    let ([version, length], content) = record.split_first_chunk()?;
    let (content, rest) = content.split_at_checked((*length).into())?;
    let part = if *version == VERSION { Some(postcard::from_bytes(content).ok()?) } else { None };
    Some((part, rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured() -> Settings {
        let mut settings = Settings { tare: [i32::MIN, -1, 0, i32::MAX], ..Settings::DEFAULT };
        settings.calibration[2].gain = 0.003_217;
        settings.gain[1] = 16;
        settings
    }

    #[test]
    fn a_record_gives_the_settings_back() {
        let settings = Settings { interval_ns: 256_000, ..measured() };
        let (record, length) = settings.record();
        assert_eq!(Settings::from_record(&record[..length]), (settings, Kept::All));
    }

    #[test]
    fn a_release_that_adds_a_setting_keeps_the_calibration_and_says_what_it_did_not() {
        let settings = Settings { interval_ns: 256_000, ..measured() };
        let (mut record, length) = settings.record();
        let rest = 4 + 2 + usize::from(record[5]);
        record[rest] = 2;
        assert_eq!(Settings::from_record(&record[..length]), (measured(), Kept::Calibration));
        // The same when there is more behind what we know.
        assert_eq!(Settings::from_record(&record[..rest]), (measured(), Kept::Calibration));
    }

    #[test]
    fn what_is_no_record_is_discarded_and_that_is_said() {
        let (record, length) = measured().record();
        for cut in 0..5 {
            assert_eq!(Settings::from_record(&record[..cut]), (Settings::DEFAULT, Kept::Discarded));
        }
        for at in 0..5 {
            let mut record = record;
            record[at] ^= 0x40;
            let (_, kept) = Settings::from_record(&record[..length]);
            assert_eq!(kept, Kept::Discarded);
        }
    }

    #[test]
    fn settings_that_release_0_1_saved_are_read() {
        let record = include_bytes!("../../../tests/golden/release-0.1/settings.bin");
        let (settings, kept) = Settings::from_record(record);
        let relaxation = Relaxation { c1: 0.25, v1: 4.0, c2: 0.27, v2: 0.5 };
        assert_eq!(
            (settings.gain, settings.relaxation, kept),
            ([64; GAUGES], relaxation, Kept::All)
        );
        assert_eq!(settings, Settings { relaxation, ..Settings::DEFAULT }.with_gain([64; GAUGES]));
    }
}
