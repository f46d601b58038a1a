//! The verdict in words, and what to do next.

use super::{DiagnosisSummary, listed};
use palpate_diagnose::criticism::adequacy::LEVEL;
use palpate_diagnose::criticism::diagnose::Verdict;
use palpate_diagnose::criticism::incident::Change;
use palpate_diagnose::criticism::leftover_curve::LeftoverCurve;
use palpate_diagnose::criticism::outside::Outside;
use palpate_diagnose::criticism::search::{DECISIVE, Step};
use palpate_model::covariate::Covariate;
use palpate_report::number::{percent, significant};

/// An error this many times the noise is not called noise.
const SUSPECT: f64 = 1.15;

/// How much of the misfit samples leave that jump away and back.
fn jumps_in_words(share: f64) -> String {
    let share = percent(share, 2);
    format!("Samples that jump away and back are {share} of the misfit: they are the recorder's. ")
}

impl DiagnosisSummary<'_> {
    /// What is missing, how sure that is, and what it does to the error.
    pub(crate) fn verdict_in_words(&self) -> String {
        match self.diagnosis.verdict {
            Verdict::Adequate if self.suspect_rest() => {
                format!("{} {}", self.adequate(), self.rest_in_words())
            }
            Verdict::Adequate => self.adequate(),
            Verdict::Named | Verdict::Ambiguous => {
                format!(
                    "{} {} {} {}",
                    self.missing(),
                    self.fall(),
                    self.sureness(),
                    self.rest_in_words()
                )
            }
            Verdict::Unknown if self.diagnosis.found.steps.is_empty() => {
                let unit = self.unit();
                let base = &self.diagnosis.found.base;
                let looks = match (self.diagnosis.jumps, &self.diagnosis.outside) {
                    (Some(share), _) => jumps_in_words(share),
                    (None, Some(outside)) => self.outside_in_words(outside),
                    (None, None) => String::new(),
                };
                format!(
                    "Something is missing that no effect of the library explains. The model leaves \
                     {} {unit}, {} times the noise. {looks}{}",
                    self.level(base.rms()),
                    significant(base.rms() / self.noise(), 3),
                    self.place_in_words(),
                )
            }
            Verdict::Unknown => {
                let steps = self.diagnosis.found.steps.iter();
                let names: Vec<String> = steps.map(|step| step.effect.clone()).collect();
                format!(
                    "Something is missing that no effect of the library explains to the end. With what \
                     explains the most, {}, {} {}",
                    listed(&names, "and"),
                    self.fall().replacen("The", "the", 1),
                    self.rest_in_words(),
                )
            }
        }
    }

    /// What is no effect and describes the misfit, and how much of it.
    fn outside_in_words(&self, outside: &Outside) -> String {
        let what = match outside {
            Outside::Incident(incident) => {
                let size = match incident.change {
                    Change::Zero => {
                        format!(
                            "the zero is another by {} {}",
                            significant(incident.size, 2),
                            self.unit()
                        )
                    }
                    Change::Gain => {
                        format!(
                            "the signal is another by {} %",
                            significant(100.0 * incident.size, 2)
                        )
                    }
                };
                format!(
                    "something that happened once: from {:.2} s of {} on, to the end of the {}, {size}",
                    incident.time_s,
                    self.diagnosis.labels[incident.trace],
                    if incident.lasts { "set" } else { "trace" },
                )
            }
            Outside::Swing(swing) => format!(
                "a slow swing through all traces, of {} Hz and an amplitude of {} {}",
                significant(swing.frequency_hz, 3),
                significant(swing.amplitude, 2),
                self.unit(),
            ),
            Outside::Vibration(vibration) => format!(
                "a vibration of {} Hz and an amplitude of {} {}, {}",
                significant(vibration.frequency_hz, 3),
                significant(vibration.amplitude, 2),
                self.unit(),
                if vibration.at_rest {
                    "at rest off the specimen as well: the building, a fan, a pump"
                } else {
                    "hardly there at rest off the specimen: the drive, the specimen or what holds it"
                },
            ),
            Outside::Past(past) => {
                let (begun, all) = (past.traces.len(), self.diagnosis.labels.len());
                format!(
                    "what the specimen remembers of before the recording ({begun} of {all} traces begin pressed and in motion, where the law \
                     takes it as just touched)"
                )
            }
        };
        let share = percent(outside.share(&self.diagnosis.found.base), 2);
        format!("It looks like {what}; that describes {share} of the misfit. ")
    }

    fn adequate(&self) -> String {
        let diagnosis = self.diagnosis;
        let nearest = self.ranked().into_iter().find(|ranked| ranked.chance < 1.0).map(|ranked| {
            format!(
                " The nearest is `{}`: noise alone looks as much like it with a chance of {}.",
                ranked.name,
                percent(ranked.chance, 2)
            )
        });
        format!(
            "Nothing is missing. The model leaves {} {unit}, the noise is {} {unit}. No effect of the \
             library is missed beyond a chance of {}.{}",
            self.level(diagnosis.found.base.rms()),
            self.level(self.noise()),
            percent(0.5 * self.diagnosis.options.false_alarms, 1),
            nearest.unwrap_or_default(),
            unit = self.unit(),
        )
    }

    /// Which effects are missing.
    pub(super) fn missing(&self) -> String {
        let steps = &self.diagnosis.found.steps;
        let single = |step: &&Step| step.credible.len() == 1;
        let names: Vec<String> = steps.iter().filter(single).map(|s| s.effect.clone()).collect();
        let sets = steps.iter().filter(|step| !single(step));
        let sets: Vec<String> = sets.map(|step| listed(&step.credible, "or")).collect();
        let told = match names.len() {
            0 => None,
            1 => Some(format!("{} is missing", listed(&names, "and"))),
            _ => Some(format!("{} are missing", listed(&names, "and"))),
        };
        let untold = (!sets.is_empty()).then(|| {
            let verb = if told.is_some() { "so is" } else { "missing is" };
            format!("{verb} {}, which these traces cannot distinguish", sets.join(", and "))
        });
        let all: Vec<String> = told.into_iter().chain(untold).collect();
        super::sentence(&all.join("; "))
    }

    /// How far the error falls, fitted and held out.
    pub(super) fn fall(&self) -> String {
        let (diagnosis, unit) = (self.diagnosis, self.unit());
        let mut text = format!(
            "The error falls from {} {unit} to {} {unit} (noise {} {unit})",
            self.level(diagnosis.found.base.rms()),
            self.level(diagnosis.found.model().rms()),
            self.level(self.noise()),
        );
        if let (Some(Some(before)), Some(Some(after))) =
            (diagnosis.held_out.first(), diagnosis.held_out.last())
        {
            text += &format!(
                "; on traces left out of the fit from {} {unit} to {} {unit}",
                self.level(before.rms),
                self.level(after.rms)
            );
        }
        text + "."
    }

    /// How sure the names are: chance under noise, distance of the next, resamplings won.
    fn sureness(&self) -> String {
        let steps = &self.diagnosis.found.steps;
        let largest = steps.iter().map(|step| step.p_value).fold(0.0, f64::max);
        let inexact = self.diagnosis.found.inexact;
        let mut text = format!(
            "{} with a chance of at most {}",
            match inexact {
                true => "Parts of the data that have nothing in common agree as much",
                false => "Noise alone shows as much",
            },
            percent(largest, 2)
        );
        if inexact {
            text +=
                "; no law leaves noise alone, and so the error on traces left out chose the name";
        } else if let [step] = &steps[..]
            && step.credible.len() == 1
        {
            let own = step.rivals.iter().find(|rival| rival.effect == step.effect);
            let next = step.rivals.iter().find(|rival| rival.effect != step.effect);
            if let (Some(own), Some(next)) = (own, next) {
                text += &format!(
                    "; the next best, `{}`, is behind by ΔBIC = {:.0} ({DECISIVE:.0} is decisive), and \
                     `{}` wins {} of the resamplings",
                    next.effect,
                    next.fitted.bic() - own.fitted.bic(),
                    own.effect,
                    percent(own.won, 2),
                );
            }
        }
        let unsure = steps.iter().zip(&self.diagnosis.sure).filter(|(_, sure)| !**sure);
        let unsure: Vec<String> = unsure.map(|(step, _)| step.effect.clone()).collect();
        if self.data.labels.len() > 1 && !unsure.is_empty() {
            text += &format!(
                "; on traces left out the gain of {} is within two standard errors of none",
                listed(&unsure, "and")
            );
        }
        text + "."
    }

    /// Whether what remains is larger than noise, however white, louder in contact as it may be.
    pub(super) fn suspect_rest(&self) -> bool {
        let noise = self.diagnosis.after.louder * self.noise();
        self.diagnosis.found.model().rms() > SUSPECT * noise
    }

    /// Whether what remains is noise.
    pub(super) fn rest_in_words(&self) -> String {
        let diagnosis = self.diagnosis;
        let part = percent(diagnosis.unexplained, 2);
        if diagnosis.verdict == Verdict::Unknown {
            return format!(
                "What remains is more than noise: {part} of the misfit. {}",
                self.place_in_words()
            );
        }
        if diagnosis.after.p_value < LEVEL {
            return format!(
                "What remains is slightly more than noise, {part} of the misfit: as much as the form \
                 of a law may differ from the specimen's."
            );
        }
        if self.suspect_rest() {
            let times = diagnosis.found.model().rms() / self.noise();
            return format!(
                "What remains does not wander more than noise, but it is {times:.2} times as large: \
                 something fast may be left, such as hum."
            );
        }
        "What remains is noise.".into()
    }

    /// Where what the last model leaves sits and what it depends on.
    pub(super) fn place_in_words(&self) -> String {
        format!("Beyond the noise, {}", self.after().comparison.in_words())
    }

    /// The experiment that would decide, or show more.
    pub(crate) fn next_experiment(&self) -> Option<String> {
        self.diagnosis.next_experiment.clone()
    }

    /// The next experiment as a sentence.
    pub(super) fn experiment_in_words(&self) -> Option<(String, Option<String>)> {
        let experiment = self.next_experiment()?;
        let experiment = experiment.trim_end_matches('.');
        Some((format!("The experiment that would decide: {experiment}."), None))
    }

    /// What to do next: a sentence, and the command where there is one.
    pub(super) fn what_next(&self) -> Vec<(String, Option<String>)> {
        let steps = &self.diagnosis.found.steps;
        let add = |sure: bool| {
            let (what, command) = match &steps[..] {
                [step] => ("it", self.next.add(&step.effect, self.law_beside_reference(0))),
                _ => ("them", self.next.explore()),
            };
            let text = if sure {
                format!("Add {what} to the model:")
            } else if steps.len() == 1 {
                "To go on with the one that fits best:".to_owned()
            } else {
                "To go on with those that fit best:".to_owned()
            };
            (text, Some(command))
        };
        match self.diagnosis.verdict {
            Verdict::Adequate => vec![(
                "Nothing needs to be added. An effect much smaller than the noise may still be \
                 there: more traces, larger compressions or other rates would show it."
                    .into(),
                None,
            )],
            Verdict::Named => vec![add(true)],
            Verdict::Ambiguous => {
                let mut next: Vec<_> = self.experiment_in_words().into_iter().collect();
                next.push((
                    "As a motion that your machine can run:".into(),
                    Some(self.next.diagnose() + " --next motion.csv"),
                ));
                next.push(add(false));
                next
            }
            Verdict::Unknown if self.diagnosis.jumps.is_some() => vec![(
                "What else is missing shows without the samples that jump:".into(),
                Some(self.next.diagnose() + " --drop-outliers"),
            )],
            Verdict::Unknown => {
                let mut next: Vec<_> = self.experiment_in_words().into_iter().collect();
                if !steps.is_empty() {
                    next.push(add(false));
                }
                next.push(self.law_of_ones_own());
                next
            }
        }
    }

    /// How a law of one's own is tried.
    pub(super) fn law_of_ones_own(&self) -> (String, Option<String>) {
        let begin = match self.curve() {
            Some(curve) => format!(
                "here the curve of the mean residual over the {} ({} of it)",
                curve.covariate.name(),
                percent(curve.explained, 2)
            ),
            None => format!("here with the {}", self.suspect().name()),
        };
        let text = format!(
            "If you know what it could be, write it into {} as a law of your own, {begin}, and diagnose again:",
            self.next.model,
        );
        (text, Some(format!("{}\n\n{}", self.own_law(), self.next.diagnose())))
    }

    /// What is left as a curve over what it depends on most.
    pub(super) fn curve(&self) -> Option<&LeftoverCurve> {
        let curve = || LeftoverCurve::of(&self.after().residuals, self.suspect());
        self.curve.get_or_init(curve).as_ref()
    }

    /// What the rest depends on most.
    fn suspect(&self) -> Covariate {
        let strongest = self
            .after()
            .comparison
            .dependences
            .first()
            .filter(|strongest| strongest.p_value < 0.01);
        strongest.map_or(Covariate::Displacement, |dependence| dependence.covariate)
    }

    /// A law of one's own to begin with.
    fn own_law(&self) -> String {
        let (expression, value) = match self.curve() {
            Some(curve) => (curve.expression.clone(), "1.0"),
            None => (format!("k * {}", self.suspect().symbol()), "0.01"),
        };
        format!(
            "[[candidate]]\nname = \"my-law\"\nstage = \"contact\"\nexpression = \"{expression}\"\n\
             [candidate.parameters.k]\nvalue = {value}"
        )
    }

    /// Why a candidate could not be tested, in short.
    pub(crate) fn untestable(&self, name: &str) -> Option<&str> {
        let untestable = self.diagnosis.untestable.iter();
        untestable.filter(|(effect, _)| effect == name).map(|(_, reason)| reason.as_str()).next()
    }
}
