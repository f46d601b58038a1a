//! How far a load is from slip.
//!
//! The limit surface is convex and each of its points belongs to a motion, so the largest multiple of a load
//! that still holds is the least of h(t)/(load·t) over all motions t: the motion that gives way first. Over
//! the motions with load·t = 1, which are a plane, this is the minimum of a convex function of two unknowns.
//! In units in which the largest moment counts like the largest force the surface is close to a ball, so
//! the minimum lies close to the load itself, and quasi-Newton steps (BFGS) find it in a few.

use nalgebra::{Matrix2, Matrix3x2, Vector2, Vector3};

use super::contact::{Contact, Load, Motion};

/// What is left until slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// The load could be so many times as large; slip at 1 and below. Infinite without a load.
    pub factor: f64,
    /// The motion that begins then, scaled so that the larger of speed, mm/s, and turn times the contact's
    /// arm is about 1; none without a load or without a contact.
    pub motion: Option<Motion>,
}

impl Margin {
    /// Whether the contact slips under the load.
    #[must_use]
    pub fn slips(&self) -> bool {
        self.factor <= 1.0
    }
}

/// Steps of the search at most; it takes about ten.
const STEPS: usize = 200;
/// Halvings of one step at most.
const HALVINGS: u32 = 40;
/// A step that promises less than this, relatively, is not worth taking.
const MIN_GAIN: f64 = 1e-15;
/// Share of the promised decrease that a step must bring.
const SUFFICIENT: f64 = 1e-4;

/// The factor by which a load could grow until the contact slips, to about 1e-9 of itself.
///
/// `friction` is μN, N; at 0 and below nothing holds. A load that is not a number gives a factor that is not
/// a number.
#[must_use]
pub fn margin(contact: &Contact, friction: f64, load: &Load) -> Margin {
    let wanted = Vector3::new(load.force[0], load.force[1], load.moment / contact.arm());
    let size = wanted.norm();
    if size == 0.0 {
        return Margin { factor: f64::INFINITY, motion: None };
    }
    // Not a number is not below or at zero.
    if friction <= 0.0 || !(size / friction).is_finite() {
        let factor = if (size + friction).is_nan() { f64::NAN } else { 0.0 };
        return Margin { factor, motion: None };
    }
    let (least, motion) = first_to_give_way(contact, wanted / size);
    Margin { factor: least * friction / size, motion: Some(motion) }
}

/// The least resistance to the motions that a load of unit size drives, and the motion.
fn first_to_give_way(contact: &Contact, load: Vector3<f64>) -> (f64, Motion) {
    let across = across(&load);
    let motion = |x: &Vector2<f64>| motion(contact, &(load + across * x));
    // Resistance and its slope within the plane.
    let resistance = |x: &Vector2<f64>| {
        let held = contact.slipping(&motion(x));
        let held = Vector3::new(held.force[0], held.force[1], held.moment / contact.arm());
        (held.dot(&(load + across * x)), across.tr_mul(&held))
    };
    let mut x = Vector2::zeros();
    let (mut least, mut slope) = resistance(&x);
    let mut curvature = Matrix2::identity();
    for _ in 0..STEPS {
        let step: Vector2<f64> = -(curvature * slope);
        let promised = -slope.dot(&step);
        if promised <= MIN_GAIN * least {
            break;
        }
        let shortened = (0..HALVINGS).find_map(|halvings| {
            let step = step * 0.5f64.powi(halvings as i32);
            let (value, there) = resistance(&(x + step));
            let enough = least + SUFFICIENT * slope.dot(&step);
            (value <= enough).then_some((step, value, there))
        });
        // Where no step brings anything, rounding is all that is left.
        let Some((step, value, there)) = shortened else { break };
        let turned = there - slope;
        (x, least, slope) = (x + step, value, there);
        curvature = updated(&curvature, &step, &turned);
    }
    (least, motion(&x))
}

/// The inverse curvature after a step along which the slope turned so far (BFGS).
fn updated(curvature: &Matrix2<f64>, step: &Vector2<f64>, turned: &Vector2<f64>) -> Matrix2<f64> {
    let along = step.dot(turned);
    if along <= f64::EPSILON * step.norm() * turned.norm() {
        return *curvature;
    }
    let project = Matrix2::identity() - step * turned.transpose() / along;
    project * curvature * project.transpose() + step * step.transpose() / along
}

/// Two unit vectors across a unit vector and each other.
fn across(load: &Vector3<f64>) -> Matrix3x2<f64> {
    let [x, y] = [load.x, load.y];
    let flat = x.hypot(y);
    let side = if flat > 0.0 { Vector3::new(-y / flat, x / flat, 0.0) } else { Vector3::y() };
    Matrix3x2::from_columns(&[side, load.cross(&side)])
}

/// The motion of which these are velocity and, times the arm, turn.
fn motion(contact: &Contact, motion: &Vector3<f64>) -> Motion {
    Motion { velocity: [motion.x, motion.y], turn: motion.z / contact.arm() }
}

#[cfg(test)]
mod tests {
    use super::super::contact::Shape;
    use super::super::pressure::PressureLaw;
    use super::*;
    use proptest::prelude::*;

    fn contact(shape: Shape, exponent: f64) -> Contact {
        Contact::new(shape, PressureLaw::new(exponent).unwrap()).unwrap()
    }

    fn shapes() -> impl Strategy<Value = Shape> {
        (0u8..3, 0.05f64..20.0, 0.05f64..20.0).prop_map(|(kind, a, b)| match kind {
            0 => Shape::Rectangle { length: a, width: b },
            1 => Shape::Circle { radius: a },
            _ => Shape::Ellipse { x: a, y: b },
        })
    }

    #[test]
    fn without_a_moment_the_margin_is_the_friction_over_the_force_in_every_direction() {
        for shape in
            [Shape::Rectangle { length: 42.0, width: 26.0 }, Shape::Ellipse { x: 3.0, y: 9.0 }]
        {
            let contact = contact(shape, 4.0);
            for force in [[0.3, 0.0], [0.0, -0.3], [0.18, 0.24]] {
                let found = margin(&contact, 1.4, &Load { force, moment: 0.0 });
                let expected = 1.4 / force[0].hypot(force[1]);
                assert!((found.factor / expected - 1.0).abs() < 1e-12, "{shape:?} {force:?}");
            }
        }
    }

    #[test]
    fn a_moment_alone_holds_up_to_the_friction_times_the_arm() {
        let contact = contact(Shape::Circle { radius: 6.0 }, f64::INFINITY);
        let found = margin(&contact, 0.5, &Load { force: [0.0, 0.0], moment: -1.0 });
        assert!((found.factor - 2.0).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn what_cannot_slip_or_cannot_hold_is_told() {
        let contact = contact(Shape::Circle { radius: 6.0 }, 2.0);
        let load = Load { force: [0.1, 0.0], moment: 0.2 };
        assert_eq!(margin(&contact, 1.0, &Load::default()).factor, f64::INFINITY);
        assert_eq!(margin(&contact, 0.0, &load).factor, 0.0);
        assert_eq!(margin(&contact, -1.0, &load).factor, 0.0);
        assert!(margin(&contact, f64::NAN, &load).factor.is_nan());
        assert!(margin(&contact, 1.0, &load.times(f64::NAN)).factor.is_nan());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        #[test]
        fn a_load_times_its_margin_lies_on_the_surface(
            shape in shapes(), exponent in 1f64..20.0, angle in 0f64..6.3, height in -1.6f64..1.6,
            log_size in -12f64..6.0,
        ) {
            let contact = contact(shape, exponent);
            let size = 10f64.powf(log_size);
            let force = [angle.cos(), angle.sin()].map(|part| part * height.cos() * size);
            let load = Load { force, moment: height.sin() * size * contact.arm() };
            let found = margin(&contact, 0.8, &load);
            let limit = load.times(found.factor / 0.8);
            let held = contact.slipping(&found.motion.unwrap());
            // The surface at that motion is the load itself, as far as its curvature allows to tell.
            prop_assert!((held.force[0] - limit.force[0]).abs() < 1e-5);
            prop_assert!((held.force[1] - limit.force[1]).abs() < 1e-5);
            prop_assert!((held.moment - limit.moment).abs() < 1e-5 * contact.arm());
        }

        #[test]
        fn a_point_of_the_surface_has_the_margin_one(
            shape in shapes(), exponent in 1f64..20.0, x in -1f64..1.0, y in -1f64..1.0,
            turn in -2f64..2.0,
        ) {
            let contact = contact(shape, exponent);
            let slipping = Motion { velocity: [x, y], turn: turn / contact.arm() };
            let load = contact.slipping(&slipping).times(1.4);
            let found = margin(&contact, 1.4, &load).factor;
            prop_assert!((found - 1.0).abs() < 1e-9, "{found}");
        }

        #[test]
        fn half_the_load_has_twice_the_margin_and_less_grip_has_less(
            shape in shapes(), fx in -1f64..1.0, fy in -1f64..1.0, m in -9f64..9.0,
        ) {
            let contact = contact(shape, 4.0);
            let load = Load { force: [fx, fy], moment: m };
            let one = margin(&contact, 1.4, &load).factor;
            let half = margin(&contact, 1.4, &load.times(0.5)).factor;
            let less = margin(&contact, 1.3, &load).factor;
            prop_assert!((half / one - 2.0).abs() < 1e-9);
            prop_assert!(less < one);
        }
    }
}
