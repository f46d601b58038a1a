//! The limit surface, by scanning the centre of rotation over the whole plane (6.4.5).

use std::f64::consts::{FRAC_PI_2, PI};

use super::contact::{Contact, Load, Motion};

/// One point of a limit surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The motion at which the contact slips there.
    pub motion: Motion,
    /// The load: tangential force, N, and moment, N mm.
    pub load: Load,
}

/// Half of a limit surface, for turns from x to y; the other half is its mirror image through the origin.
///
/// `friction` is μN, N. The centre of rotation goes outwards from the middle of the contact in `directions`
/// directions, in `steps` steps up to infinity, where the motion is a pure translation: `directions · steps`
/// points and one for the middle. Steps are equal in the angle between turn and translation, one mm/s counting
/// like one over the contact's arm in rad/s, which spreads the points evenly.
#[must_use]
pub fn limit_surface(
    contact: &Contact,
    friction: f64,
    directions: usize,
    steps: usize,
) -> Vec<SurfacePoint> {
    let whole = (0..steps).rev().flat_map(|step| {
        let slope = FRAC_PI_2 * step as f64 / steps as f64;
        (0..directions).map(move |direction| {
            let angle = 2.0 * PI * direction as f64 / directions as f64;
            (angle, slope)
        })
    });
    let middle = std::iter::once((0.0, FRAC_PI_2));
    middle.chain(whole).map(|(angle, slope)| point(contact, friction, angle, slope)).collect()
}

/// The section of a limit surface that one axis of the contact cuts out: force along the axis at `angle`,
/// 0 for x and π/2 for y, from no force to no moment. The centre of rotation goes outwards across the axis,
/// as along x in Fig. 6.9.
#[must_use]
pub fn limit_curve(
    contact: &Contact,
    friction: f64,
    angle: f64,
    points: usize,
) -> Vec<SurfacePoint> {
    let last = points.saturating_sub(1).max(1) as f64;
    let slope = |index: usize| FRAC_PI_2 * (1.0 - index as f64 / last);
    (0..points).map(|index| point(contact, friction, angle, slope(index))).collect()
}

/// The point at which the contact slips with a velocity at `angle` and a turn of `slope`: π/2 is all turn.
fn point(contact: &Contact, friction: f64, angle: f64, slope: f64) -> SurfacePoint {
    let speed = if slope == FRAC_PI_2 { 0.0 } else { slope.cos() };
    let velocity = [speed * angle.cos(), speed * angle.sin()];
    let motion = Motion { velocity, turn: slope.sin() / contact.arm() };
    SurfacePoint { motion, load: contact.slipping(&motion).times(friction) }
}

#[cfg(test)]
mod tests {
    use super::super::contact::Shape;
    use super::super::margin::margin;
    use super::super::pressure::PressureLaw;
    use super::*;

    fn block(exponent: f64) -> Contact {
        let shape = Shape::Rectangle { length: 42.22, width: 26.38 };
        Contact::new(shape, PressureLaw::new(exponent).unwrap()).unwrap()
    }

    #[test]
    fn a_surface_reaches_from_the_largest_moment_to_every_pure_force() {
        let contact = block(4.0);
        let surface = limit_surface(&contact, 1.4, 20, 10);
        assert_eq!(surface.len(), 201);
        assert!((surface[0].load.moment / (1.4 * contact.arm()) - 1.0).abs() < 1e-12);
        assert_eq!(surface[0].motion.centre(), Some([0.0, 0.0]));
        for point in &surface[181..] {
            assert_eq!((point.motion.centre(), point.load.moment), (None, 0.0));
            assert!((point.load.tangential() - 1.4).abs() < 1e-12);
        }
    }

    #[test]
    fn every_point_of_the_surface_is_just_about_to_slip() {
        let contact = block(2.5);
        for point in limit_surface(&contact, 0.3, 7, 6) {
            assert!((margin(&contact, 0.3, &point.load).factor - 1.0).abs() < 1e-9, "{point:?}");
        }
    }

    #[test]
    fn along_an_axis_the_force_grows_as_the_moment_falls() {
        for angle in [0.0, FRAC_PI_2] {
            let curve = limit_curve(&block(4.0), 1.4, angle, 40);
            assert!(curve[0].load.tangential() < 1e-12);
            assert!((curve[39].load.tangential() - 1.4).abs() < 1e-12);
            for pair in curve.windows(2) {
                assert!(pair[1].load.moment < pair[0].load.moment);
                assert!(pair[1].load.tangential() > pair[0].load.tangential());
                let across = pair[1].load.force[usize::from(angle == 0.0)];
                assert!(across.abs() < 1e-9, "the section stays in its plane");
            }
        }
    }
}
