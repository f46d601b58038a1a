//! The stretches in what one device said.

use std::collections::HashMap;

use shared::calibration::Calibration;
use shared::pipeline::GAUGES;
use shared::wire::{Block, Head as FrameHead, Hello, Rows, Settings, Source, ToHost};

use super::columns::{Origin, Stretch};
use super::pulses::Timing;
use crate::recording::{Clock, Entry, Gap, Note};

/// Who the device said it is.
#[derive(Clone)]
pub(super) struct Device {
    pub(super) board: String,
    pub(super) serial: String,
    pub(super) firmware: String,
    pub(super) git: String,
    pub(super) gauges: usize,
}

impl Device {
    fn of(hello: &Hello<'_>) -> Self {
        let serial = hello.serial.map(|word| format!("{word:08x}"));
        Self {
            board: hello.board.into(),
            serial: serial.concat(),
            firmware: hello.version.into(),
            git: hello.git.into(),
            gauges: hello.channels.into(),
        }
    }
}

/// What is known of one device at a point of the recording.
#[derive(Default)]
pub(super) struct Stream {
    opened_ns: u64,
    device: Option<Device>,
    settings: HashMap<u32, (Settings, [Calibration; GAUGES])>,
    /// Rows whose settings are not in the recording.
    pub(super) rows_unknown: u64,
    source: Option<Source>,
    arrived_us: Option<u64>,
    clock: Clock,
    /// When the shared line rose since the last stretch, µs of the device.
    pulses_us: Vec<u64>,
    stretch: Option<Stretch>,
    /// What ended, with how the clock of the device ran, or why that is not known.
    pub(super) ended: Vec<(Stretch, Result<Timing, &'static str>)>,
}

impl Stream {
    /// In a recording that was opened then, ns since 1970; 0 if that is not known.
    pub(super) fn begin(opened_ns: u64) -> Self {
        Self { opened_ns, ..Self::default() }
    }

    /// Takes what the device said, or what the host noted of it.
    pub(super) fn take(&mut self, entry: &Entry<'_>) {
        match entry {
            Entry::Note { note: Note::Gap(Gap::Reset | Gap::LinkLost | Gap::LinkBack), .. } => {
                self.end();
            }
            // Rows that were lost are seen by their numbers.
            Entry::Note { .. } => {}
            Entry::Frame { head, message, arrived_us } => {
                self.arrived_us = arrived_us.or(self.arrived_us);
                self.hear(*head, message);
                // Only now: if the device began anew, the stretch that this ended had the clock before.
                match *arrived_us {
                    Some(arrived_us) => {
                        if self.clock.hear(*head, message, arrived_us) {
                            self.pulses_us.clear();
                        }
                    }
                    None => self.clock.overhear(message),
                }
                if let ToHost::Pulse { time_us } = message {
                    self.pulses_us.push(*time_us);
                }
            }
        }
    }

    fn hear(&mut self, head: FrameHead, message: &ToHost<'_>) {
        match message {
            ToHost::Hello(hello) => {
                self.end();
                self.device = Some(Device::of(hello));
                self.settings.clear();
                self.source = None;
            }
            ToHost::Settings { generation, settings } => self.set(*generation, settings),
            ToHost::Status(status) => self.source = status.streaming,
            ToHost::Samples(block) => self.hear_rows(head, block),
            // Events follow from the rows.
            ToHost::Answer(_) | ToHost::Log(_) | ToHost::Kept(_) | ToHost::Event(_) => {}
            ToHost::Converter { .. } | ToHost::Pulse { .. } => {}
            // The reader gives these in the words of this release.
            ToHost::SettingsByRatio { .. } | ToHost::StatusOfFour(_) | ToHost::SamplesOfFour(_) => {
            }
        }
    }

    fn set(&mut self, generation: u32, settings: &Settings) {
        let calibrated = calibration(settings).map(|gauges| (*settings, gauges));
        self.settings.extend(calibrated.map(|settings| (generation, settings)));
    }

    fn hear_rows(&mut self, head: FrameHead, block: &Block<'_>) {
        // A block that passed its CRC and contradicts itself was made so; its rows are lost as others are.
        let Ok(rows) = Rows::decode(head, block) else { return };
        let Some((settings, calibration)) = self.settings.get(&rows.generation).copied() else {
            self.rows_unknown += rows.len() as u64;
            return;
        };
        for row in rows.iter(&calibration) {
            let goes_on = |stretch: &Stretch| stretch.goes_on(rows.generation, &row);
            if !self.stretch.as_ref().is_some_and(goes_on) {
                self.end();
                self.stretch = Some(Stretch::new(Origin {
                    device: self.device.clone(),
                    generation: rows.generation,
                    settings,
                    start_s: self.start_s(),
                }));
            }
            if let Some(stretch) = &mut self.stretch {
                stretch.push(&row, rows.temperature);
            }
        }
    }

    /// When the last noted message arrived, s since 1970, if the recording says when it was opened.
    fn start_s(&self) -> Option<f64> {
        let arrived_us = self.arrived_us.filter(|_| self.opened_ns > 0)?;
        Some(self.opened_ns as f64 * 1e-9 + arrived_us as f64 * 1e-6)
    }

    /// Ends the stretch; one row is none.
    pub(super) fn end(&mut self) {
        if let Some(stretch) = self.stretch.take().filter(|stretch| stretch.len() > 1) {
            self.ended.push((stretch, self.relation()));
            self.pulses_us.clear();
        }
    }

    /// How the clock of the device runs, or why that is not known.
    fn relation(&self) -> Result<Timing, &'static str> {
        match self.source {
            Some(Source::Link { .. }) => {
                Err("its rows were injected and carry a time of their own")
            }
            _ => {
                let fit = self.clock.fit().ok_or("too few messages came")?;
                Ok(Timing { fit, pulses_us: self.pulses_us.clone() })
            }
        }
    }
}

/// What made strain of counts; none if the device could not have said so.
fn calibration(settings: &Settings) -> Option<[Calibration; GAUGES]> {
    let gauges = settings.calibration.iter().zip(settings.tare);
    let calibrated =
        gauges.map(|(sheet, tare)| Some(Calibration::new(sheet).ok()?.with_tare(tare)));
    calibrated.collect::<Option<Vec<_>>>()?.try_into().ok()
}
