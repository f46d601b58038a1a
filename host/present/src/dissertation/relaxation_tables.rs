//! Tables 3.1 to 3.4: relaxation of grasped sushi, eq. 3.4 fitted to the hold.

/// One row of Tables 3.1–3.3: one grasp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelaxationRow {
    /// Compression during the hold, mm.
    pub compression: f64,
    /// Number of the row, 1 to 10.
    pub number: u32,
    /// Shares c0, c1, c2.
    pub shares: [f64; 3],
    /// Rates v1, v2, 1/s.
    pub rates: [f64; 2],
    /// Force N^(e) at the start of the hold, N.
    pub force: f64,
    /// Coefficient of determination of the fit.
    pub r_squared: f64,
}

/// One line of Table 3.4: a coefficient over the ten grasps of one compression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistic {
    /// Compression during the hold, mm.
    pub compression: f64,
    /// Name of the coefficient.
    pub coefficient: &'static str,
    /// Mean over the ten rows.
    pub mean: f64,
    /// Sample standard deviation (n − 1) over the ten rows.
    pub deviation: f64,
}

const fn row(
    compression: f64,
    number: u32,
    shares: [f64; 3],
    rates: [f64; 2],
    force: f64,
    r_squared: f64,
) -> RelaxationRow {
    RelaxationRow { compression, number, shares, rates, force, r_squared }
}

const fn statistic(
    compression: f64,
    coefficient: &'static str,
    mean: f64,
    deviation: f64,
) -> Statistic {
    Statistic { compression, coefficient, mean, deviation }
}

/// Force N^(e) of eq. 3.5 at the start of the hold at 12 mm, N.
pub const EQUATION_3_5: f64 = 2.187;

/// Table 3.1: 12 mm.
#[rustfmt::skip]
pub const TABLE_3_1: [RelaxationRow; 10] = [
    row(12.0, 1, [0.5007, 0.2390, 0.2604], [3.666, 0.4860], 2.285, 0.9987),
    row(12.0, 2, [0.4872, 0.2506, 0.2622], [3.659, 0.4710], 1.963, 0.9983),
    row(12.0, 3, [0.4817, 0.2552, 0.2631], [3.525, 0.4838], 1.434, 0.9977),
    row(12.0, 4, [0.5127, 0.2391, 0.2482], [3.646, 0.4928], 1.901, 0.9985),
    row(12.0, 5, [0.5016, 0.2401, 0.2583], [3.672, 0.5145], 1.991, 0.9988),
    row(12.0, 6, [0.4852, 0.2472, 0.2676], [3.981, 0.5325], 2.187, 0.9986),
    row(12.0, 7, [0.4674, 0.2740, 0.2586], [3.743, 0.4704], 1.530, 0.9973),
    row(12.0, 8, [0.4345, 0.2786, 0.2869], [3.856, 0.5329], 1.418, 0.9980),
    row(12.0, 9, [0.4849, 0.2605, 0.2546], [3.699, 0.5016], 1.944, 0.9987),
    row(12.0, 10, [0.4894, 0.2427, 0.2679], [3.737, 0.5194], 2.922, 0.9995),
];

/// Table 3.2: 8 mm.
#[rustfmt::skip]
pub const TABLE_3_2: [RelaxationRow; 10] = [
    row(8.0, 1, [0.5143, 0.2371, 0.2485], [3.758, 0.4561], 1.166, 0.9961),
    row(8.0, 2, [0.5188, 0.2313, 0.2499], [3.725, 0.4779], 0.985, 0.9957),
    row(8.0, 3, [0.5101, 0.2701, 0.2196], [3.180, 0.4300], 1.089, 0.9953),
    row(8.0, 4, [0.4738, 0.2732, 0.2529], [3.705, 0.4956], 1.117, 0.9960),
    row(8.0, 5, [0.4649, 0.2506, 0.2844], [3.948, 0.4546], 0.956, 0.9955),
    row(8.0, 6, [0.5275, 0.2313, 0.2411], [3.493, 0.4247], 0.957, 0.9941),
    row(8.0, 7, [0.5395, 0.2242, 0.2362], [3.935, 0.4769], 1.336, 0.9974),
    row(8.0, 8, [0.5572, 0.2250, 0.2178], [3.410, 0.4885], 0.987, 0.9923),
    row(8.0, 9, [0.5244, 0.2415, 0.2340], [3.351, 0.4523], 1.427, 0.9965),
    row(8.0, 10, [0.5296, 0.2324, 0.2379], [3.725, 0.4829], 1.154, 0.9956),
];

/// Table 3.3: 4 mm.
#[rustfmt::skip]
pub const TABLE_3_3: [RelaxationRow; 10] = [
    row(4.0, 1, [0.5281, 0.2517, 0.2201], [2.711, 0.2828], 0.4715, 0.9724),
    row(4.0, 2, [0.5692, 0.2133, 0.2173], [3.584, 0.3972], 0.4331, 0.9770),
    row(4.0, 3, [0.6030, 0.1918, 0.2051], [3.731, 0.4896], 0.6053, 0.9824),
    row(4.0, 4, [0.6006, 0.1833, 0.2160], [3.960, 0.5163], 0.6828, 0.9849),
    row(4.0, 5, [0.5721, 0.2120, 0.2158], [4.160, 0.6349], 0.3661, 0.9542),
    row(4.0, 6, [0.6186, 0.1651, 0.2161], [3.786, 0.6427], 0.4254, 0.9650),
    row(4.0, 7, [0.5743, 0.1885, 0.2371], [5.111, 0.6607], 0.3781, 0.9455),
    row(4.0, 8, [0.5617, 0.2342, 0.2040], [3.124, 0.3497], 0.4862, 0.9495),
    row(4.0, 9, [0.5353, 0.2439, 0.2207], [3.497, 0.4513], 0.4081, 0.9630),
    row(4.0, 10, [0.5139, 0.2355, 0.2505], [2.958, 0.2553], 0.5588, 0.9842),
];

/// Table 3.4: mean and standard deviation of the coefficients.
#[rustfmt::skip]
pub const TABLE_3_4: [Statistic; 15] = [
    statistic(12.0, "c0", 0.4845, 0.0215),
    statistic(12.0, "c1", 0.2527, 0.0144),
    statistic(12.0, "c2", 0.2628, 0.0103),
    statistic(12.0, "v1", 3.7184, 0.1249),
    statistic(12.0, "v2", 0.5005, 0.0234),
    statistic(8.0, "c0", 0.5161, 0.0280),
    statistic(8.0, "c1", 0.2417, 0.0176),
    statistic(8.0, "c2", 0.2422, 0.0189),
    statistic(8.0, "v1", 3.6230, 0.2541),
    statistic(8.0, "v2", 0.4639, 0.0243),
    statistic(4.0, "c0", 0.5677, 0.0342),
    statistic(4.0, "c1", 0.2120, 0.0291),
    statistic(4.0, "c2", 0.2203, 0.0140),
    statistic(4.0, "v1", 3.6622, 0.6814),
    statistic(4.0, "v2", 0.4681, 0.1480),
];

#[cfg(test)]
mod tests {
    use super::*;

    fn column(row: &RelaxationRow, coefficient: &str) -> f64 {
        match coefficient {
            "c0" => row.shares[0],
            "c1" => row.shares[1],
            "c2" => row.shares[2],
            "v1" => row.rates[0],
            _ => row.rates[1],
        }
    }

    #[test]
    fn shares_sum_to_one_as_printed() {
        for row in TABLE_3_1.iter().chain(&TABLE_3_2).chain(&TABLE_3_3) {
            let sum: f64 = row.shares.iter().sum();
            assert!((sum - 1.0).abs() < 2.5e-4, "{row:?}");
        }
    }

    #[test]
    fn table_3_4_follows_from_the_rows_with_the_sample_deviation() {
        for line in TABLE_3_4 {
            let table = match line.compression {
                12.0 => TABLE_3_1,
                8.0 => TABLE_3_2,
                _ => TABLE_3_3,
            };
            let values = table.map(|row| column(&row, line.coefficient));
            let mean = values.iter().sum::<f64>() / 10.0;
            let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
            // Half a unit of the last digit of the rows, and as much again of the line.
            let rounding = if line.coefficient == "v1" { 5.5e-4 } else { 1e-4 };
            assert!((mean - line.mean).abs() <= rounding, "{line:?}: {mean}");
            assert!(((square / 9.0).sqrt() - line.deviation).abs() <= rounding, "{line:?}");
        }
    }
}
