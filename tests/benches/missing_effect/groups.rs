//! Which data sets are made.

use palpate::trace::Trace;
use palpate_tests::hidden::laws::beyond::BEYOND;
use palpate_tests::hidden::laws::{CROSSTALK, EFFECTS, Effect, INEXACT, OUTSIDE, OUTSIDE_MORE};
use palpate_tests::hidden::random::{Subject, stream};
use palpate_tests::hidden::{
    DataSet, Day, LawKind, NoiseKind, Scenario, generate, generate_with_fresh, one_short_trace,
};
use rand::RngExt;

/// What is hidden in the sets of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing.
    Null,
    /// One effect, each in turn.
    One(LawKind),
    /// Crosstalk between gauges, either law in turn.
    Crosstalk,
    /// Two effects of different stages in reference laws.
    Pair,
    /// One effect in its reference law, or nothing in one set of ten, in a single short trace.
    Short,
}

/// Data sets that are counted together.
#[derive(Debug)]
pub struct Group {
    /// Name, for `--only`.
    pub name: &'static str,
    /// What is hidden.
    pub kind: Kind,
    /// R of the sets, each in turn; their number has no divisor in common with that of the effects.
    pub r: &'static [f64],
    /// The noise.
    pub noise: NoiseKind,
    /// What is measured.
    pub day: Day,
}

/// Every group. R that the laws are asked for is spread where the goal states a range.
#[rustfmt::skip]
pub const GROUPS: &[Group] = &[
    Group { name: "null-correlated", kind: Kind::Null, r: &[0.0], noise: NoiseKind::Correlated, day: Day::Usual },
    Group { name: "null-white", kind: Kind::Null, r: &[0.0], noise: NoiseKind::White, day: Day::Usual },
    Group { name: "null-flicker", kind: Kind::Null, r: &[0.0], noise: NoiseKind::Flicker, day: Day::Usual },
    Group { name: "reference-0.1", kind: Kind::One(LawKind::Reference), r: &[0.1], noise: NoiseKind::Correlated, day: Day::Usual },
    Group { name: "reference-0.2", kind: Kind::One(LawKind::Reference), r: &[0.2], noise: NoiseKind::Correlated, day: Day::Usual },
    Group { name: "reference-1", kind: Kind::One(LawKind::Reference), r: &[0.5, 1.0, 2.0], noise: NoiseKind::Correlated, day: Day::Usual },
    Group { name: "foreign-0.2", kind: Kind::One(LawKind::Foreign), r: &[0.2], noise: NoiseKind::Correlated, day: Day::Usual },
    Group { name: "foreign-1", kind: Kind::One(LawKind::Foreign), r: &[0.5, 1.0, 2.0], noise: NoiseKind::Correlated, day: Day::Usual },
    Group { name: "crosstalk", kind: Kind::Crosstalk, r: &[0.2, 0.5, 1.0], noise: NoiseKind::Correlated, day: Day::Usual },
    Group { name: "pair", kind: Kind::Pair, r: &[0.5, 1.0, 2.0], noise: NoiseKind::Correlated, day: Day::Usual },
    Group { name: "outside", kind: Kind::One(LawKind::Outside), r: &[0.5, 1.0, 2.0], noise: NoiseKind::Correlated, day: Day::Usual },
    Group { name: "short", kind: Kind::Short, r: &[0.2, 0.5, 1.0], noise: NoiseKind::Correlated, day: Day::Usual },
    // New groups stand at the end: the place of a group is part of its seeds.
    Group { name: "null-flicker-through", kind: Kind::Null, r: &[0.0], noise: NoiseKind::FlickerThrough, day: Day::Usual },
    Group { name: "inexact", kind: Kind::One(LawKind::Inexact), r: &[0.5, 1.0, 2.0, 5.0], noise: NoiseKind::Correlated, day: Day::Usual },
    Group { name: "foreign-more", kind: Kind::One(LawKind::ForeignMore), r: &[0.5, 1.0, 2.0], noise: NoiseKind::Correlated, day: Day::Usual },
    Group { name: "outside-more", kind: Kind::One(LawKind::OutsideMore), r: &[0.5, 1.0, 2.0], noise: NoiseKind::Correlated, day: Day::Usual },
    Group { name: "outside-beyond", kind: Kind::One(LawKind::Beyond), r: &[0.5, 1.0, 2.0], noise: NoiseKind::Correlated, day: Day::Usual },
    Group { name: "null-other", kind: Kind::Null, r: &[0.0], noise: NoiseKind::Correlated, day: Day::Other },
    Group { name: "reference-other", kind: Kind::One(LawKind::Reference), r: &[0.5, 1.0, 2.0], noise: NoiseKind::Correlated, day: Day::Other },
    Group { name: "foreign-other", kind: Kind::One(LawKind::Foreign), r: &[0.5, 1.0, 2.0], noise: NoiseKind::Correlated, day: Day::Other },
    Group { name: "rare-other", kind: Kind::One(LawKind::OutsideMore), r: &[0.5, 1.0, 2.0], noise: NoiseKind::Correlated, day: Day::Other },
    Group { name: "inexact-other", kind: Kind::One(LawKind::Inexact), r: &[0.5, 1.0, 2.0, 5.0], noise: NoiseKind::Correlated, day: Day::Other },
    Group { name: "null-moving", kind: Kind::Null, r: &[0.0], noise: NoiseKind::Correlated, day: Day::InMotion },
    Group { name: "reference-moving", kind: Kind::One(LawKind::Reference), r: &[0.5, 1.0, 2.0], noise: NoiseKind::Correlated, day: Day::InMotion },
];

/// Draws of a scenario before it is taken although its R is not reached.
const DRAWS: u64 = 8;

impl Group {
    /// A set of the group, and where the base law is inexact fresh traces of the same specimen. Where
    /// a law cannot reach R on a specimen, another specimen is drawn, and after some draws another
    /// effect.
    pub fn set(&self, seed: u64, index: usize) -> (DataSet, Vec<Trace>) {
        let place = GROUPS.iter().position(|group| group.name == self.name).unwrap_or_default();
        let first = (seed << 40) ^ ((place as u64) << 32) ^ ((index as u64) << 10);
        let r = self.r[index % self.r.len()];
        let mut draw = 0;
        loop {
            let scenario = Scenario {
                seed: first + draw,
                hidden: self.hidden(index + (draw / DRAWS) as usize, first + draw),
                r,
                noise: self.noise,
                day: self.day,
            };
            let (set, fresh) = match self.kind {
                Kind::Short => (one_short_trace(&scenario), Vec::new()),
                Kind::One(LawKind::Inexact) => generate_with_fresh(&scenario),
                _ => (generate(&scenario), Vec::new()),
            };
            draw += 1;
            if set.truth.reaches(r) || draw == 4 * DRAWS {
                return (set, fresh);
            }
        }
    }

    fn hidden(&self, turn: usize, seed: u64) -> Vec<(String, LawKind)> {
        // Has no divisor in common with the number of effects, so that all get their turn and a
        // short run meets every stage of the chain.
        const STRIDE: usize = 11;
        let one = |name: &str, kind| vec![(name.to_owned(), kind)];
        let effects = single();
        let next = effects[(STRIDE * turn) % effects.len()].name;
        match self.kind {
            Kind::Null => vec![],
            Kind::One(LawKind::Outside) => one(OUTSIDE[turn % OUTSIDE.len()].0, LawKind::Outside),
            Kind::One(LawKind::OutsideMore) => {
                one(OUTSIDE_MORE[turn % OUTSIDE_MORE.len()].0, LawKind::OutsideMore)
            }
            Kind::One(LawKind::Beyond) => one(BEYOND[turn % BEYOND.len()].name, LawKind::Beyond),
            Kind::One(LawKind::Inexact) => one(INEXACT, LawKind::Inexact),
            Kind::One(kind) => one(next, kind),
            Kind::Crosstalk if turn.is_multiple_of(2) => one(CROSSTALK, LawKind::Reference),
            Kind::Crosstalk => one(CROSSTALK, LawKind::Foreign),
            Kind::Pair => pair(&effects, seed),
            Kind::Short if turn % 10 == 9 => vec![],
            Kind::Short => one(next, LawKind::Reference),
        }
    }
}

/// Every effect that the force shows.
fn single() -> Vec<&'static Effect> {
    EFFECTS.iter().filter(|effect| effect.name != CROSSTALK).collect()
}

/// Two effects of different stages, in the order of the chain.
fn pair(effects: &[&Effect], seed: u64) -> Vec<(String, LawKind)> {
    let random = &mut stream(seed, Subject::Session);
    loop {
        let mut drawn = || effects[random.random_range(0..effects.len())];
        let (a, b) = (drawn(), drawn());
        if a.stage < b.stage {
            return [a, b].map(|effect| (effect.name.to_owned(), LawKind::Reference)).into();
        }
    }
}
