//! Force curves of microscopes: time, way of the piezo towards the specimen and force; a part a curve.
//!
//! Every curve has the columns of a trace, `time_s`, `displacement_mm` and `force_N`, and `afm_segment`: 0 on the way in, 1 in a
//! pause, 2 on the way back. What is not calibrated to force and way is refused: a number in counts or volts is no force.

mod jpk;
mod nanoscope;
mod nid;

pub use jpk::jpk;
pub use nanoscope::nanoscope;
pub use nid::nid;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::limits::too_much_text;
use crate::{Column, Error, Part, TEXT_LIMIT};

/// What the tip does in a stretch of a curve; the number of it stands in the column `afm_segment`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stretch {
    Approach = 0,
    Pause = 1,
    Retract = 2,
}

/// A sample of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sample {
    time_s: f64,
    /// Way of the piezo towards the specimen, from any zero.
    way_m: f64,
    force_n: f64,
}

/// A curve as it grows.
#[derive(Debug, Default)]
struct Curve {
    samples: Vec<Sample>,
    stretches: Vec<Stretch>,
}

impl Curve {
    fn extend(&mut self, stretch: Stretch, samples: impl IntoIterator<Item = Sample>) {
        self.samples.extend(samples);
        self.stretches.resize(self.samples.len(), stretch);
    }

    /// The curve under its name, with the spring constant of its cantilever, N/m.
    fn into_part(self, name: String, spring_n_per_m: f64) -> Part {
        let column = |name: &str, value: fn(&Sample) -> f64| Column {
            name: name.into(),
            unit: None,
            values: self.samples.iter().map(value).collect(),
        };
        let segment = Column {
            name: "afm_segment".into(),
            unit: None,
            values: self.stretches.iter().map(|&stretch| f64::from(stretch as u8)).collect(),
        };
        let columns = vec![
            column("time_s", |sample| sample.time_s),
            column("displacement_mm", |sample| sample.way_m * 1e3),
            column("force_N", |sample| sample.force_n),
            segment,
        ];
        let mut part = Part::columns(name, columns);
        part.setup.push(("spring_constant_N_per_m", spring_n_per_m));
        part
    }
}

/// The whole file, if it is not too large.
fn whole(path: &Path, format: &'static str) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    File::open(path)?.take(TEXT_LIMIT + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > TEXT_LIMIT { Err(too_much_text(format, "file")) } else { Ok(bytes) }
}

/// Whole numbers with a sign, of 2, 4 or 8 bytes each.
fn whole_numbers(bytes: &[u8], size: usize, big_endian: bool) -> Vec<i64> {
    let number = |word: &[u8]| {
        let mut wide = [0; 8];
        let upper = &mut wide[8 - size..];
        upper.copy_from_slice(word);
        if big_endian {
            upper.reverse();
        }
        // It stands in the upper bytes: shifting it down keeps its sign.
        i64::from_le_bytes(wide) >> (64 - 8 * size)
    };
    bytes.chunks_exact(size).map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_keep_their_sign_in_either_order() {
        assert_eq!(whole_numbers(&[0xFF, 0xFE, 0x00, 0x03], 2, true), [-2, 3]);
        assert_eq!(whole_numbers(&[0xFE, 0xFF, 0x03, 0x00], 2, false), [-2, 3]);
        assert_eq!(whole_numbers(&(-70_000_i32).to_be_bytes(), 4, true), [-70_000]);
        assert_eq!(whole_numbers(&(-70_000_i64).to_le_bytes(), 8, false), [-70_000]);
    }
}
