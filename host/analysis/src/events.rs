//! Touch, release and incipient slip in a recording, by the very code that runs on a device, and how soon they are told.

use shared::adaptation::{Output, Relaxation};
use shared::events::{Config, ConfigError, Kind, Settings, State};
use shared::pipeline::GAUGES;

use crate::decomposition::{Channel, DecompositionError, decompose, signals};
use palpate_trace::{GAUGES as NAMES, HAPPENED, Trace, noise, runs, sampling};

/// The name of a kind of event.
#[must_use]
pub const fn name(kind: Kind) -> &'static str {
    match kind {
        Kind::Touch => "touch",
        Kind::Release => "release",
        Kind::Slip => "slip",
    }
}

/// An event of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// What happened.
    pub kind: Kind,
    /// When it was told, s.
    pub told_s: f64,
    /// When it showed first in FA, s: as hindsight has it.
    pub began_s: f64,
    /// Which of the channels told it.
    pub channel: usize,
}

/// The events of one contact: of all gauges of a fingertip together, or of one other signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Events {
    /// The channels as the device's filter takes them apart.
    pub channels: Vec<Channel>,
    /// What was looked for, in the unit of the signals.
    pub settings: Settings,
    /// Noise of one sample, the largest standard deviation among the channels, in their unit; none where it cannot be told.
    pub noise: Option<f64>,
    /// Samples per second, by the median interval.
    pub rate_hz: f64,
    /// In the order in which they were told.
    pub found: Vec<Found>,
}

/// Settings that a caller insists on; the others follow from the signal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Asked {
    /// [`Settings::burst`].
    pub burst: Option<f64>,
    /// [`Settings::jolt`].
    pub jolt: Option<f64>,
    /// [`Settings::jolts`].
    pub jolts: Option<u8>,
    /// [`Settings::within_s`].
    pub within_s: Option<f64>,
    /// [`Settings::corner_hz`].
    pub corner_hz: Option<f64>,
}

/// Why no events can be looked for.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum EventsError {
    #[error(transparent)]
    Decomposition(#[from] DecompositionError),
    #[error("{trace} has fewer than two samples")]
    Short { trace: String },
    #[error("{trace}: {source}")]
    Settings { trace: String, source: ConfigError },
}

/// A level above this many standard deviations of what noise makes of FA is passed by noise less than once in an hour.
const BURST_OVER_NOISE: f64 = 8.0;
const JOLT_OVER_NOISE: f64 = 7.0;
/// Least levels for a signal that is no gauge, as parts of its span, once for FA of a step as high: a five-hundredth of it
/// is a touch.
const BURST_OF_SPAN: f64 = 0.005;
const JOLT_OF_SPAN: f64 = 0.001;

/// Looks for events in columns of a recording that feel one contact, at most [`GAUGES`] of them.
///
/// A gauge has the levels of [`Settings::DEFAULT`], any other signal parts of its span; both rise where the noise asks for
/// it. Slip is looked for where four samples fall on a period of the corner.
///
/// # Errors
/// [`EventsError`] for a column that is not there, a filter that cannot run, settings out of range.
pub fn events(
    trace: &Trace,
    signals: &[String],
    relaxation: &Relaxation,
    asked: &Asked,
) -> Result<Events, EventsError> {
    let split = |signal: &String| decompose(trace, signal, relaxation, || {});
    let channels = signals.iter().take(GAUGES).map(split).collect::<Result<Vec<_>, _>>()?;
    let rate_hz =
        sampling(&trace.time).ok_or_else(|| EventsError::Short { trace: trace.label() })?.rate_hz();
    let noise = signals
        .iter()
        .filter_map(|signal| Some(noise(trace, signal).ok()?.standard_deviation))
        .reduce(f64::max);
    let settings = settings(&channels, relaxation, noise.unwrap_or(0.0), rate_hz, asked);
    let refused = |source| EventsError::Settings { trace: trace.label(), source };
    let lsb = channels.first().map_or(1.0, |channel| channel.lsb);
    let config = Config::new(&settings, lsb, 1.0 / rate_hz).map_err(refused)?;
    let mut found = Vec::new();
    let at = |k: usize| -> [Output; GAUGES] {
        std::array::from_fn(|index| channels.get(index).map_or(SILENT, |it| output(it, k)))
    };
    for run in runs(&trace.time) {
        let mut state = State::at_rest(at(run.start).map(|output| output.equilibrium));
        for k in run.clone() {
            let Some(event) = state.step(&config, &at(k)) else { continue };
            let began = k.saturating_sub(event.began_samples_ago as usize).max(run.start);
            found.push(Found {
                kind: event.kind,
                told_s: trace.time[k],
                began_s: trace.time[began],
                channel: event.channel.into(),
            });
        }
    }
    Ok(Events { channels, settings, noise, rate_hz, found })
}

/// The columns of a recording that feel one contact, when none is named: all gauges together, or else the force.
///
/// # Errors
/// When there is neither.
pub fn contacts(trace: &Trace) -> Result<Vec<String>, EventsError> {
    Ok(signals(trace)?)
}

/// A gauge that is not there.
const SILENT: Output = Output { signal: 0, fa: 0, equilibrium: 0, elastic: 0 };

/// What the filter said of a sample, in its own numbers.
fn output(channel: &Channel, k: usize) -> Output {
    let counts = |values: &[f64]| (values[k] / channel.lsb).round() as i32;
    Output {
        signal: counts(&channel.input),
        fa: counts(&channel.fa),
        equilibrium: counts(&channel.equilibrium),
        elastic: counts(&channel.elastic),
    }
}

/// What to look for in a signal.
fn settings(
    channels: &[Channel],
    relaxation: &Relaxation,
    noise: f64,
    rate_hz: f64,
    asked: &Asked,
) -> Settings {
    let is_gauge = channels.iter().all(|channel| NAMES.contains(&channel.signal.as_str()));
    let lsb = channels.first().map_or(1.0, |channel| channel.lsb);
    let mut chosen = Settings { only_up: !is_gauge, ..Settings::DEFAULT };
    chosen.corner_hz = asked.corner_hz.unwrap_or(chosen.corner_hz);
    chosen.within_s = asked.within_s.unwrap_or(chosen.within_s);
    chosen.jolts = asked.jolts.unwrap_or(chosen.at_interval(1.0 / rate_hz).jolts);
    let (smoothed, jolting) = gains(&chosen, rate_hz);
    let fa_noise = relaxation.c1 * noise;
    let least = if is_gauge {
        (chosen.burst, chosen.jolt)
    } else {
        let spans = channels.iter().map(|channel| span(&channel.input));
        let span = relaxation.c1 * spans.fold(0.0, f64::max);
        (span * BURST_OF_SPAN, span * JOLT_OF_SPAN)
    };
    let burst = least.0.max(BURST_OVER_NOISE * smoothed * fa_noise).max(lsb);
    let jolt = least.1.max(JOLT_OVER_NOISE * jolting * fa_noise).max(lsb);
    Settings { burst: asked.burst.unwrap_or(burst), jolt: asked.jolt.unwrap_or(jolt), ..chosen }
}

fn span(values: &[f64]) -> f64 {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    (high - low).max(0.0)
}

/// What white noise of FA keeps, as a standard deviation, once smoothed and once as vibration.
fn gains(settings: &Settings, rate_hz: f64) -> (f64, f64) {
    let share = |time_constants: f64| -(-time_constants).exp_m1();
    let smoothing = share(1.0 / (rate_hz * settings.smoothing_s).max(1e-9));
    let corner = share(std::f64::consts::TAU * settings.corner_hz / rate_hz);
    let mut levels = [0.0; 3];
    let mut power = 0.0;
    for k in 0..10_000 {
        let mut rest = if k == 0 { 1.0 } else { 0.0 };
        for level in &mut levels {
            *level += corner * (rest - *level);
            rest -= *level;
        }
        power += rest * rest;
    }
    ((smoothing / (2.0 - smoothing)).sqrt(), power.sqrt())
}

/// The relaxation function that the device of a recording was set to, if its head says so.
#[must_use]
pub fn relaxation_of_device(trace: &Trace) -> Option<Relaxation> {
    let settings = trace.head.other.get("device")?.get("settings")?;
    settings.get("relaxation")?.clone().try_into().ok()
}

/// What a simulated recording says happened, with its time, s, in order.
#[must_use]
pub fn happened(trace: &Trace) -> Vec<(Kind, f64)> {
    let list = trace.head.setup.other.get(HAPPENED).and_then(toml::Value::as_array);
    let entry = |entry: &toml::Value| {
        let kind = match entry.get("kind")?.as_str()? {
            "touch" => Kind::Touch,
            "release" => Kind::Release,
            "slip" => Kind::Slip,
            _ => return None,
        };
        Some((kind, entry.get("time_s")?.as_float()?))
    };
    let mut found: Vec<(Kind, f64)> = list.into_iter().flatten().filter_map(entry).collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    found
}

/// How events compare with what happened.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judged {
    /// For everything that happened, in order: how long after it was told, s; none if it never was.
    pub delay_s: Vec<(Kind, Option<f64>)>,
    /// Events that nothing lies behind: their place among those found.
    pub false_alarms: Vec<usize>,
}

/// An event is that of what happened at most so long before, s, or this little after.
const AT_MOST_S: f64 = 1.0;
const AHEAD_S: f64 = 0.005;

/// Puts events beside what happened. One that is told belongs to the last of its kind before; a slip may be told again for
/// as long as it goes on, that is until the contact is let go of.
#[must_use]
pub fn judge(happened: &[(Kind, f64)], found: &[Found]) -> Judged {
    let mut judged = Judged {
        delay_s: happened.iter().map(|(kind, _)| (*kind, None)).collect(),
        false_alarms: Vec::new(),
    };
    for (place, event) in found.iter().enumerate() {
        let before = |(_, (kind, at)): &(usize, &(Kind, f64))| {
            *kind == event.kind && *at <= event.told_s + AHEAD_S
        };
        let last = happened.iter().enumerate().rev().find(before);
        let Some((index, (_, at))) = last else {
            judged.false_alarms.push(place);
            continue;
        };
        let delay = event.told_s - at;
        let goes_on = event.kind == Kind::Slip
            && !happened
                .iter()
                .any(|(kind, t)| *kind == Kind::Release && *t > *at && *t < event.told_s);
        match &mut judged.delay_s[index].1 {
            told @ None if delay <= AT_MOST_S || goes_on => *told = Some(delay),
            Some(_) if goes_on => {}
            _ => judged.false_alarms.push(place),
        }
    }
    judged
}
