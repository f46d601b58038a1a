//! `backlash`: the drive has play, and its first way after a reversal moves nothing.

use super::{Count, Covariate, Effect, Law, Needs, Sign, Strength};
use crate::{Act, Remembered, Stage};

const WIDTH: Strength = Strength {
    name: "width",
    unit: "mm",
    meaning: "way that is lost at a reversal",
    sign: Sign::Positive,
    typical: |scales| 0.01 * scales.compression,
    most: |scales| 0.3 * scales.compression,
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "backlash",
    stage: Stage::Motion,
    meaning: "Play in spindle, gears or guide: after each reversal the drive turns before the indenter moves.",
    signature: "Starts at each reversal and is like the stiffness times a constant until the next; nothing before the first.",
    against: Covariate::Displacement,
    confused_with: &["coulomb-friction", "permanent-set", "contact-offset"],
    experiment: "Small cycles about a mean compression, slow and fast, with a displacement sensor at the indenter itself.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "x → y, y stays while within [x, x + b]",
            strength: WIDTH,
            shapes: &[],
            act: Act::Compression(|_, parameters, y, x| play(y, x, 0.0, parameters[0])),
        },
        Law {
            name: "lagging",
            formula: "x → y, y stays while within [x − b, x]",
            strength: WIDTH,
            shapes: &[],
            act: Act::Compression(|_, parameters, y, x| play(y, x, -parameters[0], 0.0)),
        },
        Law {
            name: "centred",
            formula: "x → y, y stays while within [x − b/2, x + b/2]",
            strength: WIDTH,
            shapes: &[],
            act: Act::Compression(|_, parameters, y, x| {
                play(y, x, -0.5 * parameters[0], 0.5 * parameters[0]);
            }),
        },
        Law {
            name: "soft",
            formula: "x → x + u, du = −u dx/b in loading, (u − b) dx/b in unloading",
            strength: WIDTH,
            shapes: &[],
            act: Act::Compression(soft),
        },
    ],
};

/// The play operator: `x` takes y along at the edges of [x + `low`, x + `high`].
fn play(y: &mut Remembered, x: &mut [f64], low: f64, high: f64) {
    for x in x {
        if y.is_empty() {
            y.push(*x);
        }
        y[0] = y[0].max(*x + low).min(*x + high);
        *x = y[0];
    }
}

/// A play with an elastic stop: what is lost approaches 0 in loading and the width in unloading.
fn soft(_: &crate::Scene, parameters: &[f64], lost: &mut Remembered, x: &mut [f64]) {
    let width = parameters[0];
    for x in x {
        if lost.is_empty() {
            *lost = vec![0.0, *x];
        }
        let way = *x - lost[1];
        if way != 0.0 {
            let towards = if way > 0.0 { 0.0 } else { width };
            lost[0] = towards + (lost[0] - towards) * (-way.abs() / width).exp();
        }
        lost[1] = *x;
        *x += lost[0];
    }
}
