//! What each command does.

use shared::pipeline::{Config, GAUGES};
use shared::wire::{
    ConverterFault, Done, Inject, Inputs, PerGauge, Refusal, Settings, SettingsError, Source,
    Start, ToDevice,
};

use crate::board::{Board, Restart};
use crate::conversation::{Device, Exchange, Stopping};
use crate::felt;
use crate::front_end::Setting;
use crate::outgoing::Due;
use crate::self_test::SelfTest;

impl Device<'_> {
    /// Carries out a command; `None` if the answer comes later.
    pub(crate) fn carry_out(
        &mut self,
        command: &ToDevice<'_>,
        number: u32,
        now_us: u64,
        board: &mut impl Board,
    ) -> Result<Option<Done>, Refusal> {
        let settings = self.settings;
        match *command {
            // Answered before a command is read.
            ToDevice::Hello(_) => Ok(()),
            ToDevice::Start(start) => self.start(start, board),
            ToDevice::Stop => return self.stop(number, board).map(|()| None),
            ToDevice::SetRatio(oversampling) => {
                let ns = oversampling.interval_ns(self.identity.converter_clock_hz);
                self.convert(Settings { interval_ns: ns, ..settings }, board)
            }
            ToDevice::SetGain(PerGauge(gain)) => self.convert(settings.with_gain(gain), board),
            ToDevice::SetGainOfFour(gain) => {
                let mut all = settings.gain;
                all.iter_mut().zip(gain).for_each(|(own, gain)| *own = gain);
                self.convert(settings.with_gain(all), board)
            }
            ToDevice::SetFilter(relaxation) => self.apply(Settings { relaxation, ..settings }),
            ToDevice::SetThresholds(thresholds) => self.apply(Settings { thresholds, ..settings }),
            ToDevice::SetCalibration { gauge, sheet } => {
                let mut settings = settings;
                let at = usize::from(gauge);
                let sheets = settings.calibration.get_mut(at).zip(settings.tare.get_mut(at));
                sheets
                    .ok_or(Refusal::Gauge(gauge))
                    .map(|place| (*place.0, *place.1) = (sheet, 0))?;
                self.apply(settings)
            }
            ToDevice::Tare => self.tare(),
            ToDevice::Untare => self.apply(Settings { tare: [0; GAUGES], ..settings }),
            ToDevice::Save => self.save(board),
            ToDevice::LoadDefaults => self.convert(self.identity.capabilities.defaults(), board),
            ToDevice::Inject(inject) => return self.inject(&inject).map(Some),
            ToDevice::Settings => {
                self.outgoing.ask(Due::Settings);
                Ok(())
            }
            ToDevice::Status => {
                self.outgoing.ask(Due::Status);
                Ok(())
            }
            ToDevice::SelfTest => return self.test(number, Inputs::Gauges, now_us, board),
            ToDevice::TestInputs(inputs) => return self.test(number, inputs, now_us, board),
            ToDevice::SetInterval { ns } => {
                self.convert(Settings { interval_ns: ns, ..settings }, board)
            }
            ToDevice::Reboot => self.restart(Restart::Firmware, board),
            ToDevice::Bootloader => self.restart(Restart::Bootloader, board),
        }
        .map(|()| Some(Done::Carried))
    }

    fn idle(&self) -> Result<(), Refusal> {
        if self.stream.source().is_some() || self.test.is_some() {
            Err(Refusal::Streaming)
        } else {
            Ok(())
        }
    }

    fn start(&mut self, start: Start, board: &mut impl Board) -> Result<(), Refusal> {
        self.idle()?;
        let interval_s = match start.source {
            Source::Converter => self.settings.interval_s(),
            Source::Link { interval_ns: 0 } => return Err(Refusal::Interval),
            Source::Link { interval_ns } => f64::from(interval_ns) * 1e-9,
        };
        let config = self.settings.config(interval_s).map_err(refused)?;
        if start.source == Source::Converter {
            self.configure(&self.settings.clone(), Inputs::Gauges, board)?;
            self.count_lost(board.listen(true));
        }
        self.stream.start(start, &config, felt::config(interval_s));
        self.set_temperature(self.temperature);
        Ok(())
    }

    /// Ends the stream, with an answer when the samples on their way have become rows.
    fn stop(&mut self, number: u32, board: &mut impl Board) -> Result<(), Refusal> {
        self.stream.source().filter(|_| self.stopping.is_none()).ok_or(Refusal::NotStreaming)?;
        let lost = board.listen(false);
        while self.stream.process_injected() {}
        self.stopping = Some(Stopping { number, lost });
        Ok(())
    }

    /// Every sample that was let through has been given to [`Self::sample`]: ends a stream that is to end.
    pub fn drained(&mut self) {
        if let Some(Stopping { number, lost }) = self.stopping.take() {
            self.exchange();
            self.count_lost(lost);
            self.stream.stop();
            self.answer(number, Ok(Done::Carried));
        }
    }

    /// Settings that the converter must take too. Without one they are kept for when it is there.
    fn convert(&mut self, settings: Settings, board: &mut impl Board) -> Result<(), Refusal> {
        let config = self.config(&settings)?;
        self.suits(&settings)?;
        match self.configure(&settings, Inputs::Gauges, board) {
            Err(Refusal::Converter(ConverterFault::Missing)) | Ok(()) => {}
            refused => return refused,
        }
        if self.stream.source() == Some(Source::Converter) {
            // Samples of before may be on their way.
            let same_strain = self.settings.with_gain(settings.gain).calibration
                == settings.calibration
                && self.settings.tare == settings.tare
                && self.exchange.as_ref().is_none_or(|before| before.same_strain);
            let events = felt::config(self.interval_s(&settings));
            self.exchange = Some(Exchange { config, events, same_strain });
            self.settings = settings;
        } else {
            self.take(settings, &config);
        }
        Ok(())
    }

    /// Whether the converter has such a rate and such gains.
    fn suits(&self, settings: &Settings) -> Result<(), Refusal> {
        let capabilities = &self.identity.capabilities;
        if !capabilities.has_interval(settings.interval_ns) {
            return Err(self.without_rate());
        }
        let has_all = settings.gain.into_iter().all(|gain| capabilities.has_gain(gain));
        has_all.then_some(()).ok_or(Refusal::Gain)
    }

    fn configure(
        &mut self,
        settings: &Settings,
        inputs: Inputs,
        board: &mut impl Board,
    ) -> Result<(), Refusal> {
        let Settings { interval_ns, gain, .. } = *settings;
        let outcome = board.configure(Setting { interval_ns, gain, inputs });
        self.set_converter(outcome.err());
        outcome.map_err(Refusal::Converter)
    }

    /// Settings from the next sample on.
    fn apply(&mut self, settings: Settings) -> Result<(), Refusal> {
        let config = self.config(&settings)?;
        if let Some(exchange) = &mut self.exchange {
            // With the others that wait for their first sample.
            exchange.config = config;
            exchange.same_strain &= self.settings.calibration == settings.calibration
                && self.settings.tare == settings.tare;
            self.settings = settings;
        } else {
            self.take(settings, &config);
        }
        Ok(())
    }

    fn take(&mut self, settings: Settings, config: &Config) {
        self.stream.configure(config);
        self.settings = settings;
        self.changed();
    }

    /// The first sample of other gains or of another rate comes next.
    #[cold]
    pub(crate) fn exchange(&mut self) {
        if let Some(exchange) = self.exchange.take() {
            self.stream.exchange(&exchange);
            self.changed();
        }
    }

    /// Settings as the pipeline takes them, for the stream that is on.
    fn config(&self, settings: &Settings) -> Result<Config, Refusal> {
        settings.config(self.interval_s(settings)).map_err(refused)
    }

    /// What comes next is of other settings than what came before.
    fn changed(&mut self) {
        self.stream.close();
        self.stream.generation = self.stream.generation.wrapping_add(1);
        self.outgoing.ask(Due::Settings);
    }

    fn tare(&mut self) -> Result<(), Refusal> {
        self.stream.source().ok_or(Refusal::NotStreaming)?;
        if self.stream.rows() == 0 || self.exchange.is_some() {
            return Err(Refusal::NoSample);
        }
        self.stream.tare();
        self.settings.tare =
            self.stream.pipeline().config().calibration.map(|calibration| calibration.tare());
        self.changed();
        Ok(())
    }

    fn save(&mut self, board: &mut impl Board) -> Result<(), Refusal> {
        self.idle()?;
        let (record, length) = self.settings.record();
        let stored = board.store(record.get(..length).unwrap_or(&[]));
        stored.map_err(|fault| Refusal::Store(self.as_told(fault)))
    }

    fn inject(&mut self, inject: &Inject<'_>) -> Result<Done, Refusal> {
        match self.stream.source() {
            None => return Err(Refusal::NotStreaming),
            Some(Source::Converter) => return Err(Refusal::NotFromLink),
            Some(Source::Link { .. }) => {}
        }
        let taken = self.stream.inject(inject);
        let (taken, lost) = taken.map_err(|_| Refusal::Rows)?;
        self.stream.skip(lost);
        self.counters.queue_full = self.counters.queue_full.saturating_add(lost.into());
        Ok(Done::Injected { taken, lost, room: self.stream.room() })
    }

    fn test(
        &mut self,
        number: u32,
        inputs: Inputs,
        now_us: u64,
        board: &mut impl Board,
    ) -> Result<Option<Done>, Refusal> {
        self.idle()?;
        if inputs != Inputs::Gauges && self.identity.capabilities.test_counts == 0 {
            return Err(Refusal::NotHere);
        }
        self.configure(&self.settings.clone(), inputs, board)?;
        self.count_lost(board.listen(true));
        let interval_s = self.interval_s(&self.settings);
        self.test = Some(SelfTest::begin(number, now_us, interval_s));
        Ok(None)
    }

    fn restart(&mut self, into: Restart, board: &mut impl Board) -> Result<(), Refusal> {
        if !board.can_restart(into) {
            return Err(Refusal::NotHere);
        }
        self.restart = Some(into);
        Ok(())
    }
}

fn refused(error: SettingsError) -> Refusal {
    match error {
        SettingsError::Gain { .. } => Refusal::Gain,
        SettingsError::Calibration { .. } => Refusal::Calibration,
        SettingsError::Relaxation(_) => Refusal::Filter,
        SettingsError::Thresholds(_) => Refusal::Thresholds,
    }
}
