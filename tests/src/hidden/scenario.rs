//! One data set with what is hidden in it.

use palpate::trace::{
    Column, Control, DISPLACEMENT, FORCE, GAUGES, Head, Setup, Shape, Specimen, TEMPERATURE, Trace,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::laws::sensor::Neighbour;
use super::laws::{CROSSTALK, LawKind, Recipe, Setting, laws};
use super::misfit::Refit;
use super::noise::{NoiseKind, noise};
use super::random::{Subject, even, log_even, stream};
use super::session::{Day, Session};
use super::specimen::{Act, Base, record};

/// What to generate.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Seed of everything that is left to chance.
    pub seed: u64,
    /// Names of what is hidden, in order of their place in the chain, with the kind of law.
    pub hidden: Vec<(String, LawKind)>,
    /// For each hidden law alone: RMS misfit that remains after the base is refitted to the data
    /// without noise, over the RMS of the noise.
    pub r: f64,
    /// Kind of noise.
    pub noise: NoiseKind,
    /// What is measured.
    pub day: Day,
}

/// A law that was hidden.
#[derive(Clone, Debug)]
pub struct Hidden {
    /// Name of the effect.
    pub effect: String,
    /// Kind of law.
    pub kind: LawKind,
    /// The law in words and symbols.
    pub form: &'static str,
    /// Its inner parameters, and last its strength.
    pub parameters: Vec<(&'static str, f64)>,
    /// Unit of the strength.
    pub unit: &'static str,
    /// Its R alone.
    pub r: f64,
}

/// What a data set holds.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The hidden laws.
    pub hidden: Vec<Hidden>,
    /// R of all of them together.
    pub r: f64,
    /// The column that holds the effect.
    pub signal: &'static str,
    /// Standard deviation of the noise, in the unit of the signal.
    pub noise_rms: f64,
    /// The specimen; its stiffness is in newtons whatever the signal.
    pub base: Base,
}

impl Truth {
    /// Whether every hidden law has the asked R within 2 %.
    #[must_use]
    pub fn reaches(&self, r: f64) -> bool {
        self.hidden.iter().all(|hidden| reached(hidden.r, r))
    }

    /// Names of the effects that were hidden; an inexact base law is none.
    pub fn effects(&self) -> impl Iterator<Item = &str> {
        let hidden = self.hidden.iter().filter(|hidden| hidden.kind != LawKind::Inexact);
        hidden.map(|hidden| &hidden.effect[..])
    }
}

fn reached(found: f64, asked: f64) -> bool {
    (found / asked - 1.0).abs() < 0.02
}

/// Traces in order of recording, and what they hold.
#[derive(Clone, Debug)]
pub struct DataSet {
    /// The traces, each with the name of its file as path.
    pub traces: Vec<Trace>,
    /// What is hidden.
    pub truth: Truth,
    /// The signal without noise and rounding.
    pub clean: Vec<Vec<f64>>,
}

impl DataSet {
    /// Adds a force, N, that depends on the time in the data set, s, and the displacement, mm.
    ///
    /// # Panics
    /// When a trace has no force or no displacement.
    pub fn add_force(&mut self, added: impl Fn(f64, f64) -> f64) {
        for trace in &mut self.traces {
            let start = trace.head.setup.start_s.unwrap_or_default();
            let column = |name: &str| trace.column(name).expect("a column").iter();
            let samples = trace.time.iter().zip(column(DISPLACEMENT)).zip(column(FORCE));
            let sum = samples.map(|((time, x), force)| force + added(start + time, *x)).collect();
            trace.set_column(FORCE, sum);
        }
    }
}

/// Generates ten traces of one specimen. A law whose R cannot be reached within what physics allows
/// is drawn anew with other inner parameters, a few times; `truth` says the R that was reached.
///
/// # Panics
/// If an effect has no law of the asked kind.
#[must_use]
pub fn generate(scenario: &Scenario) -> DataSet {
    of_session(scenario, &Session::of_day(scenario.day, scenario.seed), None).0
}

/// The same set, and ten more traces of a like specimen that nothing was done to before, taken on
/// another day, without noise: what a model of the first set is worth shows on them.
///
/// # Panics
/// If an effect has no law of the asked kind.
#[must_use]
pub fn generate_with_fresh(scenario: &Scenario) -> (DataSet, Vec<Trace>) {
    // Any other seed does.
    let another_day = Session::of_day(scenario.day, scenario.seed ^ (1 << 63));
    of_session(scenario, &Session::of_day(scenario.day, scenario.seed), Some(&another_day))
}

/// Generates a single trace, 8 mm at 20 mm/s; R is that of this trace.
///
/// # Panics
/// If an effect has no law of the asked kind.
#[must_use]
pub fn one_short_trace(scenario: &Scenario) -> DataSet {
    of_session(scenario, &Session::short(scenario.seed), None).0
}

/// A set of one session, and traces without noise of another, where one is given.
fn of_session(
    scenario: &Scenario,
    session: &Session,
    fresh: Option<&Session>,
) -> (DataSet, Vec<Trace>) {
    let base = base(scenario.seed);
    let plain = record(&base, session, Vec::new());
    let full_scale = plain.iter().flatten().copied().fold(0.0, f64::max);
    let random = &mut stream(scenario.seed, Subject::Size);
    let noise_rms = full_scale / log_even(random, 200.0, 1000.0);
    let neighbours = Neighbour::three(full_scale, random);
    let setting = Setting { base, full_scale, traces: session.recordings.len(), neighbours };
    let scaling = Scaling { session, setting, noise_rms, refit: Refit::new(&base, session) };
    let (mut hidden, mut acts, mut again) = (Vec::new(), Vec::new(), Vec::new());
    for (place, (name, kind)) in scenario.hidden.iter().enumerate() {
        let (recipe, strength, r) = scaling.draw(scenario, place, name, *kind);
        acts.extend((recipe.act)(strength));
        again.extend((recipe.act)(strength));
        let mut parameters = recipe.inner;
        parameters.push(("strength", strength));
        let (form, unit) = (recipe.form, recipe.unit);
        hidden.push(Hidden { effect: name.clone(), kind: *kind, form, parameters, unit, r });
    }
    let clean = record(&base, session, acts);
    let r = match &hidden[..] {
        [] => 0.0,
        [one] => one.r,
        _ => scaling.refit.misfit(&clean.concat()) / noise_rms,
    };
    let gauges = scenario.hidden.iter().any(|(name, _)| name == CROSSTALK);
    let channels = if gauges {
        gauges_and_force(&setting, session, plain, clean, noise_rms)
    } else {
        vec![Channel { name: FORCE, clean, noise_rms }]
    };
    let fresh = fresh.map(|day| fresh_traces(scenario, &base, day, again)).unwrap_or_default();
    let traces = traces(scenario, session, &channels);
    let Channel { name: signal, clean, noise_rms } =
        channels.into_iter().next_back().expect("at least one channel");
    let truth = Truth { hidden, r, signal, noise_rms, base };
    (DataSet { traces, truth, clean }, fresh)
}

fn fresh_traces(scenario: &Scenario, base: &Base, day: &Session, acts: Vec<Act>) -> Vec<Trace> {
    let clean = record(base, day, acts);
    let channel = Channel { name: FORCE, clean, noise_rms: 1.0 };
    let mut traces = traces(scenario, day, std::slice::from_ref(&channel));
    for (trace, clean) in traces.iter_mut().zip(channel.clean) {
        trace.set_column(FORCE, clean);
    }
    traces
}

/// A recorded quantity, without noise and rounding, and the noise to come.
struct Channel {
    name: &'static str,
    clean: Vec<Vec<f64>>,
    noise_rms: f64,
}

/// The force, the neighbouring gauges, and last the first gauge, which is the signal.
fn gauges_and_force(
    setting: &Setting,
    session: &Session,
    force: Vec<Vec<f64>>,
    first: Vec<Vec<f64>>,
    noise_rms: f64,
) -> Vec<Channel> {
    // Microstrain per newton: full scale is 1000 µε.
    let gain = 1000.0 / setting.full_scale;
    let gauge = |name, newtons: Vec<Vec<f64>>| {
        let clean = newtons.into_iter().map(|trace| trace.into_iter().map(|f| gain * f).collect());
        Channel { name, clean: clean.collect(), noise_rms: gain * noise_rms }
    };
    let mut channels = vec![Channel { name: FORCE, clean: force, noise_rms }];
    for (neighbour, name) in setting.neighbours.into_iter().zip(&GAUGES[1..]) {
        let act = Act::Sensor(Box::new(move |now, force| neighbour.feels(now, force)));
        channels.push(gauge(name, record(&setting.base, session, vec![act])));
    }
    channels.push(gauge(GAUGES[0], first));
    channels
}

fn base(seed: u64) -> Base {
    let random = &mut stream(seed, Subject::Base);
    let q = even(random, 0.4, 1.1);
    // Force without relaxation at 12 mm.
    let force = log_even(random, 2.2, 11.0);
    Base {
        p: force * (q + 1.0) / 12f64.powf(q + 1.0),
        q,
        shares: [even(random, 0.2, 0.3), even(random, 0.2, 0.3)],
        rates: [even(random, 3.3, 4.7), even(random, 0.35, 0.7)],
    }
}

/// Finds the strength of a law that gives an R.
struct Scaling<'a> {
    session: &'a Session,
    setting: Setting,
    noise_rms: f64,
    refit: Refit,
}

impl Scaling<'_> {
    fn draw(
        &self,
        scenario: &Scenario,
        place: usize,
        name: &str,
        kind: LawKind,
    ) -> (Recipe, f64, f64) {
        const ATTEMPTS: usize = 5;
        let laws = laws(name, kind).unwrap_or_else(|| panic!("{name} has no {kind:?} law"));
        let random = &mut stream(scenario.seed ^ ((place as u64) << 32), Subject::Laws);
        let mut attempt = 1;
        loop {
            let recipe = laws[random.random_range(0..laws.len())](&self.setting, random);
            let (strength, r) = self.strength(&recipe, scenario.r);
            if reached(r, scenario.r) || attempt == ATTEMPTS {
                return (recipe, strength, r);
            }
            attempt += 1;
        }
    }

    fn r(&self, recipe: &Recipe, strength: f64) -> f64 {
        let signal = record(&self.setting.base, self.session, (recipe.act)(strength)).concat();
        self.refit.misfit(&signal) / self.noise_rms
    }

    /// Secants in the logarithms of R and of the strength.
    fn strength(&self, recipe: &Recipe, target: f64) -> (f64, f64) {
        let sign = recipe.guess.signum();
        let mut size = recipe.guess.abs();
        let mut before: Option<(f64, f64)> = None;
        let mut r = self.r(recipe, sign * size);
        for _ in 0..15 {
            if (r / target - 1.0).abs() < 0.01 {
                break;
            }
            let power = before.map_or(1.0, |(size_before, r_before)| {
                ((r / r_before).ln() / (size / size_before).ln()).clamp(0.4, 4.0)
            });
            before = Some((size, r));
            let factor = (target / r.max(1e-12)).powf(1.0 / power).clamp(1e-3, 30.0);
            let next = (size * factor).min(recipe.most);
            if next == size {
                break;
            }
            size = next;
            r = self.r(recipe, sign * size);
        }
        (sign * size, r)
    }
}

/// What the recorder writes: motion, noisy channels in their steps, temperature.
fn traces(scenario: &Scenario, session: &Session, channels: &[Channel]) -> Vec<Trace> {
    let random = &mut stream(scenario.seed, Subject::Noise);
    let specimen = Specimen {
        material: Some("soft silicone".into()),
        shape: Some(Shape::Cylinder),
        radius_mm: Some(even(random, 20.0, 40.0).round()),
        height_mm: Some(even(random, 27.0, 40.0).round()),
        ..Specimen::default()
    };
    let columns = channels.iter().map(|channel| channel.columns(scenario.noise, session, random));
    let recorded: Vec<(&str, Vec<Vec<f64>>)> = columns.collect();
    let mut made = Vec::new();
    for (index, recording) in session.recordings.iter().enumerate() {
        let x = recording.times().map(|time| rounded(recording.course.at(time).x, 1e4)).collect();
        let temperature = recording.times().map(|time| {
            let noise: f64 = StandardNormal.sample(random);
            rounded(session.temperature(recording.start_s + time) + 0.01 * noise, 1e3)
        });
        let column = |name: &str, values| Column { name: name.into(), values };
        let mut columns = vec![column(DISPLACEMENT, x)];
        columns.extend(recorded.iter().map(|(name, traces)| column(name, traces[index].clone())));
        columns.push(column(TEMPERATURE, temperature.collect()));
        let setup = Setup {
            force_resolution_n: Some(1.0 / steps(channels[0].noise_rms)),
            sequence: i64::try_from(index + 1).ok(),
            start_s: Some(recording.start_s),
            ..Setup::default()
        };
        let head = Head {
            name: Some(recording.name.clone()),
            control: Some(Control::Displacement),
            specimen: specimen.clone(),
            setup,
            ..Head::default()
        };
        let path = Some(recording.file.clone().into());
        made.push(Trace { path, head, time: recording.times().collect(), columns });
    }
    made
}

impl Channel {
    /// Its name, and what the recorder writes of it in each trace.
    fn columns(
        &self,
        kind: NoiseKind,
        session: &Session,
        random: &mut ChaCha8Rng,
    ) -> (&'static str, Vec<Vec<f64>>) {
        let steps = steps(self.noise_rms);
        let of_trace = |(clean, noise): (&Vec<f64>, Vec<f64>)| {
            let noisy =
                clean.iter().zip(noise).map(|(clean, noise)| clean + self.noise_rms * noise);
            noisy.map(|value| rounded(value, steps)).collect()
        };
        let noise = noise(kind, session, random);
        (self.name, self.clean.iter().zip(noise).map(of_trace).collect())
    }
}

/// Steps of the converter per unit: a power of ten, at least twenty within the noise.
fn steps(noise_rms: f64) -> f64 {
    10f64.powf((20.0 / noise_rms).log10().ceil())
}

/// To whole multiples of 1/`steps`.
fn rounded(value: f64, steps: f64) -> f64 {
    (value * steps).round() / steps
}

#[cfg(test)]
mod tests {
    use palpate::fit::data::Data;
    use palpate::fit::whole_motion::fit;
    use palpate::model::{BaseLaw, Separation};
    use palpate::trace::read_set;

    use super::*;
    use crate::hidden::folder::write_traces;
    use crate::hidden::laws::{EFFECTS, INEXACT, OUTSIDE, OUTSIDE_MORE, effect};
    use crate::hidden::specimen::Now;

    fn scenario(seed: u64, hidden: &[(&str, LawKind)], r: f64) -> Scenario {
        let hidden = hidden.iter().map(|(name, kind)| ((*name).to_owned(), *kind)).collect();
        Scenario { seed, hidden, r, noise: NoiseKind::Correlated, day: Day::Usual }
    }

    /// R by the library's own fit to the signal without noise.
    fn r_of_library(set: &DataSet) -> f64 {
        let mut traces = set.traces.clone();
        for (trace, clean) in traces.iter_mut().zip(&set.clean) {
            trace.set_column(set.truth.signal, clean.clone());
        }
        let data = Data::of(&traces, set.truth.signal).expect("the traces can be fitted");
        let law = BaseLaw::fung(2, Separation::Clamp);
        fit(law, &data).expect("the base can be fitted").rms() / set.truth.noise_rms
    }

    #[test]
    fn the_base_of_the_library_explains_a_set_without_effect() {
        let r = r_of_library(&generate(&scenario(1, &[], 1.0)));
        assert!(r < 2e-3, "{r}");
    }

    #[test]
    fn the_library_finds_the_r_that_was_asked() {
        use LawKind::{Foreign, Reference};
        let cases = [
            ("mullins", Reference, 1.0),
            ("sensor-lag", Foreign, 0.5),
            ("permanent-set", Reference, 2.0),
            ("amplitude-dependent-relaxation", Foreign, 0.2),
            ("crosstalk", Reference, 1.0),
        ];
        for (seed, (name, kind, r)) in cases.into_iter().enumerate() {
            let set = generate(&scenario(seed as u64, &[(name, kind)], r));
            let found = r_of_library(&set);
            assert!((found / r - 1.0).abs() < 0.02, "{name}: {found} for {r}");
            assert!((found / set.truth.r - 1.0).abs() < 0.02, "{name}");
        }
    }

    #[test]
    fn every_law_runs_and_nearly_all_reach_r() {
        let mut of_effects = Vec::new();
        for effect in EFFECTS {
            of_effects.push((effect.name, LawKind::Reference));
            of_effects.push((effect.name, LawKind::Foreign));
            of_effects.push((effect.name, LawKind::ForeignMore));
        }
        of_effects.extend(OUTSIDE.iter().map(|(name, _)| (*name, LawKind::Outside)));
        of_effects.extend(OUTSIDE_MORE.iter().map(|(name, _)| (*name, LawKind::OutsideMore)));
        of_effects.push((INEXACT, LawKind::Inexact));
        let mut short = Vec::new();
        for law in &of_effects {
            let set = generate(&scenario(7, std::slice::from_ref(law), 0.2));
            assert!(set.clean.iter().flatten().all(|value| value.is_finite()), "{law:?}");
            if !set.truth.reaches(0.2) {
                short.push((law, set.truth.r));
            }
        }
        assert!(short.len() <= 4, "{short:?}");
    }

    #[test]
    fn the_same_seed_gives_the_same_set_and_another_another() {
        let make = |seed| generate(&scenario(seed, &[("drift", LawKind::Reference)], 1.0)).traces;
        assert_eq!(make(5), make(5));
        assert_ne!(make(5), make(6));
        // The motion does not depend on what is hidden.
        let plain = generate(&scenario(5, &[], 1.0)).traces;
        assert!(plain.iter().zip(make(5)).all(|(a, b)| a.displacement() == b.displacement()));
    }

    #[test]
    fn traces_are_what_the_format_says_and_read_back_in_order() {
        let set = generate(&scenario(2, &[("crosstalk", LawKind::Foreign)], 1.0));
        let folder = tempfile::tempdir().expect("a folder");
        write_traces(folder.path(), &set).expect("valid traces");
        let back = read_set(&[folder.path()]).expect("a valid set");
        assert_eq!(back.len(), 10);
        for (read, made) in back.iter().zip(&set.traces) {
            assert_eq!((&read.time, &read.columns), (&made.time, &made.columns));
            assert_eq!(read.head.setup, made.head.setup);
            assert_eq!(read.gauges().len(), 4);
            let x = read.displacement().expect("a motion");
            assert!(x[0] < -0.4 && x[x.len() - 1] < -0.4);
        }
        let starts: Vec<f64> = back.iter().filter_map(|trace| trace.head.setup.start_s).collect();
        let pauses =
            starts.windows(2).zip(&back).map(|(pair, trace)| pair[1] - pair[0] - trace.duration());
        assert!(pauses.into_iter().all(|pause| (19.9..120.2).contains(&pause)));
    }

    #[test]
    fn the_specimen_remembers_from_trace_to_trace() {
        let session = Session::whole(11);
        let base = base(11);
        let seen = |look: fn(&Now<'_>) -> f64| {
            let act = Act::Sensor(Box::new(move |now, _| look(now)));
            record(&base, &session, vec![act])
        };
        let loadings = seen(|now| now.loadings as f64).concat();
        assert!(loadings.is_sorted());
        assert_eq!(loadings.last(), Some(&14.0));
        let largest = seen(|now| now.largest).concat();
        assert!(largest.is_sorted());
        assert!((largest[largest.len() - 1] - 12.0).abs() < 1e-9);
        let time = seen(|now| now.set_time).concat();
        assert!(time.is_sorted() && time[time.len() - 1] > session.recordings[9].start_s);
        // A slow tail is still there minutes later.
        let random = &mut stream(11, Subject::Laws);
        let neighbours = Neighbour::three(1.0, random);
        let setting = Setting { base, full_scale: 1.0, traces: 10, neighbours };
        let slow = (effect("slow-relaxation").expect("an effect").reference)(&setting, random);
        let with_past = record(&base, &session, (slow.act)(0.05));
        let mut alone = session.clone();
        alone.recordings.drain(..9);
        let without = record(&base, &alone, (slow.act)(0.05));
        let peak = |trace: &[f64]| trace.iter().copied().fold(0.0, f64::max);
        let (with_past, without) = (peak(&with_past[9]), peak(&without[0]));
        assert!(with_past < 0.9999 * without, "{with_past} {without}");
    }
}
