//! A program of somebody else's: it depends on `palpate` alone, without its default features, and brings an effect and laws of its
//! own: those of the example `own`, and a family.

#[path = "../../../host/examples/own/declared.rs"]
mod declared;
pub mod laws;

use std::f64::consts::TAU;

use palpate::fit::data::Data;
use palpate::fit::whole_motion::predict;
use palpate::model::{BaseLaw, Chain, Separation};
use palpate::trace::{DISPLACEMENT, FORCE, Trace};
use palpate::{DataSet, Effects};

pub use declared::TEETH;

/// Standard deviation of the noise of [`specimen`], N.
pub const NOISE: f64 = 0.01;

/// Three presses of a specimen on a drive whose teeth, 0.9 mm apart, push with 0.05 N.
#[must_use]
pub fn specimen() -> DataSet {
    let law = BaseLaw::fung(2, Separation::Clamp);
    recorded(law, &[0.28, 0.45, 0.26, 0.24, 4.2, 0.55, 0.05, 0.9])
}

/// Three presses by a law with these parameters, amplitude and pitch of the teeth last, with noise.
///
/// # Panics
/// Never: its motions are constants that can be pressed.
#[must_use]
pub fn recorded(law: BaseLaw, values: &[f64]) -> DataSet {
    let bare: Vec<Trace> = [4.0, 6.0, 8.0].into_iter().zip(0..).map(press).collect();
    let data = Data::of_motions(&bare, FORCE).expect("a motion that can be pressed");
    let teeth = TEETH.laws[0].applied(&TEETH, &data.setting());
    let chain = Chain::new(law).with(teeth);
    let mut random = Random(7);
    let measured = |(mut trace, force): (Trace, Vec<f64>)| {
        trace.set_column(FORCE, force.into_iter().map(|f| f + NOISE * random.normal()).collect());
        trace
    };
    let traces: Vec<Trace> =
        bare.clone().into_iter().zip(predict(&chain, values, &data)).map(measured).collect();
    traces.into()
}

/// Rest, a press to this depth, mm, a hold and a release; 100 Hz.
fn press((depth, number): (f64, u32)) -> Trace {
    let time: Vec<f64> = (0..900).map(|k| 0.01 * f64::from(k)).collect();
    let speed = 4.0;
    let x =
        |t: f64| (speed * (t - 1.0) - 0.5).max(-0.5).min(depth).min(speed * (7.5 - t)).max(-0.5);
    let mut trace = Trace { time, ..Trace::default() };
    trace.head.name = Some(format!("{depth} mm"));
    trace.head.setup.start_s = Some(60.0 * f64::from(number));
    trace.set_column(DISPLACEMENT, trace.time.iter().map(|&t| x(t)).collect());
    trace.set_column(FORCE, vec![0.0; trace.time.len()]);
    trace
}

/// Normal deviates, the same in every run.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

/// The effects that this program tries.
#[must_use]
pub fn effects() -> Effects {
    Effects::library().with(&TEETH)
}
