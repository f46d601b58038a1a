//! Short vectors of fixed length: written so that the compiler keeps them in SSE registers.

/// Sum of products. Four partial sums, because a single one may not be reordered into lanes.
#[inline(always)]
pub(super) fn dot<const R: usize>(a: &[f64; R], b: &[f64; R]) -> f64 {
    let mut sum = [0.0; 4];
    for (a, b) in a.as_chunks::<4>().0.iter().zip(b.as_chunks::<4>().0) {
        for lane in 0..4 {
            sum[lane] += a[lane] * b[lane];
        }
    }
    (sum[0] + sum[1]) + (sum[2] + sum[3])
}

/// `a += factor · b`.
#[inline(always)]
pub(super) fn add_scaled<const R: usize>(a: &mut [f64; R], factor: f64, b: &[f64; R]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += factor * b;
    }
}

/// `a *= factor`.
#[inline(always)]
pub(super) fn scale<const R: usize>(a: &mut [f64; R], factor: f64) {
    for a in a {
        *a *= factor;
    }
}
