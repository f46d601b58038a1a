//! What a user should know before trusting the parameters of a fit.

use std::fmt;

use super::data::Data;
use super::least_squares::Stop;
use super::loudness::{Loudness, Scatter, Seen};
use super::touch::touched_at;
use super::unknown_past::begun_in_motion;
use super::whole_motion::{Basis, MotionFit, predict};
use palpate_model::{Parameter, Separation};
use palpate_trace::{Noise, units};

/// A reason to be careful with a fit.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum Warning {
    /// The search ended before a minimum.
    NotConverged { iterations: usize },
    /// The law explains no more than a constant does; with the sample that may be why.
    NoBetter { r_squared: f64, outlier: String },
    /// A parameter sits on a bound.
    AtBound { parameter: String, value: f64 },
    /// A parameter can move without changing the prediction.
    Undetermined { parameter: String },
    /// A standard error beyond a quarter of the value.
    Vague { parameter: String, value: f64, standard_error: f64 },
    /// Two parameters that these data hardly tell apart.
    Correlated { first: String, second: String, correlation: f64 },
    /// Two exponentials with the same rate.
    Merged { first: String, second: String },
    /// A time constant longer than the longest recording.
    TooSlow { parameter: String, time_constant: f64, longest: f64 },
    /// A time constant within two sampling intervals.
    TooFast { parameter: String, time_constant: f64, interval: f64 },
    /// The residual is more than noise.
    Misfit { rms: f64, noise: f64, basis: Basis },
    /// The residual is more than the noise off the specimen, but neighbouring samples scatter as far: the noise is so many times louder
    /// where the specimen is loaded.
    LouderNoise { rms: f64, noise: f64, louder: f64 },
    /// The signal does not begin at 0.
    Resting { value: f64, unit: String },
    /// Nothing is felt up to a large part of the largest displacement, both in mm: it does not count from the touch.
    TouchedLater { at: f64, largest: f64 },
    /// Traces that begin pressed and in motion: what moved the specimen before is not known.
    BeginsInMotion { traces: Vec<String> },
    /// The specimen pulls where the law says that the set-up has left it; means of the signal to either side.
    PullsBelow { below: f64, above: f64, unit: String },
    /// Samples that were left out.
    LeftOut { what: String },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotConverged { iterations } => write!(
                f,
                "no minimum was reached in {iterations} steps: do not use these values; fit fewer terms or more data"
            ),
            Self::NoBetter { r_squared, outlier } => write!(
                f,
                "the law explains no more than a constant does (R² {r_squared:.3}): do not use these values{outlier}"
            ),
            Self::AtBound { parameter, value } => write!(
                f,
                "{parameter} = {value:.3e} sits on its bound: the data ask for less than that; try fewer terms"
            ),
            Self::Undetermined { parameter } => write!(
                f,
                "{parameter} is not identifiable from these data: it can change without changing the prediction"
            ),
            Self::Vague { parameter, value, standard_error } => write!(
                f,
                "{parameter} = {value:.3e} is known only to {:.0} %: hardly identifiable from these data",
                100.0 * standard_error / value.abs()
            ),
            Self::Correlated { first, second, correlation } => write!(
                f,
                "{first} and {second} trade off (correlation {correlation:.3}): trust their combination, not each alone"
            ),
            Self::Merged { first, second } => write!(
                f,
                "{first} and {second} have merged: the data show fewer exponentials than were asked for"
            ),
            Self::TooSlow { parameter, time_constant, longest } => write!(
                f,
                "1/{parameter} = {time_constant:.3} s is longer than the longest recording ({longest:.3} s): record longer holds (`palpate plan`)"
            ),
            Self::TooFast { parameter, time_constant, interval } => write!(
                f,
                "1/{parameter} = {time_constant:.3e} s is within two sampling intervals ({interval:.3e} s): record faster"
            ),
            Self::Misfit { rms, noise, basis } => write!(
                f,
                "the model leaves {rms:.3e}, {:.1} times the noise of {noise:.3e}: something is missing from it, so {}",
                rms / noise,
                match basis {
                    Basis::Samples => "the standard errors describe the fit, not the specimen",
                    Basis::Traces => {
                        "the standard errors are those of refits without each trace (jackknife), which allow for it"
                    }
                }
            ),
            Self::LouderNoise { rms, noise, louder } => write!(
                f,
                "the model leaves {rms:.3e}, more than the noise of {noise:.3e} off the specimen, but no more than neighbouring samples scatter: where the specimen is loaded the noise is {louder:.1} times louder"
            ),
            Self::Resting { value, unit } => {
                // Five digits.
                let decimals = (4.0 - value.abs().log10().floor()).max(0.0);
                let value = if decimals > MOST_DECIMALS {
                    format!("{value:.4e}")
                } else {
                    format!("{value:.0$}", decimals as usize)
                };
                write!(
                    f,
                    "the signal rests at {} before the touch, where the law is 0: take that off with `--tare`, or add the effect `zero-shift`",
                    format!("{value} {unit}").trim_end()
                )
            }
            Self::TouchedLater { at, largest } => write!(
                f,
                "nothing is felt before a displacement of {at:.4} mm, of {largest:.4} mm at most, but the law counts displacement from the touch: bring the traces in with `reference = \"contact\"` (`palpate import`), or add the effect `contact-offset`"
            ),
            Self::BeginsInMotion { traces } => {
                let begin = match &traces[..] {
                    [trace] => format!("{trace} begins"),
                    [first, .., last] => {
                        format!("{} traces, {first} to {last}, begin", traces.len())
                    }
                    [] => "no trace begins".into(),
                };
                write!(
                    f,
                    "{begin} pressed and in motion: what moved the specimen before was not recorded, and the law takes it as just touched; record from a rest off the specimen on"
                )
            }
            Self::PullsBelow { below, above, unit } => write!(
                f,
                "the signal is {below:.3e} {unit} at displacements below 0, where the law is 0, and {above:.3e} {unit} above: a specimen that is glued or clamped, and moved to either side, is fitted with `--separation bonded`"
            ),
            Self::LeftOut { what } => f.write_str(what),
        }
    }
}

/// Decimals beyond which a value is written as a power of ten.
const MOST_DECIMALS: f64 = 9.0;
const VAGUE: f64 = 0.25;
const CORRELATED: f64 = 0.99;
/// Rates closer than this, relatively, have merged.
const MERGED: f64 = 0.01;

/// A resting value beyond this part of the whole range of the signal is told.
const RESTING: f64 = 0.1;

/// Mean of the signal below 0, over that above, beyond which the specimen is pulled there all the time.
const PULLS: f64 = 0.25;

/// Everything to be careful about, most serious first.
#[must_use]
pub fn warnings(fit: &MotionFit, data: &Data, noise: Option<&Noise>) -> Vec<Warning> {
    let mut found = Vec::new();
    if fit.stop == Stop::NoBetter {
        let (r_squared, outlier) = (fit.r_squared, data.outlier().unwrap_or_default());
        found.push(Warning::NoBetter { r_squared, outlier });
    } else if !fit.stop.converged() {
        found.push(Warning::NotConverged { iterations: fit.iterations });
    }
    found.extend(data.left_out.iter().cloned().map(|what| Warning::LeftOut { what }));
    if let Some(value) = resting(data).filter(|_| fit.chain.effects.is_empty()) {
        let unit = units::printed(&data.signal).into();
        found.push(Warning::Resting { value, unit });
    }
    if fit.chain.base.separation != Separation::Bonded {
        found.extend(pulls_below(data));
        let late = if fit.chain.effects.is_empty() { touched_at(data) } else { None };
        let largest = data.largest_compression();
        found.extend(late.map(|at| Warning::TouchedLater { at, largest }));
    }
    let begun = begun_in_motion(data);
    if !begun.is_empty() {
        let traces = begun.iter().map(|&index| data.labels[data.pieces[index].trace].clone());
        found.push(Warning::BeginsInMotion { traces: traces.collect() });
    }
    if let Some(noise) = noise {
        let (rms, noise) = (fit.rms(), noise.standard_deviation);
        if fit.is_misfit(noise) {
            let louder = louder(fit, data).filter(|it| !fit.is_misfit(noise * it.overall));
            found.push(match louder {
                Some(it) => Warning::LouderNoise { rms, noise, louder: it.loaded },
                None => Warning::Misfit { rms, noise, basis: fit.basis },
            });
        }
    }
    each_parameter(fit, data, &mut found);
    pairs(fit, &mut found);
    found
}

/// How much louder the noise is where the specimen is loaded, by what the fit leaves.
fn louder(fit: &MotionFit, data: &Data) -> Option<Loudness> {
    let mut scatter = Scatter::default();
    let predicted = predict(&fit.chain, &fit.values, data);
    for (piece, predicted) in data.pieces.iter().zip(predicted) {
        let residual: Vec<f64> =
            piece.measured.iter().zip(&predicted).map(|(y, f)| y - f).collect();
        let seen = Seen { x: &piece.motion.displacement, predicted: &predicted };
        scatter.add(&residual, seen, |x| data.loads(x));
    }
    scatter.louder()
}

/// Mean of the signal before the touch, where it is a large part of the range of the signal.
fn resting(data: &Data) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for piece in &data.pieces {
        let touch = data.touch(piece).unwrap_or(0);
        sum += piece.measured[..touch].iter().sum::<f64>();
        count += touch as f64;
        for &value in piece.measured {
            (least, most) = (least.min(value), most.max(value));
        }
    }
    let value = sum / count;
    (count > 0.0 && value.abs() > RESTING * (most - least)).then_some(value)
}

/// A signal that is as negative below 0 as no parting surface makes it.
fn pulls_below(data: &Data) -> Option<Warning> {
    let aside = data.aside();
    let mean = |side: &dyn Fn(f64) -> bool| {
        let samples = data.pieces.iter().flat_map(|piece| {
            piece.motion.displacement.iter().zip(piece.measured).filter(|(x, _)| side(**x))
        });
        let (sum, count) = samples.fold((0.0, 0.0), |(sum, count), (_, y)| (sum + y, count + 1.0));
        (count > 0.0).then(|| sum / count)
    };
    let (below, above) = (mean(&|x| x < -aside)?, mean(&|x| x > aside)?);
    let unit = units::printed(&data.signal).into();
    (below < -PULLS * above).then_some(Warning::PullsBelow { below, above, unit })
}

fn each_parameter(fit: &MotionFit, data: &Data, found: &mut Vec<Warning>) {
    let constants = fit.chain.base.constants(&fit.values);
    let rates = fit.chain.base.rates();
    let fitted = |(_, parameter): &(usize, Parameter)| parameter.lower < parameter.upper;
    for (k, parameter) in fit.parameters().into_iter().enumerate().filter(fitted) {
        let (parameter, value) = (parameter.name.to_string(), fit.values[k]);
        let branch = rates.contains(&k).then(|| k - rates.start);
        let at_work = branch.filter(|&branch| constants.shares[branch] > 0.0);
        if fit.at_bound[k] {
            found.push(Warning::AtBound { parameter: parameter.clone(), value });
        } else {
            match fit.standard_errors[k] {
                None => found.push(Warning::Undetermined { parameter: parameter.clone() }),
                Some(standard_error) if standard_error > VAGUE * value.abs() => {
                    let parameter = parameter.clone();
                    found.push(Warning::Vague { parameter, value, standard_error });
                }
                Some(_) => {}
            }
        }
        let Some(branch) = at_work else { continue };
        let (time_constant, longest) = (1.0 / constants.rates[branch], data.longest());
        let interval = data.shortest_interval();
        if time_constant > longest {
            found.push(Warning::TooSlow { parameter, time_constant, longest });
        } else if time_constant < 2.0 * interval {
            found.push(Warning::TooFast { parameter, time_constant, interval });
        }
    }
}

fn pairs(fit: &MotionFit, found: &mut Vec<Warning>) {
    let parameters = fit.parameters();
    let rates = fit.chain.base.rates();
    let speeds = fit.chain.base.constants(&fit.values).rates;
    let alike = |i: usize, j: usize| (speeds[i] / speeds[j] - 1.0).abs() < MERGED;
    for i in 0..parameters.len() {
        for j in i + 1..parameters.len() {
            let (first, second) = (parameters[i].name.to_string(), parameters[j].name.to_string());
            let correlation = fit.correlation[(i, j)];
            let known = fit.standard_errors[i].is_some() && fit.standard_errors[j].is_some();
            let both = rates.contains(&i) && rates.contains(&j);
            if both && alike(i - rates.start, j - rates.start) {
                found.push(Warning::Merged { first, second });
            } else if known && correlation.abs() > CORRELATED {
                found.push(Warning::Correlated { first, second, correlation });
            }
        }
    }
}
