//! How long and how fast to record: the Cramér–Rao bound of a recording, and the recording that
//! a wanted precision needs.

use super::fit::Normalisation;
use super::{Bound, Error, ExponentialSum, Parameter};

/// Longest recording that is planned, in samples.
pub const MOST_SAMPLES: usize = 1_000_000;

/// A recording with evenly spaced samples, the first at the start of the relaxation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recording {
    /// Samples per second.
    pub rate: f64,
    /// Number of samples.
    pub samples: usize,
}

impl Recording {
    /// The recording of so many seconds, including a sample at the start.
    #[must_use]
    pub fn lasting(duration: f64, rate: f64) -> Self {
        Self { rate, samples: (duration * rate).round() as usize }
    }

    /// Samples divided by the rate, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.samples as f64 / self.rate
    }

    /// Times of the samples, s.
    pub fn times(&self) -> impl Iterator<Item = f64> + use<> {
        let rate = self.rate;
        (0..self.samples).map(move |sample| sample as f64 / rate)
    }
}

/// What is to be recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// The relaxation or creep that is expected.
    pub sum: ExponentialSum,
    /// Standard deviation of the noise of one sample, in the unit of the signal.
    pub noise: f64,
    /// What the coefficients are relative to.
    pub normalisation: Normalisation,
}

/// A precision wanted of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// The parameter.
    pub parameter: Parameter,
    /// Standard error relative to the parameter's size: 0.01 for 1 %.
    pub relative: f64,
}

/// The recording that a precision needs.
#[derive(Clone, Debug, PartialEq)]
pub enum Plan {
    /// The shortest or slowest recording that reaches every precision wanted.
    Enough {
        /// The recording.
        recording: Recording,
        /// The bound it reaches.
        bound: Bound,
    },
    /// Even the longest or fastest recording allowed is not enough.
    OutOfReach {
        /// That recording.
        recording: Recording,
        /// The parameter that falls short most.
        parameter: Parameter,
        /// The relative standard error it reaches; none where it is not determined at all.
        relative: Option<f64>,
    },
}

impl Experiment {
    /// Least standard errors of a recording.
    ///
    /// # Errors
    /// As [`Bound::new`], and when the recording has more than [`MOST_SAMPLES`] samples or its
    /// rate is not positive.
    pub fn bound(&self, recording: Recording) -> Result<Bound, Error> {
        if !(recording.rate > 0.0 && recording.rate.is_finite()) {
            let (what, value) = ("the sampling rate", recording.rate);
            return Err(Error::Argument { what, value, wanted: "positive" });
        }
        if recording.samples > MOST_SAMPLES {
            let (what, value) = ("the number of samples", recording.samples as f64);
            return Err(Error::Argument { what, value, wanted: "at most 1,000,000" });
        }
        Bound::new(&self.sum, recording.times(), self.noise, self.normalisation)
    }

    /// The shortest recording at a given rate (samples/s) that reaches what is wanted, no longer
    /// than `longest` (s).
    ///
    /// # Errors
    /// As [`Self::bound`], and when something wanted cannot be.
    pub fn duration_for(&self, wanted: &[Wanted], rate: f64, longest: f64) -> Result<Plan, Error> {
        let most = positive("the longest duration", longest)? * positive("the rate", rate)?;
        self.least(wanted, most, |samples| Recording { rate, samples })
    }

    /// The slowest recording of a given duration (s) that reaches what is wanted, no faster than
    /// `fastest` (samples/s).
    ///
    /// # Errors
    /// As [`Self::bound`], and when something wanted cannot be.
    pub fn rate_for(&self, wanted: &[Wanted], duration: f64, fastest: f64) -> Result<Plan, Error> {
        let most = positive("the fastest rate", fastest)? * positive("the duration", duration)?;
        self.least(wanted, most, |samples| Recording { rate: samples as f64 / duration, samples })
    }

    /// The fewest samples that reach what is wanted: more samples never tell less.
    fn least(
        &self,
        wanted: &[Wanted],
        most: f64,
        recording: impl Fn(usize) -> Recording,
    ) -> Result<Plan, Error> {
        self.check(wanted)?;
        if most > MOST_SAMPLES as f64 {
            let what = "the number of samples within the limits";
            return Err(Error::Argument { what, value: most, wanted: "at most 1,000,000" });
        }
        let most = most.round() as usize;
        let needed = 2 * self.sum.terms.len() + 1;
        if most < needed {
            let (samples, terms) = (most, self.sum.terms.len());
            return Err(Error::TooFewSamples { samples, terms, needed });
        }
        // The bound where everything wanted is reached.
        let reach = |samples: usize| -> Result<Option<Bound>, Error> {
            match self.bound(recording(samples)) {
                Ok(bound) => Ok(self
                    .shortfall(&bound, wanted)
                    .is_none_or(|worst| worst.1 <= 1.0)
                    .then_some(bound)),
                Err(Error::Indeterminate) => Ok(None),
                Err(error) => Err(error),
            }
        };
        let mut short = needed - 1;
        let mut enough = needed;
        let mut bound = reach(enough)?;
        while bound.is_none() && enough < most {
            short = enough;
            enough = (2 * enough).min(most);
            bound = reach(enough)?;
        }
        let Some(mut bound) = bound else {
            return Ok(self.out_of_reach(wanted, recording(most)));
        };
        while enough - short > 1 {
            let middle = short + (enough - short) / 2;
            match reach(middle)? {
                Some(better) => (enough, bound) = (middle, better),
                None => short = middle,
            }
        }
        Ok(Plan::Enough { recording: recording(enough), bound })
    }

    /// The parameter that falls short most, and how many times the wanted error it has.
    fn shortfall(&self, bound: &Bound, wanted: &[Wanted]) -> Option<(Parameter, f64)> {
        wanted
            .iter()
            .filter_map(|wanted| {
                let relative = bound.relative(&self.sum, wanted.parameter)?;
                Some((wanted.parameter, relative / wanted.relative))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn out_of_reach(&self, wanted: &[Wanted], recording: Recording) -> Plan {
        let bound = self.bound(recording).ok();
        let worst = bound.as_ref().and_then(|bound| self.shortfall(bound, wanted));
        let parameter = worst.map_or(wanted[0].parameter, |worst| worst.0);
        let relative = bound.and_then(|bound| bound.relative(&self.sum, parameter));
        Plan::OutOfReach { recording, parameter, relative }
    }

    fn check(&self, wanted: &[Wanted]) -> Result<(), Error> {
        if wanted.is_empty() {
            return Err(Error::NothingWanted);
        }
        for wanted in wanted {
            positive("a wanted relative error", wanted.relative)?;
            match self.sum.value(wanted.parameter) {
                Some(value) if value != 0.0 => {}
                Some(value) => {
                    let what = "a parameter whose relative error is wanted";
                    return Err(Error::Argument { what, value, wanted: "different from 0" });
                }
                None => {
                    return Err(Error::NoSuchParameter {
                        terms: self.sum.terms.len(),
                        parameter: wanted.parameter.to_string(),
                    });
                }
            }
        }
        Ok(())
    }
}

fn positive(what: &'static str, value: f64) -> Result<f64, Error> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(Error::Argument { what, value, wanted: "positive" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exponentials::Term;

    /// (3.5) and (3.6) with a noise of 0.01 N.
    fn experiment() -> Experiment {
        let term = |coefficient, rate| Term { coefficient, rate };
        Experiment {
            sum: ExponentialSum {
                scale: 2.187,
                constant: 0.4852,
                terms: vec![term(0.2472, 3.981), term(0.2676, 0.5325)],
            },
            noise: 0.01,
            normalisation: Normalisation::Initial,
        }
    }

    #[test]
    fn the_bound_is_that_of_the_dissertations_recording() {
        let experiment = experiment();
        let recording = Recording::lasting(4.3, 200.0);
        assert_eq!(recording.samples, 860);
        let bound = experiment.bound(recording).unwrap();
        let percent = [
            (Parameter::Scale, 0.14),
            (Parameter::Coefficient(1), 1.17),
            (Parameter::Rate(1), 1.87),
            (Parameter::Coefficient(2), 0.66),
            (Parameter::Rate(2), 2.28),
        ];
        for (parameter, expected) in percent {
            let relative = 100.0 * bound.relative(&experiment.sum, parameter).unwrap();
            assert!((relative - expected).abs() < 0.006, "{parameter}: {relative} %");
        }
    }

    #[test]
    fn the_shortest_recording_reaches_what_is_wanted_and_one_sample_less_does_not() {
        let experiment = experiment();
        let wanted = [
            Wanted { parameter: Parameter::Rate(2), relative: 0.01 },
            Wanted { parameter: Parameter::Coefficient(1), relative: 0.01 },
        ];
        let plan = experiment.duration_for(&wanted, 200.0, 60.0).unwrap();
        let Plan::Enough { recording, bound } = plan else { panic!("{plan:?}") };
        let met = |bound: &Bound| {
            wanted.iter().all(|wanted| {
                bound.relative(&experiment.sum, wanted.parameter).unwrap() <= wanted.relative
            })
        };
        assert!(met(&bound));
        let shorter = Recording { samples: recording.samples - 1, ..recording };
        assert!(!met(&experiment.bound(shorter).unwrap()));
    }

    #[test]
    fn four_times_the_rate_halves_the_standard_error() {
        let experiment = experiment();
        let reached = experiment.bound(Recording::lasting(4.3, 200.0)).unwrap();
        let relative = reached.relative(&experiment.sum, Parameter::Rate(2)).unwrap() / 2.0;
        let wanted = [Wanted { parameter: Parameter::Rate(2), relative }];
        let plan = experiment.rate_for(&wanted, 4.3, 10_000.0).unwrap();
        let Plan::Enough { recording, .. } = plan else { panic!("{plan:?}") };
        assert!((recording.rate - 800.0).abs() < 8.0, "{} Hz", recording.rate);
    }

    #[test]
    fn what_cannot_be_reached_names_the_parameter_that_falls_short() {
        let wanted = [
            Wanted { parameter: Parameter::Scale, relative: 0.01 },
            Wanted { parameter: Parameter::Rate(1), relative: 1e-4 },
        ];
        let plan = experiment().rate_for(&wanted, 4.3, 1000.0).unwrap();
        let Plan::OutOfReach { parameter, relative, .. } = plan else { panic!("{plan:?}") };
        assert_eq!(parameter, Parameter::Rate(1));
        assert!(relative.unwrap() > 1e-4);
    }

    #[test]
    fn a_wish_that_cannot_be_is_refused() {
        let experiment = experiment();
        let wanted = |parameter, relative| [Wanted { parameter, relative }];
        let refused = |wanted: &[Wanted]| experiment.duration_for(wanted, 200.0, 10.0).unwrap_err();
        assert!(matches!(refused(&[]), Error::NothingWanted));
        let no_such = refused(&wanted(Parameter::Rate(3), 0.1));
        assert!(matches!(no_such, Error::NoSuchParameter { .. }));
        let nan = refused(&wanted(Parameter::Rate(1), f64::NAN));
        assert!(matches!(nan, Error::Argument { .. }));
        let long = experiment.duration_for(&wanted(Parameter::Rate(1), 0.1), 200.0, 1e9);
        assert!(matches!(long, Err(Error::Argument { .. })));
    }
}
