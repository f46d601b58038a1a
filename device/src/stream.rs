//! From samples to blocks of rows.

use heapless::Deque;
use shared::pipeline::{Config, Counters, GAUGES, Pipeline};
use shared::wire::{BLOCK_ROWS, CodingError, Column, Inject, REFERENCE_TEMPERATURE, Source, Start};

use crate::blocks::Blocks;

/// Injected rows that may wait for the filter.
pub const INJECTED_ROWS: usize = 2 * BLOCK_ROWS;

/// A block of live rows is sent when it spans this, µs, even if more rows would fit.
const SPAN_US: u64 = 12_000;

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
    /// Never seen.
    pub missed: u32,
    /// Damaged on the bus.
    pub damaged: u32,
    /// Found the queue to the filter full.
    pub queue_full: u32,
}

impl Lost {
    fn all(self) -> u64 {
        u64::from(self.missed)
            .saturating_add(u64::from(self.damaged))
            .saturating_add(u64::from(self.queue_full))
    }
}

/// The stream that is on, or the last one.
#[derive(Debug)]
pub(crate) struct Stream<'a> {
    pipeline: Pipeline,
    pub(crate) blocks: &'a mut Blocks,
    injected: Deque<([i32; GAUGES], Option<i16>), INJECTED_ROWS>,
    on: Option<Start>,
    next_row: u64,
    /// Device time of the last row, µs.
    last_us: u64,
    /// Rows in the block at the last tick.
    seen_waiting: usize,
    pub(crate) generation: u32,
    /// Rows that found no room on their way to the link.
    pub(crate) link_full: u32,
}

impl<'a> Stream<'a> {
    pub(crate) const fn new(pipeline: Pipeline, blocks: &'a mut Blocks) -> Self {
        Self {
            pipeline,
            blocks,
            injected: Deque::new(),
            on: None,
            next_row: 0,
            last_us: 0,
            seen_waiting: 0,
            generation: 0,
            link_full: 0,
        }
    }

    pub(crate) fn start(&mut self, start: Start, config: &Config) {
        self.pipeline = Pipeline::new(config);
        self.blocks.clear();
        self.injected.clear();
        (self.on, self.next_row, self.last_us, self.seen_waiting) = (Some(start), 0, 0, 0);
    }

    pub(crate) fn stop(&mut self) {
        self.close();
        self.on = None;
    }

    pub(crate) fn source(&self) -> Option<Source> {
        self.on.map(|start| start.source)
    }

    pub(crate) fn rows(&self) -> u64 {
        self.next_row
    }

    pub(crate) fn gauges(&self) -> [Counters; GAUGES] {
        self.pipeline.counters()
    }

    pub(crate) fn pipeline(&mut self) -> &mut Pipeline {
        &mut self.pipeline
    }

    /// A sample of the converter, at a temperature.
    #[inline]
    pub(crate) fn sample(&mut self, sample: &Sample, temperature: Option<i16>) {
        if sample.lost != Lost::default() {
            // A block has no gaps.
            self.close();
            self.next_row = self.next_row.saturating_add(sample.lost.all());
        }
        self.row(sample.time_us, sample.counts, temperature);
    }

    /// Takes injected rows into the queue: how many found room, how many did not.
    ///
    /// # Errors
    /// [`CodingError`] if they cannot be read; then none is taken.
    pub(crate) fn inject(&mut self, inject: &Inject<'_>) -> Result<(u8, u8), CodingError> {
        let rows = usize::from(inject.rows);
        let (counts, left) = Column::<GAUGES>::unpack(inject.counts, rows)?;
        if !left.is_empty() {
            return Err(CodingError::Length);
        }
        let mut taken = 0_u8;
        for counts in counts.iter().take(rows) {
            if self.injected.push_back((counts, inject.temperature)).is_ok() {
                taken = taken.saturating_add(1);
            }
        }
        Ok((taken, inject.rows.saturating_sub(taken)))
    }

    /// Numbers go on where injected rows found no room. They are lost behind those that wait, so those come first.
    pub(crate) fn skip(&mut self, rows: u8) {
        if rows > 0 {
            while self.injected() {}
            self.close();
            self.next_row = self.next_row.saturating_add(u64::from(rows));
        }
    }

    /// Room for injected rows.
    pub(crate) fn room(&self) -> u8 {
        INJECTED_ROWS.saturating_sub(self.injected.len()) as u8
    }

    /// Takes one injected row from the queue; whether there was one.
    pub(crate) fn injected(&mut self) -> bool {
        let Some(Source::Link { interval_ns }) = self.source() else { return false };
        let Some((counts, temperature)) = self.injected.pop_front() else { return false };
        let time_us = self.next_row.saturating_mul(u64::from(interval_ns)) / 1_000;
        self.row(time_us, counts, temperature);
        true
    }

    fn row(&mut self, time_us: u64, counts: [i32; GAUGES], temperature: Option<i16>) {
        let Some(Start { columns, source }) = self.on else { return };
        let used = temperature.unwrap_or(REFERENCE_TEMPERATURE);
        self.pipeline.process(&counts, used);
        let mut rows = self.blocks.filling();
        if rows.temperature != temperature {
            // A block has one temperature.
            self.close();
            rows = self.blocks.filling();
        }
        if rows.is_empty() {
            rows.begin(columns, self.next_row, time_us, self.last_us);
            (rows.generation, rows.temperature) = (self.generation, temperature);
        }
        self.last_us = time_us;
        rows.push(time_us, counts, &self.pipeline);
        self.next_row = self.next_row.wrapping_add(1);
        let late = source == Source::Converter && rows.span_us() >= SPAN_US;
        if rows.is_full() || late {
            self.close();
        }
    }

    /// Sends what waits; without room it is lost and counted.
    pub(crate) fn close(&mut self) {
        let lost = self.blocks.close();
        self.link_full = self.link_full.saturating_add(lost as u32);
    }

    /// Rows that nothing follows are not kept waiting for long.
    pub(crate) fn tick(&mut self) {
        let waiting = self.blocks.filling().len();
        if waiting > 0 && waiting == self.seen_waiting {
            self.close();
        }
        self.seen_waiting = self.blocks.filling().len();
    }
}
