//! What was found impossible in traces before anything was fitted to them, and what was done about it.

use palpate_fit::data::Data;
use palpate_fit::robust::Robust;
use palpate_fit::whole_motion::{self, MotionFit};
use palpate_model::Parameter;
use palpate_report::number::significant;
use palpate_report::{Callout, Column, Section, Table};
use palpate_trace::{
    Cause, MotionNoise, Outlier, Repeats, Stairs, Trace, motion_noise, outliers, repeats, stairs,
    without,
};

/// Most samples that a table lists.
const MOST_LISTED: usize = 20;

/// The state of the traces that an answer rests on.
#[derive(Clone, Debug, Default)]
pub struct Preparation {
    /// Samples that cannot be.
    pub outliers: Vec<Outlier>,
    /// Whether they were left out.
    pub dropped: bool,
    /// Traces whose signal was recorded more slowly than their rows.
    pub repeats: Vec<Repeats>,
    /// Whether rows that only repeat it were left out.
    pub repeats_dropped: bool,
    /// Traces whose displacement goes in stairs.
    pub stairs: Vec<Stairs>,
    /// Whether they were joined.
    pub joined: bool,
    /// Noise of displacements that a fit takes out of the motions.
    pub motion_noise: Vec<MotionNoise>,
    /// What was taken off the signal of each trace, by its name.
    pub tared: Vec<(String, f64)>,
    /// What a fit is with the impossible samples and without them.
    pub refit: Option<Refit>,
}

/// A fit with impossible samples, without them, and with a bound on what they can do.
#[derive(Clone, Debug, PartialEq)]
pub struct Refit {
    /// R² with and without.
    pub r_squared: [f64; 2],
    /// Root mean square of the residual with and without, in the unit of the signal.
    pub residual_rms: [f64; 2],
    /// The refit in which no sample has more than a bounded say; none where most residuals are zero.
    pub robust: Option<RobustRefit>,
}

/// A refit in which no sample has more than a bounded say, beside the fit to all samples alike.
#[derive(Clone, Debug, PartialEq)]
pub struct RobustRefit {
    /// The parameters.
    pub parameters: Vec<Moved>,
    /// Number of impossible samples that it weighs less than half.
    pub light_outliers: usize,
    /// Number of other samples that it weighs less than half.
    pub light_others: usize,
}

/// A parameter of a robust refit.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Its value, in that unit.
    pub value: f64,
    /// Its standard error; none where the data do not determine it.
    pub standard_error: Option<f64>,
    /// By how many of those the fit lies off it.
    pub fit_is_off: Option<f64>,
}

/// Standard errors by which the fit may lie off a robust refit where impossible samples do not matter.
const MATTERS: f64 = 1.0;
/// Weight below which a sample counts as weighed down.
const LIGHT: f64 = 0.5;
/// Times closer than this part of the shortest interval are of one sample.
const SAME: f64 = 0.25;

impl RobustRefit {
    fn of(fit: &MotionFit, data: &Data, outliers: &[Outlier]) -> Option<Self> {
        let found = Robust::of(fit, data)?;
        let off = found.off(fit);
        let parameter = |(k, parameter): (usize, Parameter)| Moved {
            name: parameter.name.to_string(),
            unit: parameter.unit.to_string(),
            value: found.values[k],
            standard_error: found.standard_errors[k],
            fit_is_off: off[k],
        };
        let parameters = fit.parameters().into_iter().enumerate().map(parameter).collect();
        let near = SAME * data.shortest_interval();
        let mut light = [0, 0];
        for (piece, weights) in data.pieces.iter().zip(&found.weights) {
            let label = &data.labels[piece.trace];
            let times = piece.recorded_time();
            for (time, _) in times.iter().zip(weights).filter(|(_, weight)| **weight < LIGHT) {
                let same = |out: &Outlier| out.trace == *label && (out.time_s - time).abs() < near;
                light[usize::from(!outliers.iter().any(same))] += 1;
            }
        }
        Some(Self { parameters, light_outliers: light[0], light_others: light[1] })
    }

    /// The parameter that the fit is most off.
    fn most(&self) -> Option<(&str, f64)> {
        let known = self.parameters.iter().filter_map(|it| Some((&it.name[..], it.fit_is_off?)));
        known.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
    }

    fn in_words(&self) -> String {
        let Some((name, off)) = self.most() else { return String::new() };
        let matter = if off.abs() > MATTERS { "so they matter" } else { "so they hardly matter" };
        let others = match self.light_others {
            0 => "and no other".to_owned(),
            1 => "and 1 other".to_owned(),
            count => format!("and {count} others"),
        };
        format!(
            " A robust refit, which bounds what a single sample can do, weighs {} of them {others} less than half; the fit lies at most {} of its standard errors off it (in {name}), {matter}.",
            self.light_outliers,
            significant(off.abs(), 2)
        )
    }
}

impl Refit {
    /// A fit and the same without the impossible samples of the traces; none where nothing is left to fit.
    #[must_use]
    pub fn of(fit: &MotionFit, traces: &[Trace], signal: &str) -> Option<Self> {
        let found = impossible(traces, signal);
        let left: Vec<Trace> = traces.iter().map(|trace| without(trace, &found)).collect();
        let data = Data::of(&left, signal).ok()?;
        let other = whole_motion::fit(fit.chain.base, &data).ok()?;
        let all = Data::of(traces, signal).ok()?;
        // Weights bound what a sample of the signal can do, not what a law makes of a motion that never was.
        let in_signal = found.iter().all(|out| out.column == signal);
        Some(Self {
            r_squared: [fit.r_squared, other.r_squared],
            residual_rms: [fit.rms(), other.rms()],
            robust: in_signal.then(|| RobustRefit::of(fit, &all, &found)).flatten(),
        })
    }
}

/// The impossible samples of all traces.
fn impossible(traces: &[Trace], signal: &str) -> Vec<Outlier> {
    traces.iter().flat_map(|trace| outliers(trace, signal)).collect()
}

/// Of which traces, the first of so many, something is said.
fn of_traces(first: &str, count: usize) -> String {
    if count == 1 { format!("of {first}") } else { format!("of {count} traces") }
}

impl Preparation {
    /// What is impossible in traces that are taken as they are.
    #[must_use]
    pub fn of(traces: &[Trace], signal: &str) -> Self {
        Self {
            outliers: impossible(traces, signal),
            repeats: repeats(traces, signal),
            stairs: stairs(traces, signal),
            motion_noise: motion_noise(traces, signal),
            ..Self::default()
        }
    }

    /// The sections of an answer with one before them on the traces, where there is something to tell.
    #[must_use]
    pub fn before(&self, mut sections: Vec<Section>) -> Vec<Section> {
        let own = [
            self.section(),
            self.repeats_section(),
            self.stairs_section(),
            self.motion_noise_section(),
        ];
        sections.splice(0..0, own.into_iter().flatten());
        sections
    }

    fn section(&self) -> Option<Section> {
        if self.outliers.is_empty() {
            return None;
        }
        let mut columns = vec![Column::text("trace"), Column::number("row", "")];
        columns.extend([Column::number("time", "s"), Column::text("column")]);
        columns.extend([Column::number("value", ""), Column::number("between neighbours", "")]);
        let mut table = Table::new("Impossible samples", columns);
        for out in self.outliers.iter().take(MOST_LISTED) {
            table = table.row([
                out.trace.clone(),
                out.row.to_string(),
                format!("{:.4}", out.time_s),
                out.column.clone(),
                significant(out.value, 5),
                significant(out.expected, 5),
            ]);
        }
        if let Some(more @ 1..) = self.outliers.len().checked_sub(MOST_LISTED) {
            table = table.note(format!("And {more} more; `--json` lists them all."));
        }
        Some(
            Section::new("Impossible samples")
                .callout(Callout::Warning, "Impossible samples", self.in_words())
                .table(table),
        )
    }

    fn repeats_section(&self) -> Option<Section> {
        let first = self.repeats.first()?;
        let rows = significant(first.rows, 2);
        let traces = of_traces(&first.trace, self.repeats.len());
        let what = format!(
            "The signal {traces} was recorded more slowly than the rows: each of its values stays for {rows} rows on average."
        );
        let words = if self.repeats_dropped {
            format!("{what} The rows that only repeat one were left out, as asked.")
        } else {
            format!(
                "{what} What repeats lags behind, and a lag seems to be missing; `--drop-repeats` leaves those rows out."
            )
        };
        let title = "A signal that repeats";
        Some(Section::new(title).callout(Callout::Warning, title, words))
    }

    fn stairs_section(&self) -> Option<Section> {
        let first = self.stairs.first()?;
        let traces = of_traces(&first.trace, self.stairs.len());
        let step = significant(first.step_mm, 2);
        let how = match first.cause {
            Cause::Held => format!(
                "was recorded more slowly than the signal: where it moves it stays for {} samples, then goes on by {step} mm at once",
                significant(first.samples, 2)
            ),
            Cause::Rounded => format!("is rounded to steps of {step} mm"),
        };
        let words = if self.joined {
            format!(
                "The displacement {traces} {how}. It was taken as straight between its steps, as asked."
            )
        } else {
            format!(
                "The displacement {traces} {how}. A law takes each step for a sudden press; `--join-steps` takes the motion as straight between them."
            )
        };
        Some(Section::new("Displacement in steps").callout(
            Callout::Warning,
            "Displacement in steps",
            words,
        ))
    }

    fn motion_noise_section(&self) -> Option<Section> {
        let deviations = self.motion_noise.iter().map(|own| own.standard_deviation_mm);
        let most = deviations.fold(0.0, f64::max);
        let count = self.motion_noise.len();
        let traces = of_traces(&self.motion_noise.first()?.trace, count);
        let up_to = if count == 1 { "" } else { "up to " };
        let words = format!(
            "The displacement {traces} scatters by {up_to}{} mm, which the signal would show and does not follow: it is noise of the sensor, not motion. The model was run over the motion without it.",
            significant(most, 2)
        );
        Some(Section::new("Noise of the displacement").callout(
            Callout::Warning,
            "Noise of the displacement",
            words,
        ))
    }

    fn in_words(&self) -> String {
        let samples = match self.outliers.len() {
            1 => "1 sample jumps".to_owned(),
            count => format!("{count} samples jump"),
        };
        let what =
            format!("{samples} away and back faster than this motion or this signal ever goes");
        if self.dropped {
            return format!("{what}; left out, as asked.");
        }
        let matter = self.refit.as_ref().map_or_else(String::new, |refit| {
            let robust = refit.robust.as_ref().map_or_else(String::new, RobustRefit::in_words);
            format!(
                " Without them R² would be {:.3} instead of {:.3}.{robust}",
                refit.r_squared[1], refit.r_squared[0]
            )
        });
        format!("{what}.{matter} `--drop-outliers` leaves them out.")
    }
}
