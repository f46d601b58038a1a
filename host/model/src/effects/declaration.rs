//! What an effect declares.

use super::Effects;
use crate::covariate::Covariate;
use crate::{Act, Applied, Laws, Parameter, Stage};

/// One physical or measuring effect that a base law can lack.
pub struct Effect {
    /// Name in answers, model files and on the command line.
    pub name: &'static str,
    /// Where in the chain it acts.
    pub stage: Stage,
    /// What happens physically, in a sentence or two.
    pub meaning: &'static str,
    /// What it leaves in the residual of a model that lacks it.
    pub signature: &'static str,
    /// The quantity against which that is best looked at.
    pub against: Covariate,
    /// Names of the effects it can be mistaken for.
    pub confused_with: &'static [&'static str],
    /// The experiment that separates it from those.
    pub experiment: &'static str,
    /// What a data set must have for it to be seen.
    pub needs: Needs,
    /// Its laws, the reference form first.
    pub laws: &'static [Law],
}

/// Name of the law of a specimen that forgets between traces, as a new one does. It is tried where nothing says that one trace was
/// recorded after the other.
pub const RECOVERED: &str = "recovered";
/// Name of the law of a hum that is followed through the signal. It is tried where a line of the mains stands out.
pub const FOLLOWED: &str = "followed";

impl Effect {
    /// The laws that are tried on a data set of these scales.
    pub fn laws_on(&self, scales: &Scales) -> impl Iterator<Item = &Law> {
        self.laws.iter().filter(|law| match law.name {
            RECOVERED => scales.unordered,
            FOLLOWED => scales.line.is_some(),
            _ => true,
        })
    }
}

/// One law of an effect.
pub struct Law {
    /// Name of this form: `reference`, or what sets it apart.
    pub name: &'static str,
    /// The law as a formula.
    pub formula: &'static str,
    /// What makes the effect strong: at zero it is absent.
    pub strength: Strength,
    /// Its other parameters.
    pub shapes: &'static [Shape],
    /// How it acts; its parameters are the strengths, then the shapes.
    pub act: Act,
}

/// The parameter by which a law vanishes.
pub struct Strength {
    /// Name, which gets the trace or the channel added where there are several.
    pub name: &'static str,
    /// Unit, empty for a pure number.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// The sign that physics allows.
    pub sign: Sign,
    /// A size at which the effect is small but clear, in a data set of these scales.
    pub typical: fn(&Scales) -> f64,
    /// Largest size that makes sense, in a data set of these scales.
    pub most: fn(&Scales) -> f64,
    /// How many there are.
    pub count: Count,
}

/// A parameter that gives a law its shape.
pub struct Shape {
    /// Name.
    pub name: &'static str,
    /// Unit, empty for a pure number.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// Values to start from, in a data set of these scales, rising.
    pub grid: Grid,
    /// What part of the data it is, or that it is fitted.
    pub role: Role,
}

/// Values to start from, in a data set of these scales.
pub type Grid = fn(&Scales) -> Vec<f64>;

/// Whether a shape is fitted.
#[derive(Clone, Copy, Debug)]
pub enum Role {
    /// Fitted within these bounds, in a data set of these scales.
    Fitted(fn(&Scales) -> (f64, f64)),
    /// The same, where the law means nothing else beyond them: a value on one of them speaks against nothing.
    Bounded(fn(&Scales) -> (f64, f64)),
    /// Stays at the one value of its grid.
    Given,
}

impl Role {
    /// The bounds within which it is fitted, in a data set of these scales; none where it is given.
    #[must_use]
    pub fn bounds(self, scales: &Scales) -> Option<(f64, f64)> {
        match self {
            Self::Fitted(bounds) | Self::Bounded(bounds) => Some(bounds(scales)),
            Self::Given => None,
        }
    }
}

/// The sign that physics allows a strength.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Above zero only.
    Positive,
    /// A part of a whole: from zero to its largest size, both given by physics.
    Part,
    /// Either.
    Either,
}

/// How many strengths a law has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Count {
    /// This many, whatever the data.
    Fixed(&'static [&'static str]),
    /// One for every trace.
    Traces,
    /// One of each of these for every trace, trace by trace.
    EachTrace(&'static [&'static str]),
    /// One for every other channel.
    Channels,
}

/// What a data set must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Displacement and the signal are enough.
    Nothing,
    /// Temperature that changes.
    Temperature,
    /// Another channel than the signal.
    Channels,
    /// More loadings than one.
    Loadings,
    /// Sampling so fast that a hum is not the alias of anything else: 20 Hz.
    FastSampling,
}

/// The sizes of what happens in a data set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scales {
    /// Whether temperature was recorded.
    pub has_temperature: bool,
    /// Whether there are several traces and nothing says in which order they were recorded.
    pub unordered: bool,
    /// Largest size of the signal, N.
    pub force: f64,
    /// Largest compression, mm.
    pub compression: f64,
    /// Largest distance off the specimen, mm.
    pub parting: f64,
    /// Largest speed, mm/s.
    pub speed: f64,
    /// Largest acceleration, mm/s².
    pub acceleration: f64,
    /// Largest number of loadings completed before.
    pub loadings: f64,
    /// Largest deviation of the temperature from its reference, K.
    pub warmth: f64,
    /// Longest stretch, s.
    pub duration: f64,
    /// Time from the first sample of the set to the last, s.
    pub set_duration: f64,
    /// Shortest interval between samples, s.
    pub interval: f64,
    /// Interval between samples that nine of ten do not exceed, s.
    pub common_interval: f64,
    /// Strongest line near 50 Hz and near 60 Hz, Hz; none where it has not been looked for.
    pub mains: Option<[f64; 2]>,
    /// The stronger of the two, Hz; none where neither stands out.
    pub line: Option<f64>,
}

/// What effects need to know of a data set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Setting {
    /// Its sizes.
    pub scales: Scales,
    /// Names of its traces, in order of recording.
    pub traces: Vec<String>,
    /// Its other channels.
    pub channels: Vec<&'static str>,
    /// The range of each other channel, in its unit: largest less smallest value.
    pub channel_ranges: Vec<f64>,
    /// The effects that can be tried on it and that a model of it may name.
    pub effects: Effects,
    /// The base laws that a model of it may name.
    pub laws: Laws,
}

impl Needs {
    /// What is missing in a data set of these scales, in words; none where it has all.
    #[must_use]
    pub fn missing(self, setting: &Setting) -> Option<&'static str> {
        let scales = &setting.scales;
        match self {
            Self::Temperature if !scales.has_temperature => {
                Some("not every trace has a column temperature_C")
            }
            Self::Temperature if scales.warmth < 0.02 => Some("the temperature does not change"),
            Self::Channels if setting.channels.is_empty() => {
                Some("no other channel was recorded that could leak into this one")
            }
            Self::FastSampling if scales.common_interval > 0.05 => {
                Some("sampled too slowly to distinguish a hum from other changes")
            }
            Self::Loadings if scales.loadings < 1.0 => Some("it takes more than one loading"),
            _ => None,
        }
    }
}

impl Law {
    /// Names of the strengths in a data set.
    #[must_use]
    pub fn strengths(&self, setting: &Setting) -> Vec<String> {
        let name = self.strength.name;
        match self.strength.count {
            Count::Fixed([]) => vec![name.to_owned()],
            Count::Fixed(names) => names.iter().map(|&name| name.to_owned()).collect(),
            Count::Traces => {
                setting.traces.iter().map(|trace| format!("{name}[{trace}]")).collect()
            }
            Count::EachTrace(names) => setting
                .traces
                .iter()
                .flat_map(|trace| names.iter().map(move |name| format!("{name}[{trace}]")))
                .collect(),
            Count::Channels => {
                setting.channels.iter().map(|channel| format!("{name}[{channel}]")).collect()
            }
        }
    }

    /// This law in a model of a data set.
    #[must_use]
    pub fn applied(&self, effect: &Effect, setting: &Setting) -> Applied {
        let scales = &setting.scales;
        let most = |place: usize| {
            // A leak is stated per unit of the channel that it is from.
            let channels = self.strength.count == Count::Channels;
            let range = setting.channel_ranges.get(place).filter(|_| channels);
            (self.strength.most)(scales) / range.map_or(1.0, |range| range.max(f64::MIN_POSITIVE))
        };
        let strength = |(place, name): (usize, String)| Parameter {
            name: name.into(),
            unit: self.strength.unit.into(),
            meaning: self.strength.meaning.into(),
            lower: if self.strength.sign == Sign::Either { -most(place) } else { 0.0 },
            bounded: self.strength.sign == Sign::Part,
            upper: most(place),
        };
        let shape = |shape: &Shape| {
            let given = || (shape.grid)(scales).first().copied().unwrap_or(0.0);
            let bounds = shape.role.bounds(scales);
            let (lower, upper) = bounds.unwrap_or_else(|| (given(), given()));
            Parameter {
                name: shape.name.into(),
                unit: shape.unit.into(),
                meaning: shape.meaning.into(),
                lower,
                upper,
                bounded: matches!(shape.role, Role::Bounded(_)),
            }
        };
        let strengths = self.strengths(setting);
        Applied {
            name: effect.name.into(),
            law: self.name.into(),
            stage: effect.stage,
            strengths: strengths.len(),
            each_trace: match self.strength.count {
                Count::Traces => 1,
                Count::EachTrace(names) => names.len(),
                Count::Fixed(_) | Count::Channels => 0,
            },
            parameters: strengths
                .into_iter()
                .enumerate()
                .map(strength)
                .chain(self.shapes.iter().map(shape))
                .collect(),
            act: self.act.clone(),
        }
    }

    /// Every combination of the starting values of the shapes; one empty one where there is no shape.
    #[must_use]
    pub fn grid(&self, scales: &Scales) -> Vec<Vec<f64>> {
        self.shapes.iter().fold(vec![Vec::new()], |points, shape| {
            let values = (shape.grid)(scales);
            points
                .iter()
                .flat_map(|point| {
                    values.iter().map(move |&value| {
                        let mut longer = point.clone();
                        longer.push(value);
                        longer
                    })
                })
                .collect()
        })
    }
}
