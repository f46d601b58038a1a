//! What a model lacks: the whole procedure from the noise to the verdict.

use super::adequacy::{Adequacy, LEVEL};
use super::compare::{Cell, cells_of};
use super::evidence::{Evidence, Refused};
use super::experiment::{deciding, repeating};
use super::fitted::Fitted;
use super::held_out::HeldOut;
use super::hum::has_line;
use super::jumps::{MOST_JUMPS, jumps};
use super::noise::{NoiseModel, noise_model, residual_noise, samples_at_rest};
use super::options::Options;
use super::outside::Outside;
use super::residuals::Residuals;
use super::screen::ABSORBED;
use super::search::{DECISIVE, Found, SURE, Search, is_line};
use super::slow_hum::SlowHum;
use super::verdict::{
    AT_THE_NOISE, Assessed, FAR_BEYOND_NEIGHBOURS, beyond_held_out, beyond_noise,
};
use super::vibration::Vibration;
use palpate_fit::data::{Data, DataError};
use palpate_fit::least_squares::{Effort, LeastSquares};
use palpate_fit::means::Means;
use palpate_fit::problem::Problem;
use palpate_fit::whitening::Whitening;
use palpate_model::effects::{Candidate, EffectError, FOLLOWED, candidates, chain_of};
use palpate_model::{BaseLaw, Chain, Model, Separation};
use palpate_trace::{Noise, Trace, block_means, pooled_noise};

pub use super::verdict::Verdict;

/// What a model lacks on a data set.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// In one word.
    pub verdict: Verdict,
    /// Names of the traces.
    pub labels: Vec<String>,
    /// The column.
    pub signal: String,
    /// What is known of the noise.
    pub noise: NoiseModel,
    /// What happens when contact breaks, as the model has it.
    pub separation: Separation,
    /// What the search found.
    pub found: Found,
    /// Root mean square error of the model as it was given, before it was refitted to whitened residuals.
    pub given_rms: f64,
    /// Standard errors of the parameters of the last model.
    pub standard_errors: Vec<Option<f64>>,
    /// Error on traces left out, before any step and after each; none for a single trace.
    pub held_out: Vec<Option<HeldOut>>,
    /// Whether each step's gain on traces left out is beyond chance.
    pub sure: Vec<bool>,
    /// The residual of the model without effects beside noise.
    pub before: Adequacy,
    /// The residual of the last model beside noise.
    pub after: Adequacy,
    /// Part of the misfit of the model without effects that the last one leaves.
    pub unexplained: f64,
    /// Root mean square of what the last model leaves beyond the noise, in the unit of the signal: how
    /// inexact the law is. 0 where what it leaves is noise.
    pub discrepancy: f64,
    /// Where what the last model leaves sits.
    pub places: Vec<Cell>,
    /// What describes the misfit of the model without effects and is no effect itself; none where effects are named.
    pub outside: Option<Outside>,
    /// Part of the misfit beyond the noise that samples leave which jump away and back, where that is most of it and no effect is named.
    pub jumps: Option<f64>,
    /// Effects that these data cannot show, with the reason.
    pub untestable: Vec<(String, String)>,
    /// What could be tried.
    pub candidates: Vec<Candidate>,
    /// The experiment that would decide, or show more.
    pub next_experiment: Option<String>,
    /// What was done that a reader should know.
    pub notes: Vec<String>,
    /// What was asked for.
    pub options: Options,
}

/// Why a diagnosis cannot be made.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum DiagnoseError {
    #[error(transparent)]
    Effect(#[from] EffectError),
    #[error(transparent)]
    Data(#[from] DataError),
    #[error("{0}")]
    Options(String),
}

/// Samples from which on a set is searched on means even where these do not show all: a hum, or how large the noise is.
const LONG: usize = 20_000;
/// Samples up to which a set with a hum is searched on all of them: no mean shows the hum.
const LONG_WITH_HUM: usize = 300_000;
/// Mean square of a hum, in variances of the noise, from which on it is worth that.
const LOUD: f64 = 0.1;
/// Part of the mean square of what the law leaves that it must be as well.
const SHARE: f64 = 0.005;

/// Says what a model lacks on the traces of a data set, in order of recording, by the effects of the library.
///
/// # Errors
/// When the model or the traces are not usable.
pub fn diagnose(model: &Model, traces: &[Trace]) -> Result<Diagnosis, DiagnoseError> {
    diagnose_with(model, traces, &Options::default())
}

/// The same with what is asked for.
///
/// # Errors
/// When the model, the traces or the options are not usable.
pub fn diagnose_with(
    model: &Model,
    traces: &[Trace],
    options: &Options,
) -> Result<Diagnosis, DiagnoseError> {
    options.check()?;
    let all = options.data(model, traces)?;
    let mut setting = all.setting();
    let (chain, values) = chain_of(model, &setting)?;
    // Long recordings are searched on their means; the errors are those of all rows in the end.
    let white = Whitening::none();
    let noise_left = |data: &Data, means: bool| {
        let plain = Problem::new(&chain, data, &white, None);
        let seen = pooled_noise(traces, &model.base.signal);
        noise_of_residual(&plain, &plain.point(&values), seen, means)
    };
    let long = all.samples() > LONG;
    // Where the noise is not seen, what the law lacks is taken for it, in which neighbours agree: there each mean of a long recording
    // counts as one sample, and motions are thinned only where rests alone are not enough.
    let known = noise_model(&all).or_else(|| (!long).then(|| noise_left(&all, false)));
    let slow = known
        .as_ref()
        .and_then(|noise| SlowHum::of(&all, &setting.scales, (&chain, &values), noise));
    if let Some(slow) = &slow {
        setting.scales.mains = Some(slow.mains);
    }
    let candidates = candidates(&setting, &model.candidates)?;
    let at_rest = if known.is_none() { block_means(traces) } else { None };
    let thinned = at_rest.as_deref().map(|traces| options.data(model, traces)).transpose()?;
    let level = known.as_ref().map(|noise| noise.level);
    let loud = |left: &[Vec<f64>], line: f64| {
        let squares = left.iter().flatten().map(|value| value * value).sum::<f64>();
        let share = SHARE * squares / all.samples() as f64;
        level.is_some_and(|level| has_line(left, &all, line, share.max(LOUD * level.powi(2))))
    };
    let shows_a_line = |lines: [f64; 2]| {
        let left = Residuals::new(&chain, &values, &all).values();
        lines.iter().any(|line| loud(&left, *line))
    };
    let shown = |lines: [f64; 2]| !long || slow.is_some() || shows_a_line(lines);
    let hums = setting.scales.mains.is_some_and(shown);
    let stays_for_hum = hums && all.samples() <= LONG_WITH_HUM;
    let stays = thinned.is_some() || stays_for_hum || known.as_ref().is_some_and(dwarfs);
    let means = if stays { None } else { Means::of(&all, level) };
    let stand_in = |means: &Means| {
        let noise = known.as_ref().filter(|_| !long);
        noise.is_none_or(|noise| stand_for_rows(&chain, &values, (means, &all), noise))
    };
    let means = means.filter(stand_in);
    let few = thinned.or_else(|| means.as_ref().map(|means| means.data(&all)));
    let data = few.as_ref().unwrap_or(&all);
    let weighted = means.as_ref().filter(|_| known.is_some());
    let noise = known.unwrap_or_else(|| noise_left(data, few.is_some()));
    let samples = Problem::new(&chain, &all, &noise.whitening, None);
    let rows = Problem::new(&chain, &all, &white, None);
    let problem = match weighted {
        Some(means) => samples.on_weighted_means(means, data),
        None => Problem::new(&chain, data, &noise.whitening, None),
    };
    let start = problem.point(&values);
    let search = Search {
        data,
        candidates: &candidates,
        whitening: &noise.whitening,
        problem: &problem,
        samples: if weighted.is_some() { &samples } else { &problem },
        rows: few.is_some().then_some(&rows),
        options,
    };

    let mut course = Course::likeliest(&search, &noise, &start);
    course.name_nothing_for_what_is_no_effect();
    course.keep_what_predicts();
    course.name_nothing_alone_without_noise();
    if few.is_some() {
        course.score_all_rows(&rows, all.samples());
    }
    if hums && few.is_some() {
        course.say_that_no_mean_shows_the_line();
    }
    if hums && course.assessed.verdict == Verdict::Adequate {
        let model = course.found.model();
        let left = Residuals::new(&model.chain, &model.values, &all).values();
        // Where sampling is slow, noise that wanders looks like the alias.
        let shows = |line: &f64| 2.0 * line * setting.scales.common_interval < 1.0;
        let mut lines = setting.scales.mains.into_iter().flatten().filter(shows);
        course.miss_a_line(lines.find(|line| loud(&left, *line)));
    }
    course.say_that_the_hum_wanders();
    course.say_what_else_the_hum_may_be(slow.as_ref());
    course.look_for_a_vibration();
    course.say_what_vibrates();
    course.say_where_noise_is_louder();
    course.say_what_hardly_shows();
    let given_rms = rows.rms(&rows.point(&values));
    let history = few.as_ref().and_then(|_| block_means(traces));
    Ok(course.conclude(&rows, given_rms, history.as_deref().unwrap_or(traces)))
}

/// Part of the misfit on traces left out that a model with effects may leave there: what blocks of its residual hide, as a
/// ringing does, is none the less missing.
const HARDLY_PREDICTS: f64 = 0.75;
/// Part of an effect's sensitivity that the model's own parameters must leave for it to show well.
const HARDLY: f64 = 0.1;

/// A diagnosis under way.
struct Course<'a> {
    search: &'a Search<'a>,
    noise: &'a NoiseModel,
    /// What happens when contact breaks, as it explains the traces best.
    separation: Separation,
    /// What the model without effects leaves.
    before: Adequacy,
    found: Found,
    /// What describes what the model without effects leaves and is no effect.
    outside: Option<Outside>,
    /// What the last model found leaves, and the verdict on it.
    assessed: Assessed,
    /// Whether the steps were chosen by what they predict, because the law is inexact.
    inexact: bool,
    notes: Vec<String>,
}

impl<'a> Course<'a> {
    /// Begins with the likeliest model under the noise, and the rule of separation that it takes.
    fn likeliest(search: &'a Search<'a>, noise: &'a NoiseModel, start: &[f64]) -> Self {
        let mut notes = Vec::new();
        let (separation, before, mut found) = likeliest(search, start, &mut notes);
        // Scores count means as samples without correlation there: what is noise that correlates lacks no effect.
        if search.counts_means_as_samples() && before.p_value >= 1.0 && !found.steps.is_empty() {
            found.name_nothing();
        }
        let outside = Outside::of(search, &found.base, noise, before.louder_loaded);
        let assessed = Assessed::of(search, &found, &before, noise, outside.as_ref());
        Self { search, noise, separation, before, found, outside, assessed, inexact: false, notes }
    }

    fn assess(&mut self) {
        let Self { search, found, before, noise, outside, .. } = self;
        self.assessed = Assessed::of(search, found, before, noise, outside.as_ref());
    }

    /// Names no effect where what is none describes the misfit better than all that were found.
    fn name_nothing_for_what_is_no_effect(&mut self) {
        let found = &self.found;
        let explains = |it: &Outside| it.explains(&found.base, found.model());
        if !found.steps.is_empty() && self.outside.as_ref().is_some_and(explains) {
            self.found.name_nothing();
            self.assess();
        }
    }

    /// Root mean square of what the last model leaves beyond the noise, in the unit of the signal; 0 where it is noise.
    fn discrepancy(&self) -> f64 {
        if self.assessed.inexact { beyond_noise(self.found.model(), self.loudness()) } else { 0.0 }
    }

    /// Root mean square of the noise over all samples, louder in contact where it is, in the unit of the signal.
    fn loudness(&self) -> f64 {
        self.noise.level * self.assessed.after.louder
    }

    fn single_trace(&self) -> bool {
        self.search.data.labels.len() == 1
    }

    /// Keeps the steps that nothing measured contradicts: what fits best need not predict best where no
    /// law describes the data to the noise.
    fn keep_what_predicts(&mut self) {
        let inexact = self.single_trace() && self.discrepancy() > 0.0;
        // Scores are held against the noise off the specimen: where it is louder in contact they say too much.
        let louder = self.assessed.after.louder > 1.0;
        let exact = self.assessed.verdict != Verdict::Unknown && !inexact && !louder;
        let denied = self.search.examine(&mut self.found, exact);
        let named = !self.found.steps.is_empty();
        let missed =
            named && beyond_held_out(&self.found.evidence, self.loudness()) > HARDLY_PREDICTS;
        self.inexact = denied.is_some() || missed || (!exact && named);
        if self.inexact {
            self.keep_what_is_borne_out(denied);
            self.assess();
        }
        if louder && !self.found.steps.is_empty() {
            self.found.keep_what_surely_predicts();
            self.assess();
        }
    }

    /// Keeps the steps that are borne out where no law describes the data to the noise, beside what was
    /// refused before.
    fn keep_what_is_borne_out(&mut self, denied: impl IntoIterator<Item = Refused>) {
        self.found = self.search.borne_out(&self.found);
        let known = |denied: &Refused| {
            let mut refused = self.found.refused.iter();
            self.found.names(&denied.effect) || refused.any(|it| it.effect == denied.effect)
        };
        let denied: Vec<Refused> = denied.into_iter().filter(|denied| !known(denied)).collect();
        self.found.refuse(denied);
    }

    /// A single trace that does not show its noise singles out no effect.
    fn name_nothing_alone_without_noise(&mut self) {
        let guessed = !self.noise.is_known() && self.single_trace();
        if !guessed || !beside_others(&mut self.found) {
            return;
        }
        let rest = match samples_at_rest(self.search.samples.data()) {
            0 => "without a stretch at rest off the specimen".to_owned(),
            samples => {
                format!("with {samples} samples at rest off the specimen, too few or too still,")
            }
        };
        self.notes.push(format!(
            "one trace {rest} does not show its noise, and so does not single out an effect: the next best stands beside it"
        ));
        self.assess();
    }

    /// Takes the errors of every step over all rows, where the search was on their means.
    fn score_all_rows(&mut self, rows: &Problem, count: usize) {
        let search = self.search;
        let steps = self.found.steps.len();
        self.found.score(search, rows);
        if self.found.steps.len() < steps {
            // What describes the means to the noise need not describe the rows.
            if !self.inexact {
                let denied = std::mem::take(&mut self.found.refused);
                self.keep_what_is_borne_out(denied);
                self.found.score(search, rows);
            }
            self.assess();
        }
        self.notes.push(format!(
            "searched on {} means of the {count} rows, each over a time in which nothing that a model can follow bends; the errors are those of all rows",
            self.search.data.samples(),
        ));
    }

    /// Says that a line of the mains was seen, and could not be named.
    fn say_that_no_mean_shows_the_line(&mut self) {
        self.notes.push(format!(
            "a line of the mains stands out in these recordings; the means that are searched do not show it: where the rest off the \
             specimen shows the noise, up to {LONG_WITH_HUM} rows are searched as they are, which can name mains-hum"
        ));
    }

    /// Takes a line of the mains, Hz, that stays and that no law of a hum predicts for something that is missing.
    fn miss_a_line(&mut self, line: Option<f64>) {
        let Some(line) = line else { return };
        self.assessed.verdict = Verdict::Unknown;
        self.notes.push(format!(
            "a line near {line:.0} Hz stands out, and no law of a hum predicts it on traces left out"
        ));
    }

    /// Says that a hum that is followed has no steady phase.
    fn say_that_the_hum_wanders(&mut self) {
        if self.found.model().chain.effects.iter().any(|effect| effect.law == FOLLOWED) {
            self.notes.push(
                "the phase of the hum wanders: each sample takes it from the signal in the seconds around, and a motion alone does not \
                 foretell it"
                    .into(),
            );
        }
    }

    /// Says that a hum that these samples show as a slow swing may be one.
    fn say_what_else_the_hum_may_be(&mut self, slow: Option<&SlowHum>) {
        let named = self.found.steps.iter().any(|step| is_line(&step.effect));
        let Some(slow) = slow.filter(|_| named) else { return };
        self.notes.push(format!(
            "{:.1} samples in a second show a hum of {:.3} Hz as a swing of {:.3} Hz: a recording at another rate tells it from a slow swing",
            1.0 / slow.interval,
            slow.frequency,
            slow.shown,
        ));
    }

    /// Looks for a vibration in what is larger than the noise and has no name.
    fn look_for_a_vibration(&mut self) {
        let (last, unnamed) = (self.found.model(), self.found.steps.is_empty());
        let large = last.rms() > AT_THE_NOISE * self.noise.level;
        if !(unnamed && large && self.noise.is_known() && self.outside.is_none()) {
            return;
        }
        let vibration = Vibration::anywhere(self.search.samples, last).map(Outside::Vibration);
        if let Some(vibration) = vibration.filter(|it| it.is_sure(1.0)) {
            self.outside = Some(vibration);
            self.assess();
        }
    }

    /// Says that there is a vibration beside the effects that are named.
    fn say_what_vibrates(&mut self) {
        let Some(Outside::Vibration(vibration)) = &self.outside else { return };
        if !self.found.steps.is_empty() {
            self.notes.push(format!(
                "a vibration of {:.2} Hz stays beside what is named: its amplitude is {:.1} times the noise",
                vibration.frequency_hz,
                vibration.amplitude / self.noise.level,
            ));
        }
    }

    /// Says where the noise is louder than off the specimen.
    fn say_where_noise_is_louder(&mut self) {
        let louder = self.assessed.after.louder_loaded;
        if louder > 1.0 {
            self.notes.push(format!(
                "where the specimen is loaded the noise is {louder:.1} times louder than off it, by the scatter of neighbouring samples: what a model leaves is held against that"
            ));
        }
    }

    /// Says which effects these traces hardly show, where no effect is named: that they are missing from the
    /// answer says little.
    fn say_what_hardly_shows(&mut self) {
        if self.assessed.verdict != Verdict::Unknown || !self.found.steps.is_empty() {
            return;
        }
        let left = |candidate: usize| {
            let own = self.found.first.directions.iter().filter(|it| it.candidate == candidate);
            own.map(|direction| direction.left).fold(0.0, f64::max)
        };
        let candidates = self.search.candidates.iter().enumerate();
        let hardly = candidates.filter(|(index, _)| (ABSORBED..HARDLY).contains(&left(*index)));
        let names: Vec<&str> = hardly.map(|(_, candidate)| &candidate.name[..]).collect();
        if !names.is_empty() {
            self.notes.push(format!(
                "these traces hardly show {}: the model's own parameters do at least {:.0} % of what each of these effects would, so that none of them is named says little",
                names.join(", "),
                100.0 * (1.0 - HARDLY),
            ));
        }
    }

    /// The experiment that would decide, or show more.
    fn next_experiment(
        &self,
        places: &[Cell],
        traces: &[Trace],
        jumps: Option<f64>,
    ) -> Option<String> {
        let Search { data, whitening, .. } = self.search;
        match self.assessed.verdict {
            Verdict::Adequate | Verdict::Named => None,
            Verdict::Ambiguous => deciding(&self.found, data, traces, whitening),
            Verdict::Unknown if matches!(self.outside(), Some(Outside::Past(_))) => {
                Some("the same motions, each recorded from a rest off the specimen on".into())
            }
            // Another recording of the same recorder has others.
            Verdict::Unknown if jumps.is_some() => None,
            Verdict::Unknown => repeating(places, &data.labels),
        }
    }

    /// What is no effect and describes the misfit, where no effect is named.
    fn outside(&self) -> Option<&Outside> {
        let told = |it: &&Outside| it.is_most(&self.found.base) || self.before.p_value >= LEVEL;
        self.outside.as_ref().filter(|_| self.found.steps.is_empty()).filter(told)
    }

    /// Part of the misfit beyond the noise that samples leave which jump away and back, where that is most of it and no effect is named.
    fn jumps(&self) -> Option<f64> {
        let misfit = beyond_noise(&self.found.base, self.noise.level).powi(2);
        let unnamed = self.assessed.verdict == Verdict::Unknown && self.found.steps.is_empty();
        let part = || (jumps(self.search.rows()) / misfit).min(1.0);
        (unnamed && misfit > 0.0).then(part).filter(|part| *part > MOST_JUMPS)
    }

    /// The diagnosis, with what the last model leaves of all rows; `traces` are what the specimen has been through.
    fn conclude(self, rows: &Problem, given_rms: f64, traces: &[Trace]) -> Diagnosis {
        let Search { data, candidates, problem, options, .. } = self.search;
        let last = self.found.model();
        let discrepancy = self.discrepancy();
        let standard_errors =
            last.standard_errors(&problem.with_chain(&last.chain), self.found.inexact);
        let final_rows = rows.with_chain(&last.chain);
        let places = cells_of(&final_rows, &final_rows.point(&last.values), self.noise.level);
        let evidence = &self.found.evidence;
        let outside = self.outside().cloned();
        let jumps = self.jumps();
        Diagnosis {
            next_experiment: self.next_experiment(&places, traces, jumps),
            jumps,
            verdict: self.assessed.verdict,
            labels: data.labels.clone(),
            signal: data.signal.clone(),
            separation: self.separation,
            standard_errors,
            held_out: evidence.iter().map(|evidence| evidence.held_out.clone()).collect(),
            sure: evidence.windows(2).map(|pair| is_sure(&pair[0], &pair[1])).collect(),
            before: self.before,
            after: self.assessed.after,
            unexplained: self.assessed.unexplained,
            discrepancy,
            places,
            untestable: self.found.first.untestable(candidates),
            outside,
            notes: self.notes,
            noise: self.noise.clone(),
            given_rms,
            candidates: candidates.to_vec(),
            options: (*options).clone(),
            found: self.found,
        }
    }
}

/// Part of a sum of squares over all rows by which that over means may differ.
const INEXACT_MEANS: f64 = 0.02;

/// Whether the sum of squares of a model over means is that over all rows: the force of a damper follows the speed at once, and jumps
/// within them.
fn stand_for_rows(
    chain: &Chain,
    values: &[f64],
    (means, all): (&Means, &Data),
    noise: &NoiseModel,
) -> bool {
    let few = means.data(all);
    let rows = Problem::new(chain, all, &noise.whitening, None);
    let point = rows.point(values);
    let costs = (rows.on_weighted_means(means, &few).cost(&point), rows.cost(&point));
    tracing::debug!("sum of squares over means and over rows: {costs:?}");
    (costs.0 - costs.1).abs() < INEXACT_MEANS * costs.1
}

/// Whether what a law leaves dwarfs the scatter of neighbours, so that it tells nothing of the noise.
fn dwarfs(noise: &NoiseModel) -> bool {
    let misfit = noise.whitening.standard_deviation();
    !noise.is_known() && misfit > FAR_BEYOND_NEIGHBOURS * noise.level
}

/// The noise for want of rest, from what the base leaves.
fn noise_of_residual(
    plain: &Problem,
    start: &[f64],
    seen: Option<Noise>,
    means: bool,
) -> NoiseModel {
    let fitted = Fitted::new(plain, start, Effort::QUICK);
    residual_noise(&plain.residuals(&fitted.point), seen, means)
}

/// The likeliest model under the noise, with the rule of separation that it takes; what the base
/// leaves beside the noise, and what was done in `notes`.
fn likeliest(
    search: &Search,
    start: &[f64],
    notes: &mut Vec<String>,
) -> (Separation, Adequacy, Found) {
    let chain = search.problem.chain;
    let attempt = |separation: Separation| {
        let base = BaseLaw { separation, ..chain.base };
        let chain = Chain { base, ..chain.clone() };
        let problem = search.problem.with_chain(&chain);
        let base = Fitted::new(&problem, start, Effort::QUICK);
        (search.left_by(&base), base)
    };
    let separation = chain.base.separation;
    let (before, base) = attempt(separation);
    let found = search.run(base);
    let adequate = found.steps.is_empty() && before.p_value >= LEVEL;
    if adequate || separation == Separation::Bonded {
        return (separation, before, found);
    }
    // Where contact breaks in another way than the model says, or never does, effects would be named in its stead.
    let least = found.model().bic() - if found.steps.is_empty() { DECISIVE } else { 0.0 };
    let aside = search.data.aside();
    let mut displacements = search.data.pieces.iter().flat_map(|it| &*it.motion.displacement);
    let one_side = displacements.all(|x| *x > -aside);
    let others = [Separation::Clamp, Separation::Free, Separation::Bonded];
    let others = others.into_iter().filter(|other| *other != separation);
    // What pulls on the other side as well is prepared otherwise, and the fit says so.
    let others = others.filter(|other| one_side || *other != Separation::Bonded);
    let tried = others.map(|other| (other, attempt(other)));
    let best = tried.min_by(|(_, a), (_, b)| a.1.bic().total_cmp(&b.1.bic()));
    let Some((other, (before_other, base))) = best.filter(|(_, it)| it.1.bic() < least) else {
        return (separation, before, found);
    };
    notes.push(format!(
        "with separation = \"{0}\" the model explains these traces better than with any effect added; that was used: fit with `--separation {0}`",
        other.name()
    ));
    (other, before_other, search.run(base))
}

/// Puts the next best effect beside every one that stands alone; true if there was one.
fn beside_others(found: &mut Found) -> bool {
    let mut changed = false;
    for step in found.steps.iter_mut().filter(|step| step.credible.len() == 1) {
        let other = step.rivals.iter().find(|rival| rival.effect != step.effect);
        changed |= other.is_some();
        step.credible.extend(other.map(|rival| rival.effect.clone()));
    }
    changed
}

/// Whether the mean square error on traces left out falls by more than two standard errors over them.
fn is_sure(before: &Evidence, after: &Evidence) -> bool {
    after.gain(before).is_some_and(|gain| gain.exceeds(SURE))
}
