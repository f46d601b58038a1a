//! Strain and strain rate of a specimen from its force, and the power law of the latency model for each
//! hold: ε̇ = −ν sgn(ε − ε_e) |ε − ε_e|^n (chapter 7).
//!
//! What is fitted is the strain itself ([`palpate_fit::power_law`]); its derivative is only drawn.
//! Strain is positive in compression here.

use std::ops::Range;

use shared::phase::RelaxationType;

use super::controlled::{ForceControlled, displacement_controlled};
use super::derivative::{Derivative, derivative};
use super::geometry::{Faces, Geometry, GeometryError};
use palpate_fit::power_law::{self, ODD_ORDERS, PowerFit};
use palpate_trace::{DISPLACEMENT, FORCE, SignalError, Trace, holds};

/// 95 % of χ² with one degree of freedom: what an order may fit worse than the best and still fit.
const AS_GOOD: f64 = 3.841_458_820_694_124;
/// Fewest samples of a hold.
const MIN_HOLD_SAMPLES: usize = 8;
/// Instants at which the strain rate is drawn.
const INSTANTS: usize = 120;

/// Which order n is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// This one.
    Fixed(f64),
    /// As a parameter of every hold.
    Free,
    /// The lowest odd one that fits all holds together as well as the best, within χ² of 95 %.
    LowestOdd,
}

/// One hold.
#[derive(Clone, Debug)]
pub struct Hold {
    /// Name of the trace.
    pub trace: String,
    /// Its samples.
    pub range: Range<usize>,
    /// When it began, s.
    pub from_s: f64,
    /// How long it lasted, s.
    pub duration_s: f64,
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Area of contact, mm².
    pub area_mm2: f64,
    /// Type I after loading, Type II after unloading.
    pub relaxation: RelaxationType,
    /// Strain of the contact, compression positive (7.6), (7.8).
    pub strain: Vec<f64>,
    /// The fit.
    pub fit: PowerFit,
    /// Lowest and highest odd order that fit this hold as well as the best.
    pub odd_orders: (f64, f64),
    /// Strain rate, for drawing.
    pub measured: Option<Derivative>,
}

/// The holds of some traces.
#[derive(Clone, Debug)]
pub struct Study {
    /// Geometry of each trace.
    pub geometry: Vec<Geometry>,
    /// Modulus E, Pa.
    pub modulus_pa: f64,
    /// What was asked of the order.
    pub asked: Order,
    /// The order of all holds; none where it was free.
    pub order: Option<f64>,
    /// The holds, in order.
    pub holds: Vec<Hold>,
}

/// Why strain rates cannot be found.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum StrainRateError {
    #[error(transparent)]
    Signal(#[from] SignalError),
    #[error(transparent)]
    Controlled(#[from] ForceControlled),
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    #[error(
        "{trace}: the hold from {from_s:.3} s has {samples} samples, {MIN_HOLD_SAMPLES} are needed. Record longer or faster."
    )]
    Short { trace: String, from_s: f64, samples: usize },
    #[error(
        "{trace}: at the hold from {from_s:.3} s the displacement is {displacement_mm} mm: nothing touches, so force is no strain"
    )]
    NoContact { trace: String, from_s: f64, displacement_mm: f64 },
}

/// Fits the power law to every hold of the traces, for a modulus in Pa.
///
/// # Errors
/// When a trace lacks displacement, force or geometry, was force controlled, or has no hold that can be
/// fitted.
pub fn strain_rate(
    traces: &[Trace],
    modulus_pa: f64,
    order: Order,
    faces: Faces,
) -> Result<Study, StrainRateError> {
    let mut geometries = Vec::new();
    let mut prepared = Vec::new();
    for trace in traces {
        displacement_controlled(trace)?;
        let geometry = Geometry::of(&trace.head.specimen, faces, &trace.label())?;
        let (displacement, force) = (trace.changing(DISPLACEMENT)?, trace.changing(FORCE)?);
        for range in holds(trace, FORCE)? {
            prepared.push(Strains::of(trace, displacement, force, range, &geometry, modulus_pa)?);
        }
        geometries.push(geometry);
    }
    let scans: Vec<Vec<PowerFit>> = prepared.iter().map(Strains::scan).collect();
    let common = match order {
        Order::Fixed(n) => Some(n),
        Order::Free => None,
        Order::LowestOdd => Some(lowest_of_all(&scans)),
    };
    let holds = prepared.into_iter().zip(scans).map(|(s, scan)| s.hold(&scan, common)).collect();
    Ok(Study { geometry: geometries, modulus_pa, asked: order, order: common, holds })
}

/// Residual sums over their own variance: each order's, less the least.
fn excess(scan: &[PowerFit]) -> Vec<f64> {
    let best = scan.iter().min_by(|a, b| a.rss.total_cmp(&b.rss));
    let Some(best) = best else { return Vec::new() };
    let variance = best.noise.powi(2).max(f64::MIN_POSITIVE);
    scan.iter().map(|fit| (fit.rss - best.rss) / variance).collect()
}

/// The lowest order whose excess, summed over the holds, is no more than χ² allows.
pub(super) fn lowest_of_all(scans: &[Vec<PowerFit>]) -> f64 {
    let mut sums = vec![0.0; ODD_ORDERS.len()];
    for scan in scans {
        for (sum, excess) in sums.iter_mut().zip(excess(scan)) {
            *sum += excess;
        }
    }
    let least = sums.iter().copied().fold(f64::INFINITY, f64::min);
    let place = sums.iter().position(|sum| *sum <= least + AS_GOOD).unwrap_or(0);
    ODD_ORDERS[place]
}

/// Lowest and highest odd order that fit as well as the best; none where no order has a residual that can be compared.
pub(super) fn as_good_orders(scan: &[PowerFit]) -> Option<(f64, f64)> {
    let orders = excess(scan).into_iter().zip(ODD_ORDERS);
    let as_good: Vec<f64> =
        orders.filter(|(excess, _)| *excess <= AS_GOOD).map(|(_, order)| order).collect();
    Some((*as_good.first()?, *as_good.last()?))
}

/// The strain of one hold.
struct Strains {
    trace: String,
    range: Range<usize>,
    from_s: f64,
    /// Time since the hold began, s.
    time: Vec<f64>,
    strain: Vec<f64>,
    displacement_mm: f64,
    area_mm2: f64,
}

impl Strains {
    fn of(
        trace: &Trace,
        displacement: &[f64],
        force: &[f64],
        range: Range<usize>,
        geometry: &Geometry,
        modulus_pa: f64,
    ) -> Result<Self, StrainRateError> {
        let from_s = trace.time[range.start];
        let samples = range.len();
        if samples < MIN_HOLD_SAMPLES {
            return Err(StrainRateError::Short { trace: trace.label(), from_s, samples });
        }
        let held = &displacement[range.clone()];
        let displacement_mm = held.iter().sum::<f64>() / samples as f64;
        let area_mm2 = geometry.area_mm2(displacement_mm);
        if displacement_mm <= 0.0 || area_mm2 <= 0.0 {
            let trace = trace.label();
            return Err(StrainRateError::NoContact { trace, from_s, displacement_mm });
        }
        let strain = force[range.clone()].iter().map(|f| 1e6 * f / area_mm2 / modulus_pa).collect();
        let time = trace.elapsed(range.clone()).into_owned();
        Ok(Self { trace: trace.label(), range, from_s, time, strain, displacement_mm, area_mm2 })
    }

    /// The fits with every odd order.
    fn scan(&self) -> Vec<PowerFit> {
        ODD_ORDERS.iter().map(|n| power_law::fit(&self.time, &self.strain, Some(*n))).collect()
    }

    fn duration(&self) -> f64 {
        self.time[self.time.len() - 1]
    }

    fn hold(self, scan: &[PowerFit], order: Option<f64>) -> Hold {
        let known = order.and_then(|n| scan.iter().find(|fit| fit.law.order == n)).cloned();
        let mut fit = known.unwrap_or_else(|| power_law::fit(&self.time, &self.strain, order));
        // Only numbers beyond all measure have no order that fits best.
        let odd_orders = as_good_orders(scan).unwrap_or((fit.law.order, fit.law.order));
        if odd_orders.0 == ODD_ORDERS[ODD_ORDERS.len() - 1] {
            fit.doubts.push(format!(
                "the highest order tried, {}, fits best: no power law describes this hold; several rates may (`palpate relaxation`)",
                odd_orders.0
            ));
        }
        if odd_orders.0 < odd_orders.1 {
            fit.doubts.push(format!(
                "odd orders from {} to {} fit this hold equally well: ν of one order says nothing of another",
                odd_orders.0, odd_orders.1
            ));
        }
        let relaxation = match fit.gap {
            (gap, _) if gap > 0.0 => RelaxationType::TypeI,
            (gap, _) if gap < 0.0 => RelaxationType::TypeII,
            _ => RelaxationType::None,
        };
        Hold {
            measured: derivative(&self.time, &self.strain, fit.noise, INSTANTS),
            duration_s: self.duration(),
            trace: self.trace,
            range: self.range,
            from_s: self.from_s,
            displacement_mm: self.displacement_mm,
            area_mm2: self.area_mm2,
            relaxation,
            strain: self.strain,
            fit,
            odd_orders,
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;
    use palpate_model::latency::Power;
    use palpate_trace::Shape;

    const MODULUS: f64 = 2.8e4;

    /// A ball of 35 mm pressed to 10 mm, held for 10 s; strain by the law.
    fn ball(law: Power, noise_n: f64, seed: u64) -> Trace {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let normal = Normal::new(0.0, noise_n).unwrap();
        let geometry = Geometry::Ball { radius_mm: 35.0, faces: Faces::One };
        let time: Vec<f64> = (0..1200).map(|k| 0.01 * f64::from(k)).collect();
        let x: Vec<f64> = time.iter().map(|t| (10.0 * t).min(10.0)).collect();
        let force = time.iter().zip(&x).map(|(&t, &x)| {
            let strain = if t < 1.0 { law.initial * t } else { law.strain(t - 1.0) };
            MODULUS * strain * geometry.area_mm2(x) * 1e-6 + normal.sample(&mut random)
        });
        let force = force.collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.head.specimen.shape = Some(Shape::Sphere);
        trace.head.specimen.radius_mm = Some(35.0);
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, force);
        trace
    }

    const LAW: Power = Power { rate: 2.6e4, order: 5.0, equilibrium: 0.2193, initial: 0.3193 };

    #[test]
    fn the_law_of_a_ball_comes_back_from_its_force() {
        for law in [LAW, Power { initial: 0.15, rate: 7e4, ..LAW }] {
            let trace = ball(law, 0.0, 1);
            let study =
                strain_rate(std::slice::from_ref(&trace), MODULUS, Order::Fixed(5.0), Faces::One);
            let hold = &study.unwrap().holds[0];
            assert!((hold.fit.law.rate / law.rate - 1.0).abs() < 1e-3, "{:?}", hold.fit);
            assert!((hold.fit.law.equilibrium - law.equilibrium).abs() < 1e-5);
            let expected = if law.initial > law.equilibrium {
                RelaxationType::TypeI
            } else {
                RelaxationType::TypeII
            };
            assert_eq!(hold.relaxation, expected);
        }
    }

    #[test]
    fn the_errors_are_those_of_repeats_and_the_order_is_found() {
        let mut deviations = Vec::new();
        for seed in 0..20 {
            let trace = ball(LAW, 0.005, seed);
            let traces = std::slice::from_ref(&trace);
            let hold = strain_rate(traces, MODULUS, Order::Fixed(5.0), Faces::One)
                .unwrap()
                .holds
                .remove(0);
            deviations.push((hold.fit.law.rate / LAW.rate).ln() / hold.fit.rate.1.unwrap());
            deviations
                .push((hold.fit.equilibrium.0 - LAW.equilibrium) / hold.fit.equilibrium.1.unwrap());
            assert!(hold.odd_orders.0 <= 5.0 && 5.0 <= hold.odd_orders.1);
        }
        let square = deviations.iter().map(|d| d * d).sum::<f64>() / deviations.len() as f64;
        assert!((0.5..1.7).contains(&square), "{square}");
    }

    #[test]
    fn the_lowest_odd_order_that_fits_is_the_one_it_was_made_with() {
        for order in [1.0, 3.0, 5.0] {
            let gap: f64 = 0.1;
            let law = Power { rate: 2.6 / gap.powf(order - 1.0), order, ..LAW };
            let traces = [ball(law, 0.002, 1), ball(law, 0.002, 2)];
            let study = strain_rate(&traces, MODULUS, Order::LowestOdd, Faces::One).unwrap();
            assert_eq!(study.order, Some(order));
        }
    }

    #[test]
    fn a_free_order_says_that_it_trades_off_with_the_rate() {
        let trace = ball(LAW, 0.01, 3);
        let study =
            strain_rate(std::slice::from_ref(&trace), MODULUS, Order::Free, Faces::One).unwrap();
        let fit = &study.holds[0].fit;
        assert!((fit.order.0 - 5.0).abs() < 4.0 * fit.order.1.unwrap(), "{fit:?}");
        assert!(fit.trade_off.unwrap().abs() > 0.9, "{fit:?}");
    }

    #[test]
    fn half_the_displacement_on_each_face_is_another_strain() {
        let trace = ball(LAW, 0.0, 1);
        let traces = std::slice::from_ref(&trace);
        let of =
            |faces| strain_rate(traces, MODULUS, Order::Fixed(5.0), faces).unwrap().holds.remove(0);
        let (one, each) = (of(Faces::One), of(Faces::Each));
        assert!(
            (each.fit.law.equilibrium / one.fit.law.equilibrium - one.area_mm2 / each.area_mm2)
                .abs()
                < 1e-3
        );
    }
}
