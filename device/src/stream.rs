//! From samples to blocks of rows.

use heapless::{Deque, Vec};
use shared::events;
use shared::pipeline::{Config, Counters, GAUGES, Pipeline};
use shared::wire::{self, CodingError, INJECT_ROWS, Inject, REFERENCE_TEMPERATURE, Source, Start};

use crate::conversation::Exchange;
use crate::room::Room;

/// Injected rows that may wait for the filter.
pub const INJECTED_ROWS: usize = 2 * INJECT_ROWS;

/// A block of live rows is sent when it spans this, µs, even if more rows would fit.
const SPAN_US: u32 = 20_000;

/// A conversion of all gauges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Device time at which it was ready, µs.
    pub time_us: u64,
    /// Counts, gauge by gauge; 24 bits.
    pub counts: [i32; GAUGES],
    /// What was lost since the sample before.
    pub lost: Lost,
}

/// Conversions that were lost between two samples, by cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Lost {
    /// Never seen, or not to be used because the converter was settling.
    pub missed: u32,
    /// Damaged on the bus.
    pub damaged: u32,
    /// Found the queue to the filter full.
    pub queue_full: u32,
    /// Whether gains or rate were exchanged between the two samples, so that they were given up for it.
    pub exchanged: bool,
}

impl Lost {
    /// Nothing.
    pub const NONE: Self = Self { missed: 0, damaged: 0, queue_full: 0, exchanged: false };

    pub(crate) fn all(self) -> u64 {
        u64::from(self.missed)
            .saturating_add(u64::from(self.damaged))
            .saturating_add(u64::from(self.queue_full))
    }
}

/// The stream that is on, or the last one.
#[derive(Debug)]
pub(crate) struct Stream<'a> {
    pipeline: Pipeline,
    pub(crate) room: &'a mut Room,
    /// Gauges of its rows.
    gauges: u8,
    injected: Deque<([i32; GAUGES], Option<i16>), INJECTED_ROWS>,
    on: Option<Start>,
    /// Of what comes next, 2^-8 °C, and what is taken for it where there is no sensor.
    temperature: Option<i16>,
    used_temperature: i16,
    /// Device time of the last row before the block that is filled, µs.
    last_us: u64,
    /// Number of the first row of the block that is filled.
    first: u64,
    /// A block is sent when it spans this, µs.
    span_us: u32,
    /// Rows in the block at the last tick.
    seen_waiting: usize,
    pub(crate) generation: u32,
    /// Rows that found no room on their way to the link.
    pub(crate) link_full: u32,
}

impl<'a> Stream<'a> {
    pub(crate) const fn new(pipeline: Pipeline, room: &'a mut Room) -> Self {
        Self {
            pipeline,
            room,
            gauges: GAUGES as u8,
            injected: Deque::new(),
            on: None,
            temperature: None,
            used_temperature: REFERENCE_TEMPERATURE,
            last_us: 0,
            first: 0,
            span_us: 0,
            seen_waiting: 0,
            generation: 0,
            link_full: 0,
        }
    }

    /// Rows are of so many gauges from now on; those that wait and are of another number are lost on their way.
    pub(crate) fn set_gauges(&mut self, gauges: u8) {
        if gauges != self.gauges {
            self.close();
            let lost = self.room.blocks.set_gauges(gauges);
            self.link_full = self.link_full.saturating_add(lost as u32);
            self.gauges = gauges;
        }
    }

    pub(crate) fn start(&mut self, start: Start, config: &Config, events: Option<events::Config>) {
        self.pipeline = Pipeline::new(config);
        self.room.feeling.begin(events);
        self.room.blocks.clear();
        self.injected.clear();
        (self.on, self.first, self.seen_waiting) = (Some(start), 0, 0);
        self.span_us = if start.source == Source::Converter { SPAN_US } else { u32::MAX };
    }

    pub(crate) fn stop(&mut self) {
        self.close();
        self.on = None;
    }

    pub(crate) fn source(&self) -> Option<Source> {
        self.on.map(|start| start.source)
    }

    /// Rows since the start, lost ones too.
    pub(crate) fn rows(&self) -> u64 {
        self.first.saturating_add(self.room.blocks.filled() as u64)
    }

    pub(crate) fn gauges(&self) -> [Counters; GAUGES] {
        self.pipeline.counters()
    }

    pub(crate) const fn pipeline(&self) -> &Pipeline {
        &self.pipeline
    }

    /// Another configuration from the next row on.
    pub(crate) fn configure(&mut self, config: &Config) {
        let recalibrated = config.calibration != self.pipeline.config().calibration;
        self.pipeline.configure(config);
        if recalibrated {
            self.room.feeling.begin_anew();
        }
    }

    /// Another configuration together with gains or rate of the converter, from the next row on.
    pub(crate) fn exchange(&mut self, exchange: &Exchange) {
        self.pipeline.exchange(&exchange.config, exchange.same_strain);
        self.room.feeling.configure(exchange.events, exchange.same_strain);
    }

    /// Reads zero from now on.
    pub(crate) fn tare(&mut self) {
        self.pipeline.tare();
        self.room.feeling.begin_anew();
    }

    /// Rows that are lost before the next one. A block has no gaps.
    pub(crate) fn lose(&mut self, rows: u64) {
        self.close();
        self.first = self.first.saturating_add(rows);
    }

    /// Takes injected rows into the queue: how many found room, how many did not.
    ///
    /// # Errors
    /// [`CodingError`] if they cannot be read; then none is taken.
    pub(crate) fn inject(&mut self, inject: &Inject<'_>) -> Result<(u8, u8), CodingError> {
        let mut rows = Vec::<_, INJECT_ROWS>::new();
        for counts in wire::unpack(inject.counts, self.gauges) {
            rows.push(counts?).map_err(|_| CodingError)?;
        }
        let (mut taken, mut lost) = (0_u8, 0_u8);
        for counts in rows {
            match self.injected.push_back((counts, inject.temperature)) {
                Ok(()) => taken = taken.saturating_add(1),
                Err(_) => lost = lost.saturating_add(1),
            }
        }
        Ok((taken, lost))
    }

    /// Numbers go on where injected rows found no room. They are lost behind those that wait, so those come first.
    pub(crate) fn skip(&mut self, rows: u8) {
        if rows > 0 {
            while self.process_injected() {}
            self.lose(rows.into());
        }
    }

    /// Room for injected rows.
    pub(crate) fn room(&self) -> u8 {
        INJECTED_ROWS.saturating_sub(self.injected.len()) as u8
    }

    /// Takes one injected row from the queue if blocks are not held up: unlike a converter's, injected rows can wait, and so
    /// does a host that looks at the room they leave. Whether there was one.
    pub(crate) fn injected(&mut self) -> bool {
        self.room.blocks.has_room() && self.process_injected()
    }

    /// Whether injected rows wait.
    pub(crate) fn has_injected(&self) -> bool {
        !self.injected.is_empty()
    }

    /// Takes one injected row from the queue, whatever becomes of its block.
    pub(crate) fn process_injected(&mut self) -> bool {
        let Some(Source::Link { interval_ns }) = self.source() else { return false };
        let Some((counts, temperature)) = self.injected.pop_front() else { return false };
        let time_us = self.rows().saturating_mul(u64::from(interval_ns)) / 1_000;
        self.set_temperature(temperature);
        self.row(&counts, time_us);
        if self.injected.is_empty() {
            self.close();
        }
        true
    }

    /// What comes next is of another temperature, 2^-8 °C; none without a sensor. A block has one temperature.
    pub(crate) fn set_temperature(&mut self, temperature: Option<i16>) {
        if temperature != self.temperature {
            self.close();
            self.temperature = temperature;
        }
        self.used_temperature = temperature.unwrap_or(REFERENCE_TEMPERATURE);
    }

    /// A row of counts, while the stream is on.
    #[inline(never)]
    pub(crate) fn row(&mut self, counts: &[i32; GAUGES], time_us: u64) {
        self.pipeline.process(counts, self.used_temperature);
        if let Some(event) = self.room.feeling.step(&self.pipeline) {
            self.room.feeling.note(event, self.rows(), time_us);
        }
        let mut rows = self.room.blocks.filling();
        if rows.is_empty() {
            self.begin(time_us);
            rows = self.room.blocks.filling();
        }
        if !rows.push(time_us, counts, &self.pipeline) {
            return self.push_into_next(time_us, counts);
        }
        if rows.span_us() >= self.span_us {
            self.close();
        }
    }

    /// A block that a row does not fit into is sent; the next one has room for any row.
    #[cold]
    #[inline(never)]
    fn push_into_next(&mut self, time_us: u64, counts: &[i32; GAUGES]) {
        self.begin(time_us);
        let _ = self.room.blocks.filling().push(time_us, counts, &self.pipeline);
    }

    #[cold]
    #[inline(never)]
    fn begin(&mut self, time_us: u64) {
        self.close();
        let Some(start) = self.on else { return };
        let rows = self.room.blocks.filling();
        rows.begin(start.columns, self.first, time_us, self.last_us);
        (rows.generation, rows.temperature) = (self.generation, self.temperature);
    }

    /// Sends what waits; without room it is lost and counted.
    #[cold]
    #[inline(never)]
    pub(crate) fn close(&mut self) {
        if self.room.blocks.filled() > 0 {
            self.first = self.rows();
            self.last_us = self.room.blocks.filling().last_us();
            let lost = self.room.blocks.close();
            self.link_full = self.link_full.saturating_add(lost as u32);
        }
    }

    /// Rows that nothing follows are not kept waiting for long.
    pub(crate) fn tick(&mut self) {
        let waiting = self.room.blocks.filled();
        if waiting > 0 && waiting == self.seen_waiting {
            self.close();
        }
        self.seen_waiting = self.room.blocks.filled();
    }
}
