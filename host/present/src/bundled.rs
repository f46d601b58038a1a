//! The bundled recordings, made by the program so that demo and report run anywhere. They are rebuilt or made up, not
//! measured, and say so in their heads; `cargo xtask traces` writes them to `tests/traces/`.
//!
//! - `table-3.M-row-NN.csv`: the grasps of Tables 3.1–3.3, each rebuilt from its row by the protocol
//!   of 3.3.2: 0.2 s of rest, closing at 20 mm/s with the acceleration of 3.3.4, a hold until 5.1 s,
//!   opening at the same speed; 200 Hz. The branch forces are such that the hold follows the row's
//!   eq. 3.4 from its first sample on, and white noise gives the row's R². Rest, loading and unloading are
//!   made up, and so is what a fit of the whole motion says of them (p, q, which law is best): the exponent
//!   q = 0.28 comes from the mean forces of the three tables.
//! - `press.csv`: a press of a fingertip with four gauges: load, hold, partial unload, hold, unload,
//!   recovery. The gauges follow the force, and after the release what is left of the dent.

use std::path::PathBuf;

use palpate_model::{Hold, Memory, Motion, Move, Profile, Relaxation, Step, elastic_response};
use palpate_trace::{Column, Control, Head, Shape, Trace};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use crate::dissertation::{RelaxationRow, TABLE_3_1, TABLE_3_2, TABLE_3_3};

/// Seed of all noise; each recording draws from a stream of its own.
pub const SEED: u64 = 20;

/// The tables, each with the acceleration of its motion, mm/s² (3.3.4).
const TABLES: [(&[RelaxationRow], f64); 3] =
    [(&TABLE_3_1, 699.0), (&TABLE_3_2, 726.3), (&TABLE_3_3, 711.0)];

/// The rebuilt grasps of one table: 0 for Table 3.1, to 2.
#[must_use]
pub fn grasps(table: usize) -> Vec<Trace> {
    let Some((rows, acceleration)) = TABLES.get(table) else { return Vec::new() };
    let named = |row| {
        let trace = grasp(table as u32 + 1, row, *acceleration);
        Trace { path: Some(grasp_name(table, row)), ..trace }
    };
    rows.iter().map(named).collect()
}

fn grasp_name(table: usize, row: &RelaxationRow) -> PathBuf {
    format!("table-3.{}-row-{:02}.csv", table + 1, row.number).into()
}

/// Every bundled recording, known by the name of its file.
#[must_use]
pub fn all() -> Vec<Trace> {
    (0..TABLES.len()).flat_map(grasps).chain([press()]).collect()
}

/// A grasp of Tables 3.1–3.3.
fn grasp(table: u32, row: &RelaxationRow, acceleration: f64) -> Trace {
    const EXPONENT: f64 = 0.28;
    const REST: f64 = 0.2;
    const HOLD_ENDS: f64 = 5.1;
    const SPEED: f64 = 20.0;
    let closing = row.compression / SPEED + SPEED / acceleration;
    let motion = Profile {
        version: 1,
        rate_hz: 200.0,
        start_mm: 0.0,
        speed_mm_per_s: SPEED,
        acceleration_mm_per_s2: Some(acceleration),
        repeat: 1,
        steps: vec![
            Step::Hold(Hold { hold_s: REST }),
            to(row.compression),
            Step::Hold(Hold { hold_s: HOLD_ENDS - REST - closing }),
            to(0.0),
            Step::Hold(Hold { hold_s: 1.0 }),
        ],
    }
    .motion();
    // A response of one newton at full compression, branch by branch.
    let unit = (EXPONENT + 1.0) / row.compression.powf(EXPONENT + 1.0);
    let elastic: Vec<f64> =
        motion.displacement.iter().map(|x| elastic_response(unit, EXPONENT, x.max(0.0))).collect();
    let fast = branch(row.rates[0], &motion, &elastic);
    let slow = branch(row.rates[1], &motion, &elastic);
    let first = motion.time.iter().position(|&t| t >= REST + closing).unwrap_or(0);
    let last = motion.time.iter().rposition(|&t| t <= HOLD_ENDS).unwrap_or(0);
    // What each branch must carry for the hold to begin with the row's shares.
    let carried = [
        row.force * row.shares[0],
        row.force * row.shares[1] / fast[first],
        row.force * row.shares[2] / slow[first],
    ];
    let force: Vec<f64> = (0..elastic.len())
        .map(|k| (carried[0] * elastic[k] + carried[1] * fast[k] + carried[2] * slow[k]).max(0.0))
        .collect();
    let hold = &force[first..=last];
    let mean = hold.iter().sum::<f64>() / hold.len() as f64;
    let variance = hold.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / hold.len() as f64;
    let noise = (variance * (1.0 - row.r_squared) / row.r_squared).sqrt();
    let mut head = head(&format!("rebuilt from Table 3.{table} row {:02}", row.number), "sushi");
    let made_up = "the hold follows the row; rest, loading and unloading are made up";
    head.other.insert("note".into(), made_up.into());
    head.setup.moving_mass_g = Some(14.0);
    let stream = u64::from(100 * table + row.number);
    recording(head, &motion, vec![column("force_N", &force, noise, 1e-5, stream)])
}

/// The answer of one exponential by itself to an elastic response, N.
fn branch(rate: f64, motion: &Motion, elastic: &[f64]) -> Vec<f64> {
    let alone = Relaxation::new(&[1.0], &[rate]);
    let mut memory = Memory::rested(1);
    let mut before = f64::NAN;
    let mut answer = Vec::with_capacity(elastic.len());
    for (&time, &response) in motion.time.iter().zip(elastic) {
        answer.push(if before.is_nan() {
            memory.jump(&alone, response)
        } else {
            memory.step(&alone, response, time - before)
        });
        before = time;
    }
    answer
}

/// The press of the demo.
#[must_use]
pub fn press() -> Trace {
    /// Gauge signal for each newton of contact force, microstrain.
    const SENSITIVITY: [f64; 4] = [420.0, 310.0, 240.0, 165.0];
    /// Gauge signal of the dent that is left, relative to that of the force which made it.
    const DENT: f64 = 0.45;
    let motion = Profile {
        version: 1,
        rate_hz: 200.0,
        start_mm: -0.5,
        speed_mm_per_s: 8.0,
        acceleration_mm_per_s2: Some(30.0),
        repeat: 1,
        steps: vec![
            Step::Hold(Hold { hold_s: 1.0 }),
            to(4.0),
            Step::Hold(Hold { hold_s: 6.0 }),
            to(2.6),
            Step::Hold(Hold { hold_s: 6.0 }),
            to(-0.5),
            Step::Hold(Hold { hold_s: 5.0 }),
        ],
    }
    .motion();
    let (p, q) = (0.28, 0.45);
    let relaxation = Relaxation::new(&[0.26, 0.24], &[4.2, 0.55]);
    let mut memory = Memory::rested(2);
    let mut force = Vec::new();
    let mut dent = Vec::new();
    let mut before = motion.time[0] - 1.0;
    for (&time, &x) in motion.time.iter().zip(motion.displacement.iter()) {
        let interval = time - before;
        before = time;
        let pressed = elastic_response(p, q, x.max(0.0));
        let reached = pressed.max(memory.free(&relaxation, interval));
        force.push(memory.step(&relaxation, reached, interval));
        dent.push(reached - pressed);
    }
    let mut columns = vec![column("force_N", &force, 0.006, 1e-4, 1)];
    for (gauge, sensitivity) in (1..).zip(SENSITIVITY) {
        let strain: Vec<f64> =
            force.iter().zip(&dent).map(|(f, d)| sensitivity * (f + DENT * d)).collect();
        let name = format!("gauge{gauge}_ustrain");
        columns.push(column(&name, &strain, 1.5, 1e-2, 10 + gauge));
    }
    let mut head = head("made-up press of a fingertip with four gauges", "silicone");
    head.specimen.shape = Some(Shape::Block);
    head.specimen.height_mm = Some(8.0);
    Trace { path: Some("press.csv".into()), ..recording(head, &motion, columns) }
}

fn to(to_mm: f64) -> Step {
    Step::Move(Move { to_mm, speed_mm_per_s: None })
}

fn head(name: &str, material: &str) -> Head {
    let mut head = Head {
        version: Some(1),
        name: Some(name.into()),
        control: Some(Control::Displacement),
        ..Head::default()
    };
    head.specimen.material = Some(material.into());
    head
}

/// `values` with white noise of standard deviation `noise`, rounded to `resolution`.
fn column(name: &str, values: &[f64], noise: f64, resolution: f64, stream: u64) -> Column {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    random.set_stream(stream);
    // A noise that is finite and not negative, as all here are, is never refused.
    let normal = Normal::new(0.0, noise).ok();
    let mut drawn = || normal.map_or(0.0, |normal| normal.sample(&mut random));
    let noisy = |&value: &f64| rounded(value + drawn(), resolution);
    Column { name: name.into(), values: values.iter().map(noisy).collect() }
}

/// The nearest multiple of `resolution`, a power of ten, without digits beyond it.
fn rounded(value: f64, resolution: f64) -> f64 {
    let unit = (1.0 / resolution).round();
    // Adding zero makes a negative zero positive.
    (value * unit).round() / unit + 0.0
}

fn recording(head: Head, motion: &Motion, signals: Vec<Column>) -> Trace {
    let displacement = Column {
        name: "displacement_mm".into(),
        values: motion.displacement.iter().map(|&x| rounded(x, 1e-4)).collect(),
    };
    Trace {
        path: None,
        head,
        time: motion.time.iter().map(|&t| rounded(t, 1e-6)).collect(),
        columns: std::iter::once(displacement).chain(signals).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn the_files_of_the_tests_are_these_recordings() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/traces");
        for trace in all() {
            let name = trace.path.clone().unwrap();
            let mut bytes = Vec::new();
            palpate_trace::write_to(&mut bytes, &trace).unwrap();
            assert!(bytes == std::fs::read(folder.join(&name)).unwrap(), "{}", name.display());
        }
    }
}
