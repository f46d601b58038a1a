//! e^x of many numbers: the same steps for each of them, so that a processor takes several at once.

/// 1.5 · 2^52: a number of usual size added to it loses all digits behind the point.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two parts: products of the first with whole numbers up to a thousand are exact.
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
/// Beyond these the result is no normal number.
const LEAST: f64 = -708.0;
const MOST: f64 = 709.0;
/// 1/k! of odd k, and of even k from 2 on, from the highest on that rounding leaves within ±ln(2)/2.
const ODD: [f64; 6] =
    [1.0 / 39_916_800.0, 1.0 / 362_880.0, 1.0 / 5_040.0, 1.0 / 120.0, 1.0 / 6.0, 1.0];
const EVEN: [f64; 6] =
    [1.0 / 479_001_600.0, 1.0 / 3_628_800.0, 1.0 / 40_320.0, 1.0 / 720.0, 1.0 / 24.0, 0.5];

/// e^x within two units of the last digit; 0 below −708, and above 709 that of the limit.
#[inline]
pub fn exp(x: f64) -> f64 {
    let given = x;
    let x = x.clamp(LEAST, MOST);
    let shifted = x * std::f64::consts::LOG2_E + ROUND;
    let whole = shifted - ROUND;
    let rest = (x - whole * LN_2[0]) - whole * LN_2[1];
    let square = rest * rest;
    let series = |terms: &[f64; 6]| terms.iter().fold(0.0, |sum, term| sum * square + term);
    let part = 1.0 + (rest * series(&ODD) + square * series(&EVEN));
    // The last digits of `shifted` are the whole number, which goes to the exponent.
    let power = f64::from_bits(part.to_bits().wrapping_add(shifted.to_bits() << 52));
    // Not a number so small that a processor takes its time over it.
    if given < LEAST { 0.0 } else { power }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_that_of_the_library_to_the_last_digits() {
        let mut worst: f64 = 0.0;
        for k in -70_000..=70_000 {
            let x = f64::from(k) * 0.010_012_345;
            worst = worst.max((exp(x) / x.exp() - 1.0).abs());
        }
        assert!(worst <= 4.5e-16, "{worst:.1e}");
        assert_eq!(exp(0.0), 1.0);
        assert_eq!((exp(f64::NEG_INFINITY), exp(LEAST - 1e-9)), (0.0, 0.0));
        assert!(exp(LEAST) > 0.0 && exp(MOST).is_finite() && exp(f64::NAN).is_nan());
    }
}
