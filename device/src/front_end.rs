//! The converter and its data-ready line: what is read, what is lost, and what is done about a converter that fails.

use ads131m04::DrdyWatch;
use embedded_hal::delay::DelayNs;
use shared::pipeline::GAUGES;
use shared::wire::{Capabilities, ConverterFault, Inputs};

use crate::stream::{Lost, Sample};

/// So many conversions in a row that could not be read are a fault; fewer are noise on the wires.
const FAULTY: u8 = 16;
/// A converter that did not take its settings is tried again after this, µs.
const RETRY_US: u64 = 1_000_000;

/// How a converter is to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Time between two conversions, ns.
    pub interval_ns: u32,
    /// Gain of each gauge.
    pub gain: [u8; GAUGES],
    /// What it measures.
    pub inputs: Inputs,
}

/// Why a conversion could not be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadError {
    /// The converter was reset by something else and runs with settings of its own.
    SettingsLost,
    /// It has none that was not read before.
    Stale,
    /// Anything else.
    Fault(ConverterFault),
}

/// A converter of all gauges: what a driver must do to be one.
pub trait Converter {
    /// The name of the part.
    const PART: &'static str;

    /// What it can do; settings are of these.
    fn capabilities(&self) -> Capabilities;

    /// Resets it, which needs no answer of it.
    ///
    /// # Errors
    /// What is wrong with its line.
    fn reset(&mut self, delay: &mut impl DelayNs, setting: &Setting) -> Result<(), ConverterFault>;

    /// Checks that a converter that was reset is the right one, and sets it.
    ///
    /// # Errors
    /// What is wrong with it.
    fn begin(&mut self, delay: &mut impl DelayNs, setting: &Setting) -> Result<(), ConverterFault>;

    /// Sets it anew.
    ///
    /// # Errors
    /// What is wrong with it.
    fn configure(&mut self, setting: &Setting) -> Result<(), ConverterFault>;

    /// The conversion that is ready; 0 for gauges that it has no channel for.
    ///
    /// # Errors
    /// [`ReadError`].
    fn read(&mut self) -> Result<[i32; GAUGES], ReadError>;

    /// Forgets conversions that were not read in time.
    fn discard_stale(&mut self);
}

/// A converter, read once per edge of its data-ready line.
#[derive(Debug)]
pub struct FrontEnd<C, D> {
    converter: C,
    delay: D,
    watch: DrdyWatch,
    last_edge_us: u64,
    /// What it shall run with.
    wanted: Option<Setting>,
    /// Whether it took that.
    is_set: bool,
    /// Whether it was reset and may be begun.
    is_reset: bool,
    retry_us: u64,
    listening: bool,
    lost: Lost,
    /// Conversions until it has settled.
    settling: u8,
    /// Conversions in a row that could not be read.
    faulty: u8,
    fault: Option<ConverterFault>,
    /// Whether a sample came since the last look.
    heard: bool,
    /// Whether any came since it listens: what settles before is no loss.
    began: bool,
}

/// What a look at the front end found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    /// What is wrong with the converter.
    pub fault: Option<ConverterFault>,
    /// What was lost that no sample will tell soon.
    pub lost: Lost,
}

impl<C: Converter, D: DelayNs> FrontEnd<C, D> {
    /// A front end; nothing is sent to the converter before [`Self::configure`].
    pub const fn new(converter: C, delay: D) -> Self {
        Self {
            converter,
            delay,
            watch: DrdyWatch::new(u32::MAX, 0),
            last_edge_us: 0,
            wanted: None,
            is_set: false,
            is_reset: false,
            retry_us: 0,
            listening: false,
            lost: Lost::NONE,
            settling: 0,
            faulty: 0,
            fault: None,
            heard: false,
            began: false,
        }
    }

    /// What the converter can do.
    pub fn capabilities(&self) -> Capabilities {
        self.converter.capabilities()
    }

    /// Resets a converter that was not begun. [`Self::configure`] does it too, but then all at once.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn prepare(&mut self, setting: Setting) -> Result<(), ConverterFault> {
        if !self.is_set && !self.is_reset {
            self.converter.reset(&mut self.delay, &setting)?;
            self.is_reset = true;
        }
        Ok(())
    }

    /// Sets rate and gains; resets and checks the converter first if it was not begun.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn configure(&mut self, now_us: u64, setting: Setting) -> Result<(), ConverterFault> {
        let changes = self.wanted != Some(setting) || !self.is_set;
        self.wanted = Some(setting);
        let done = if self.is_set {
            self.converter.configure(&setting)
        } else {
            let reset = self.prepare(setting);
            self.is_reset = false;
            reset.and_then(|()| self.converter.begin(&mut self.delay, &setting))
        };
        self.is_set = done.is_ok();
        self.retry_us = now_us.saturating_add(RETRY_US);
        if changes {
            self.settling = self.converter.capabilities().settling;
        }
        self.lost.exchanged = self.listening;
        if !self.listening {
            self.last_edge_us = now_us;
        }
        self.faulty = 0;
        self.watch = DrdyWatch::new(setting.interval_ns, self.last_edge_us);
        done
    }

    /// Lets samples through from now on, or not: what was lost that no sample told.
    pub fn listen(&mut self, now_us: u64, listening: bool) -> Lost {
        self.listening = listening && self.is_set;
        if self.listening {
            // What it kept meanwhile is old.
            self.converter.discard_stale();
            self.edge(now_us);
            (self.fault, self.faulty, self.heard, self.began) = (None, 0, false, false);
            self.lost = Lost::NONE;
        }
        core::mem::take(&mut self.lost)
    }

    /// Whether samples are let through.
    #[must_use]
    pub const fn is_listening(&self) -> bool {
        self.listening
    }

    /// Whether an edge must come soon: samples are wanted, and nothing is known to be wrong.
    #[must_use]
    pub const fn expects_edges(&self) -> bool {
        self.listening && self.fault.is_none()
    }

    /// Answers an edge of the data-ready line: the sample, with what was lost before it.
    pub fn ready(&mut self, now_us: u64) -> Option<Sample> {
        if !self.listening || !self.is_set {
            return None;
        }
        let missed = self.edge(now_us);
        if missed > 0 {
            // Samples lie in wait in the converter, and its line is not to be relied upon until they are read.
            self.converter.discard_stale();
            return self.lose(missed.saturating_add(1));
        }
        match self.converter.read() {
            Ok(_) if self.settling > 0 => {
                self.settling = self.settling.saturating_sub(1);
                self.lose(self.began.into())
            }
            Ok(counts) => {
                (self.fault, self.faulty, self.heard, self.began) = (None, 0, true, true);
                let lost = core::mem::take(&mut self.lost);
                Some(Sample { time_us: now_us, counts, lost })
            }
            Err(error) => {
                // The first edge may be that of a conversion which was forgotten as old when listening began: no loss.
                let is_loss = self.began || error != ReadError::Stale;
                self.lost.damaged = self.lost.damaged.saturating_add(is_loss.into());
                self.note(error);
                None
            }
        }
    }

    /// A sample found the queue full: it is told with the next.
    pub fn found_queue_full(&mut self, sample: &Sample) {
        self.lost = sample.lost;
        self.lost.queue_full = self.lost.queue_full.saturating_add(1);
        self.heard = false;
    }

    /// Looks after a converter that says nothing: sets it anew when it has lost its settings, and counts the conversions
    /// that should have come. To be called every 10 ms or so.
    pub fn look_after(&mut self, now_us: u64) -> Found {
        if self.listening {
            self.set_again(now_us);
            let overdue = self.watch.overdue(now_us);
            if self.watch.is_stuck(now_us) {
                self.fault = self.fault.or(Some(ConverterFault::Stuck));
                self.lose(overdue);
                let interval_ns = self.wanted.map_or(0, |wanted| wanted.interval_ns);
                let counted_us = overdue.saturating_mul(interval_ns.into()) / 1_000;
                self.last_edge_us = self.last_edge_us.saturating_add(counted_us);
                self.watch = DrdyWatch::new(interval_ns, self.last_edge_us);
                // Its line stands still, too, while samples lie in wait.
                self.converter.discard_stale();
            }
        }
        // After a sample there may be others on their way that came before the loss: the next one tells it.
        let silent = !core::mem::replace(&mut self.heard, false);
        let lost = if silent { self.take_counts() } else { Lost::NONE };
        Found { fault: self.fault, lost }
    }

    fn set_again(&mut self, now_us: u64) {
        let Some(wanted) = self.wanted.filter(|_| !self.is_set && now_us >= self.retry_us) else {
            return;
        };
        if !self.is_reset {
            // The rest at the next look: nothing else waits for long.
            self.fault = self.prepare(wanted).err().or(self.fault);
            return;
        }
        // Nothing meant anything else before, so this is no exchange.
        let exchanged = self.lost.exchanged;
        self.fault = self.configure(now_us, wanted).err().or(self.fault);
        self.lost.exchanged = exchanged;
    }

    fn note(&mut self, error: ReadError) {
        match error {
            ReadError::SettingsLost => (self.is_set, self.retry_us) = (false, 0),
            ReadError::Stale => self.count_fault(ConverterFault::Damaged),
            ReadError::Fault(fault) => self.count_fault(fault),
        }
    }

    fn count_fault(&mut self, fault: ConverterFault) {
        self.faulty = self.faulty.saturating_add(1);
        if self.faulty >= FAULTY {
            self.fault = Some(fault);
        }
    }

    fn edge(&mut self, now_us: u64) -> u64 {
        self.last_edge_us = now_us;
        self.watch.edge(now_us)
    }

    fn lose(&mut self, conversions: u64) -> Option<Sample> {
        let conversions = u32::try_from(conversions).unwrap_or(u32::MAX);
        self.lost.missed = self.lost.missed.saturating_add(conversions);
        None
    }

    /// The losses, without what the next sample must tell itself.
    fn take_counts(&mut self) -> Lost {
        let exchanged = self.lost.exchanged;
        let lost = core::mem::replace(&mut self.lost, Lost { exchanged, ..Lost::NONE });
        Lost { exchanged: false, ..lost }
    }
}

#[cfg(test)]
mod tests;
