//! The rows of a stretch as the columns of a trace.

use shared::fixed::{celsius, microstrain};
use shared::pipeline::GAUGES;
use shared::wire::{Row, Settings};
use toml::{Table, Value};

use super::stream::Device;
use crate::recording::ClockFit;
use crate::{Column, Head, Setup, TEMPERATURE, Trace};

/// Where a stretch comes from.
pub(super) struct Origin {
    pub device: Option<Device>,
    /// Which settings it was made with, and they.
    pub generation: u32,
    pub settings: Settings,
    /// When it began, s since 1970.
    pub start_s: Option<f64>,
}

/// Consecutive rows of one stream under one setting.
pub(super) struct Stretch {
    origin: Origin,
    /// Rows missing between the first and the last.
    pub rows_lost: u64,
    /// Of each row, its number and its device time, µs.
    numbers: Vec<u64>,
    time_us: Vec<u64>,
    gauges: [Gauge; GAUGES],
    /// °C; empty if any row has none.
    temperature: Vec<f64>,
}

/// One gauge, row by row; strains in µε.
#[derive(Default)]
struct Gauge {
    strain: Vec<f64>,
    fa: Vec<f64>,
    sa: Vec<f64>,
    /// Empty if they were not asked for.
    elastic: Vec<f64>,
    equilibrium: Vec<f64>,
    counts: Vec<f64>,
    region: Vec<f64>,
    relaxation: Vec<f64>,
    flags: Vec<f64>,
    /// The row at which the present region was entered. A boundary that is found later never lies before it.
    entered: usize,
}

impl Stretch {
    pub fn new(origin: Origin) -> Self {
        Self {
            origin,
            rows_lost: 0,
            numbers: Vec::new(),
            time_us: Vec::new(),
            gauges: std::array::from_fn(|_| Gauge::default()),
            temperature: Vec::new(),
        }
    }

    /// Rows so far.
    pub fn len(&self) -> usize {
        self.numbers.len()
    }

    /// Whether a row may follow: same settings and columns, later number and time.
    pub fn goes_on(&self, generation: u32, row: &Row) -> bool {
        let later = |before: Option<&u64>, now: u64| before.is_none_or(|before| *before < now);
        let same_columns = self.gauges[0].elastic.is_empty() == row.rest.is_none();
        generation == self.origin.generation
            && same_columns
            && later(self.numbers.last(), row.number)
            && later(self.time_us.last(), row.time_us)
    }

    pub fn push(&mut self, row: &Row, temperature: Option<i16>) {
        if let Some(last) = self.numbers.last() {
            self.rows_lost = self.rows_lost.saturating_add(row.number - last - 1);
        }
        if let Some(temperature) = temperature.filter(|_| self.temperature.len() == self.len()) {
            self.temperature.push(celsius(temperature));
        }
        self.numbers.push(row.number);
        self.time_us.push(row.time_us);
        for (gauge, columns) in self.gauges.iter_mut().enumerate() {
            let entered = row.entered[gauge].map(|ago| row.number.saturating_sub(ago.into()));
            let since = entered.map(|since| self.numbers.partition_point(|row| *row < since));
            columns.push(row, gauge, since);
        }
    }

    /// Device time of the first row, µs.
    pub fn first_us(&self) -> u64 {
        self.time_us.first().copied().unwrap_or_default()
    }

    /// The stretch as a trace in device time, s since its first row; of several devices that share a recording, by its number.
    pub fn into_trace(self, name: String, clock: Option<&ClockFit>, device: Option<u32>) -> Trace {
        let head = self.head(name, clock, device);
        let rows = self.len();
        let first = self.first_us();
        let time = self.time_us.iter().map(|time_us| (time_us - first) as f64 / 1e6).collect();
        // What is read of a row holds zeros for gauges that the device does not have.
        let there = self.origin.device.map_or(GAUGES, |device| device.gauges);
        let gauges = (1..).zip(self.gauges).take(there);
        let mut columns: Vec<Column> =
            gauges.flat_map(|(number, gauge)| gauge.into_columns(number)).collect();
        columns.push(Column { name: TEMPERATURE.into(), values: self.temperature });
        columns.retain(|column| column.values.len() == rows);
        Trace { path: None, head, time, columns }
    }

    fn head(&self, name: String, clock: Option<&ClockFit>, device: Option<u32>) -> Head {
        let mut setup = Setup { start_s: self.origin.start_s, ..Setup::default() };
        setup.other.insert("rate_Hz".into(), self.rate_hz().into());
        let mut recording = Table::new();
        if let Some(number) = device {
            recording.insert("device".into(), i64::from(number).into());
        }
        let lost = i64::try_from(self.rows_lost).unwrap_or(i64::MAX);
        recording.insert("rows_lost".into(), lost.into());
        let provisional = i64::try_from(self.provisional_rows()).unwrap_or(i64::MAX);
        recording.insert("region_provisional_rows".into(), provisional.into());
        if let Some(clock) = clock.filter(|clock| clock.standard_error_ppm.is_finite()) {
            let thousandths = |ppm: f64| Value::Float((ppm * 1e3).round() / 1e3);
            recording.insert("clock_ppm".into(), thousandths(clock.ppm()));
            let error = thousandths(clock.standard_error_ppm);
            recording.insert("clock_standard_error_ppm".into(), error);
        }
        let mut other = Table::new();
        other.insert("recording".into(), recording.into());
        other.insert("device".into(), self.device().into());
        Head { name: Some(name), setup, other, ..Head::default() }
    }

    /// Who made it, and with which settings.
    fn device(&self) -> Table {
        let mut table = Table::new();
        if let Some(device) = &self.origin.device {
            for (key, value) in [
                ("board", &device.board),
                ("serial", &device.serial),
                ("firmware", &device.firmware),
                ("git", &device.git),
            ] {
                table.insert(key.into(), value.clone().into());
            }
        }
        if let Ok(settings) = Value::try_from(self.origin.settings) {
            table.insert(super::SETTINGS.into(), settings);
        }
        table
    }

    /// Rows at the end whose regions might have been corrected had the recording gone on: those since the last boundary.
    fn provisional_rows(&self) -> usize {
        let entered = self.gauges.iter().map(|gauge| gauge.entered).min();
        self.len() - entered.unwrap_or_default()
    }

    /// Rows in a second of the device, lost ones too.
    fn rate_hz(&self) -> f64 {
        let span = |values: &[u64]| match values {
            [first, .., last] => (last - first) as f64,
            _ => 1.0,
        };
        span(&self.numbers) / span(&self.time_us) * 1e6
    }
}

impl Gauge {
    /// Appends what a row says of this gauge; `since` is the row at which the region was entered that was found here.
    fn push(&mut self, row: &Row, gauge: usize, since: Option<usize>) {
        let (fa, sa, state) = (row.fa[gauge], row.sa[gauge], row.states[gauge]);
        self.strain.push(microstrain(fa.wrapping_add(sa)));
        self.fa.push(microstrain(fa));
        self.sa.push(microstrain(sa));
        if let Some((elastic, equilibrium)) = row.rest {
            self.elastic.push(microstrain(elastic[gauge]));
            self.equilibrium.push(microstrain(equilibrium[gauge]));
        }
        self.counts.push(row.counts[gauge].into());
        let region = f64::from(state.region as u8);
        self.region.push(region);
        if let Some(late) = since.and_then(|since| self.region.get_mut(since..)) {
            let late_rows = late.len();
            late.fill(region);
            self.entered = self.region.len() - late_rows;
        }
        self.relaxation.push(f64::from(state.relaxation as u8));
        self.flags.push(f64::from(state.flags.bits()));
    }

    fn into_columns(self, number: usize) -> impl Iterator<Item = Column> {
        [
            ("ustrain", self.strain),
            ("fa_ustrain", self.fa),
            ("sa_ustrain", self.sa),
            ("elastic_ustrain", self.elastic),
            ("equilibrium_ustrain", self.equilibrium),
            ("counts", self.counts),
            ("region", self.region),
            ("relaxation", self.relaxation),
            ("flags", self.flags),
        ]
        .into_iter()
        .map(move |(name, values)| Column { name: format!("gauge{number}_{name}"), values })
    }
}
