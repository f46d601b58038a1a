//! A soft contact with friction: what it carries when it slips.
//!
//! The friction of a contact that slips with velocity v and turn ω does the work
//! h(v, ω) = ∫ μ p |v + ω × r| dA per second. It is the support function of the limit surface: its slope
//! along (v, ω) is the load (f, m) of eqs 6.7 and 6.8, the one load within the surface that takes the most
//! work out of this motion. So every motion gives one point of the surface, and the surface is convex.

use super::ellipse::Ellipse;
use super::pressure::PressureLaw;
use super::rectangle::Rectangle;

/// Shape of a contact, centred in the middle, its axes along x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Pressure varies along x (eq. 6.10).
    Rectangle {
        /// Length L along x, mm.
        length: f64,
        /// Width W along y, mm.
        width: f64,
    },
    /// Pressure varies with the distance from the middle (eq. 8.1).
    Circle {
        /// Radius, mm.
        radius: f64,
    },
    /// Pressure is the same along similar ellipses.
    Ellipse {
        /// Semi-axis along x, mm.
        x: f64,
        /// Semi-axis along y, mm.
        y: f64,
    },
}

impl Shape {
    /// Area, mm².
    #[must_use]
    pub fn area(&self) -> f64 {
        match *self {
            Self::Rectangle { length, width } => length * width,
            Self::Circle { radius } => std::f64::consts::PI * radius * radius,
            Self::Ellipse { x, y } => std::f64::consts::PI * x * y,
        }
    }

    /// The two sizes that make the shape, mm.
    const fn sizes(&self) -> [f64; 2] {
        match *self {
            Self::Rectangle { length, width } => [length, width],
            Self::Circle { radius } => [radius, radius],
            Self::Ellipse { x, y } => [x, y],
        }
    }
}

/// How a contact moves on the surface it touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Velocity of the middle of the contact along x and y, mm/s.
    pub velocity: [f64; 2],
    /// Turn about the normal, rad/s, from x to y.
    pub turn: f64,
}

impl Motion {
    /// The centre of rotation, mm; none for a pure translation, whose centre is infinitely far.
    #[must_use]
    pub fn centre(&self) -> Option<[f64; 2]> {
        let [x, y] = self.velocity;
        let centre = [-y / self.turn, x / self.turn];
        centre.iter().all(|place| place.abs() < INFINITELY_FAR).then_some(centre)
    }
}

/// A centre of rotation from here on, mm, is as good as at infinity.
const INFINITELY_FAR: f64 = 1e100;

/// What friction carries, opposed to the motion that it hinders, or what is asked of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Tangential force f along x and y, N.
    pub force: [f64; 2],
    /// Moment m about the normal through the middle, N mm, from x to y.
    pub moment: f64,
}

impl Load {
    /// The load so many times.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        Self { force: self.force.map(|force| factor * force), moment: factor * self.moment }
    }

    /// Size of the tangential force, N.
    #[must_use]
    pub fn tangential(&self) -> f64 {
        self.force[0].hypot(self.force[1])
    }
}

/// A contact that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a contact of {0} by {1} mm cannot be: its sizes must be above 0")]
pub struct SizeError(f64, f64);

/// A soft contact: its shape, and how it presses.
#[derive(Clone, Debug)]
pub struct Contact {
    shape: Shape,
    law: PressureLaw,
    friction: Friction,
    arm: f64,
}

#[derive(Clone, Debug)]
enum Friction {
    Rectangle(Rectangle),
    Ellipse(Ellipse),
}

impl Friction {
    fn about(&self, centre: [f64; 2]) -> ([f64; 2], f64) {
        match self {
            Self::Rectangle(rectangle) => rectangle.about(centre),
            Self::Ellipse(ellipse) => ellipse.about(centre),
        }
    }
}

impl Contact {
    /// A contact of this shape that presses by this law.
    ///
    /// # Errors
    /// When a size is not above 0.
    pub fn new(shape: Shape, law: PressureLaw) -> Result<Self, SizeError> {
        let sizes = checked(&shape)?;
        let friction = match shape {
            Shape::Rectangle { length, width } => {
                Friction::Rectangle(Rectangle::new(length, width, law))
            }
            Shape::Circle { .. } | Shape::Ellipse { .. } => {
                Friction::Ellipse(Ellipse::new(sizes, law))
            }
        };
        Ok(Self::with(shape, law, friction))
    }

    /// A contact of another shape with the same law.
    ///
    /// # Errors
    /// When a size is not above 0.
    pub fn reshaped(&self, shape: Shape) -> Result<Self, SizeError> {
        let sizes = checked(&shape)?;
        match (&self.friction, shape) {
            // What an ellipse makes of its pressure does not depend on its size.
            (Friction::Ellipse(ellipse), Shape::Circle { .. } | Shape::Ellipse { .. }) => {
                let friction = Friction::Ellipse(ellipse.resized(sizes));
                Ok(Self::with(shape, self.law, friction))
            }
            _ => Self::new(shape, self.law),
        }
    }

    fn with(shape: Shape, law: PressureLaw, friction: Friction) -> Self {
        let arm = friction.about([0.0, 0.0]).1;
        Self { shape, law, friction, arm }
    }

    /// Its shape.
    #[must_use]
    pub const fn shape(&self) -> Shape {
        self.shape
    }

    /// How it presses.
    #[must_use]
    pub const fn law(&self) -> PressureLaw {
        self.law
    }

    /// Mean distance of the pressure from the middle, mm: the largest moment is μN times this.
    #[must_use]
    pub const fn arm(&self) -> f64 {
        self.arm
    }

    /// Pressure in the middle over mean pressure, Ck.
    #[must_use]
    pub fn middle_over_mean_pressure(&self) -> f64 {
        match self.shape {
            Shape::Rectangle { .. } => self.law.strip_constant(),
            Shape::Circle { .. } | Shape::Ellipse { .. } => self.law.circular_constant(),
        }
    }

    /// The load on the limit surface at which the contact slips with this motion, for a friction force μN of
    /// 1 N (eqs 6.7, 6.8). Nothing moves, nothing is carried.
    #[must_use]
    pub fn slipping(&self, motion: &Motion) -> Load {
        let Some(centre) = motion.centre() else {
            let [x, y] = motion.velocity;
            let speed = x.hypot(y);
            let force = if speed > 0.0 { [x / speed, y / speed] } else { [0.0, 0.0] };
            return Load { force, moment: 0.0 };
        };
        let ([x, y], moment) = self.friction.about(centre);
        Load { force: [-y, x], moment }.times(motion.turn.signum())
    }
}

/// The sizes, which must be above zero.
fn checked(shape: &Shape) -> Result<[f64; 2], SizeError> {
    let sizes @ [a, b] = shape.sizes();
    if sizes.iter().all(|size| *size > 0.0 && size.is_finite()) {
        Ok(sizes)
    } else {
        Err(SizeError(a, b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn law(exponent: f64) -> PressureLaw {
        PressureLaw::new(exponent).unwrap()
    }

    fn circle(radius: f64, exponent: f64) -> Contact {
        Contact::new(Shape::Circle { radius }, law(exponent)).unwrap()
    }

    fn about(centre: [f64; 2]) -> Motion {
        Motion { velocity: [centre[1], -centre[0]], turn: 1.0 }
    }

    /// Adaptive rule of Simpson, to an absolute error.
    fn simpson(f: &dyn Fn(f64) -> f64, from: f64, to: f64, error: f64) -> f64 {
        struct Piece(f64, f64, [f64; 3], f64);
        let rule = |a: f64, b: f64, [l, m, r]: [f64; 3]| (b - a) / 6.0 * (l + 4.0 * m + r);
        let ends = [f(from), f(0.5 * (from + to)), f(to)];
        let mut open = vec![Piece(from, to, ends, error)];
        let mut sum = 0.0;
        while let Some(Piece(a, b, [l, m, r], error)) = open.pop() {
            let middle = 0.5 * (a + b);
            let (left, right) = (f(0.5 * (a + middle)), f(0.5 * (middle + b)));
            let halves = rule(a, middle, [l, left, m]) + rule(middle, b, [m, right, r]);
            let change = halves - rule(a, b, [l, m, r]);
            if change.abs() <= 15.0 * error || b - a < 1e-13 {
                sum += halves + change / 15.0;
            } else {
                open.push(Piece(a, middle, [l, left, m], 0.5 * error));
                open.push(Piece(middle, b, [m, right, r], 0.5 * error));
            }
        }
        sum
    }

    /// Eqs 6.7 and 6.8 as they are written, about a centre of rotation, by nested adaptive quadrature.
    fn as_written(shape: Shape, law: PressureLaw, centre: [f64; 2]) -> Load {
        let part = |which: usize| {
            let at = |x: f64, y: f64| {
                let (dx, dy) = (x - centre[0], y - centre[1]);
                let distance = dx.hypot(dy).max(1e-300);
                [-dy / distance, dx / distance, (x * dx + y * dy) / distance][which]
            };
            // Depth u² from the edge takes the steep pressure there.
            let [a, b] = shape.sizes();
            match shape {
                Shape::Rectangle { .. } => {
                    let column = |x: f64| {
                        let piece =
                            |from: f64, to: f64| simpson(&|y| at(x, y), from, to, 2e-10 * b);
                        let middle = centre[1].clamp(-0.5 * b, 0.5 * b);
                        (piece(-0.5 * b, middle) + piece(middle, 0.5 * b)) / (a * b)
                    };
                    let from_edge = |x0: f64, x1: f64| {
                        let bent = |u: f64| {
                            let x = x0 + (x1 - x0) * (1.0 - (1.0 - u).powi(4));
                            let steep = 4.0 * (1.0 - u).powi(3) * (x1 - x0);
                            steep * law.strip((2.0 * x / a).abs()) * column(x)
                        };
                        simpson(&bent, 0.0, 1.0, 1e-9)
                    };
                    from_edge(0.0, 0.5 * a) - from_edge(0.0, -0.5 * a)
                }
                Shape::Circle { .. } | Shape::Ellipse { .. } => {
                    let ring = |rho: f64| {
                        let along = |t: f64| at(a * rho * t.cos(), b * rho * t.sin());
                        let begin = (centre[1] / b).atan2(centre[0] / a);
                        simpson(&along, begin, begin + 2.0 * PI, 1e-9) / PI
                    };
                    let bent = |u: f64| {
                        let rho = 1.0 - (1.0 - u).powi(4);
                        4.0 * (1.0 - u).powi(3) * rho * law.circular(rho) * ring(rho)
                    };
                    let split = (centre[0] / a).hypot(centre[1] / b).min(1.0);
                    let split = 1.0 - (1.0 - split).sqrt().sqrt();
                    simpson(&bent, 0.0, split, 1e-9) + simpson(&bent, split, 1.0, 1e-9)
                }
            }
        };
        Load { force: [part(0), part(1)], moment: part(2) }
    }

    #[test]
    fn a_uniform_round_contact_turns_under_two_thirds_of_the_friction_times_its_radius() {
        let contact = circle(7.0, f64::INFINITY);
        let turned = contact.slipping(&Motion { velocity: [0.0, 0.0], turn: -3.0 });
        assert!((turned.moment / (-2.0 / 3.0 * 7.0) - 1.0).abs() < 1e-9, "{turned:?}");
        assert!(turned.tangential() < 1e-12);
        let moved = contact.slipping(&Motion { velocity: [3.0, 4.0], turn: 0.0 });
        assert_eq!(moved, Load { force: [0.6, 0.8], moment: 0.0 });
    }

    #[test]
    fn hertz_turns_under_three_pi_sixteenths() {
        let arm = circle(2.0, 2.0).arm();
        assert!((arm / (3.0 * PI / 16.0 * 2.0) - 1.0).abs() < 1e-9, "{arm}");
    }

    #[test]
    fn a_uniform_square_turns_under_its_mean_distance() {
        // Mean distance of a square of side 1 from its middle.
        let mean = (2f64.sqrt() + 1f64.asinh()) / 6.0;
        let square = Shape::Rectangle { length: 3.0, width: 3.0 };
        let arm = Contact::new(square, PressureLaw::UNIFORM).unwrap().arm();
        assert!((arm / (3.0 * mean) - 1.0).abs() < 1e-10, "{arm}");
    }

    #[test]
    fn every_shape_agrees_with_adaptive_quadrature_about_any_centre() {
        let shapes = [
            Shape::Circle { radius: 1.0 },
            Shape::Ellipse { x: 2.0, y: 0.7 },
            Shape::Rectangle { length: 2.0, width: 1.3 },
        ];
        let centres = [[0.0, 0.0], [0.3, -0.4], [0.95, 0.2], [1.02, 0.0], [0.6, 0.9], [-9.0, 4.0]];
        for shape in shapes {
            for exponent in [1.0, 1.8, 2.0, 4.0, 7.3, 60.0, f64::INFINITY] {
                let contact = Contact::new(shape, law(exponent)).unwrap();
                for centre in centres {
                    let found = contact.slipping(&about(centre));
                    let written = as_written(shape, law(exponent), centre);
                    let arm = contact.arm();
                    let off = [
                        found.force[0] - written.force[0],
                        found.force[1] - written.force[1],
                        (found.moment - written.moment) / arm,
                    ];
                    let most = off.iter().fold(0.0, |most: f64, off| most.max(off.abs()));
                    assert!(most < 2e-8, "{shape:?}, k = {exponent}, {centre:?}: off by {most:e}");
                }
            }
        }
    }

    #[test]
    fn a_long_ellipse_and_a_long_strip_lose_no_accuracy() {
        for (shape, exact) in [
            // ∫ p |x| over an ellipse without width is the lever of the disc's projection.
            (Shape::Ellipse { x: 1.0, y: 1e-7 }, 4.0 / (3.0 * PI)),
            (Shape::Rectangle { length: 1e-7, width: 1.0 }, 0.25),
        ] {
            let arm = Contact::new(shape, PressureLaw::UNIFORM).unwrap().arm();
            assert!((arm / exact - 1.0).abs() < 1e-7, "{shape:?}: {arm}");
        }
    }

    #[test]
    fn a_shape_without_extent_is_refused() {
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Contact::new(Shape::Circle { radius }, PressureLaw::HERTZ).is_err());
        }
    }

    fn shapes() -> impl Strategy<Value = Shape> {
        (0u8..3, 0.2f64..5.0, 0.2f64..5.0).prop_map(|(kind, a, b)| match kind {
            0 => Shape::Rectangle { length: a, width: b },
            1 => Shape::Circle { radius: a },
            _ => Shape::Ellipse { x: a, y: b },
        })
    }

    fn motions() -> impl Strategy<Value = Motion> {
        (-1f64..1.0, -1f64..1.0, -3f64..3.0)
            .prop_map(|(x, y, turn)| Motion { velocity: [x, y], turn })
    }

    /// Work of a load per second.
    fn work(load: &Load, motion: &Motion) -> f64 {
        let [x, y] = motion.velocity;
        load.force[0] * x + load.force[1] * y + load.moment * motion.turn
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn no_load_on_the_surface_works_more_than_the_one_of_the_motion_itself(
            shape in shapes(), exponent in 1f64..20.0, one in motions(), other in motions(),
        ) {
            // That is convexity: the scan never leaves the body.
            let contact = Contact::new(shape, law(exponent)).unwrap();
            let own = work(&contact.slipping(&one), &one);
            prop_assert!(work(&contact.slipping(&other), &one) <= own * (1.0 + 1e-9) + 1e-9);
        }

        #[test]
        fn the_opposite_motion_meets_the_opposite_load(
            shape in shapes(), exponent in 1f64..20.0, motion in motions(),
        ) {
            let contact = Contact::new(shape, law(exponent)).unwrap();
            let back = Motion { velocity: motion.velocity.map(|v| -v), turn: -motion.turn };
            prop_assert_eq!(contact.slipping(&back), contact.slipping(&motion).times(-1.0));
        }

        #[test]
        fn a_larger_contact_turns_harder(
            shape in shapes(), exponent in 1f64..20.0, grown in 1f64..3.0,
        ) {
            let small = Contact::new(shape, law(exponent)).unwrap();
            let larger = match shape {
                Shape::Rectangle { length, width } => {
                    Shape::Rectangle { length, width: grown * width }
                }
                Shape::Circle { radius } => Shape::Circle { radius: grown * radius },
                Shape::Ellipse { x, y } => Shape::Ellipse { x: grown * x, y },
            };
            prop_assert!(small.reshaped(larger).unwrap().arm() >= small.arm() * (1.0 - 1e-10));
        }

        #[test]
        fn an_ellipse_with_equal_axes_is_a_circle(exponent in 1f64..50.0, motion in motions()) {
            let ellipse = Contact::new(Shape::Ellipse { x: 1.4, y: 1.4 }, law(exponent)).unwrap();
            prop_assert_eq!(ellipse.slipping(&motion), circle(1.4, exponent).slipping(&motion));
        }

        #[test]
        fn an_ellipse_turned_by_its_axes_carries_the_same(
            exponent in 1f64..50.0, motion in motions(),
        ) {
            let [x, y] = motion.velocity;
            let lying = Contact::new(Shape::Ellipse { x: 2.0, y: 0.5 }, law(exponent)).unwrap();
            let standing = lying.reshaped(Shape::Ellipse { x: 0.5, y: 2.0 }).unwrap();
            let turned = Motion { velocity: [-y, x], turn: motion.turn };
            let (a, b) = (lying.slipping(&motion), standing.slipping(&turned));
            prop_assert!((a.force[0] - b.force[1]).abs() < 1e-9);
            prop_assert!((a.force[1] + b.force[0]).abs() < 1e-9);
            prop_assert!((a.moment - b.moment).abs() < 1e-9);
        }

        #[test]
        fn a_uniform_square_is_the_same_after_a_quarter_turn(motion in motions()) {
            let square = Shape::Rectangle { length: 2.0, width: 2.0 };
            let contact = Contact::new(square, PressureLaw::UNIFORM).unwrap();
            let [x, y] = motion.velocity;
            let turned = Motion { velocity: [-y, x], turn: motion.turn };
            let (a, b) = (contact.slipping(&motion), contact.slipping(&turned));
            prop_assert!((a.force[0] - b.force[1]).abs() < 1e-9);
            prop_assert!((a.force[1] + b.force[0]).abs() < 1e-9);
            prop_assert!((a.moment - b.moment).abs() < 1e-9);
        }

        #[test]
        fn a_large_exponent_is_as_good_as_a_uniform_pressure(shape in shapes(), motion in motions()) {
            let soft = Contact::new(shape, law(1e7)).unwrap().slipping(&motion);
            let uniform = Contact::new(shape, PressureLaw::UNIFORM).unwrap().slipping(&motion);
            prop_assert!((soft.force[0] - uniform.force[0]).abs() < 1e-6);
            prop_assert!((soft.force[1] - uniform.force[1]).abs() < 1e-6);
            prop_assert!((soft.moment - uniform.moment).abs() < 1e-6);
        }

        #[test]
        fn the_load_is_steady_from_near_to_far_centres(
            shape in shapes(), exponent in 1f64..20.0, angle in 0f64..6.3,
        ) {
            // The rectangle changes its way of computing at some distance: it must not be seen.
            let contact = Contact::new(shape, law(exponent)).unwrap();
            let half = shape.sizes().map(|size| 0.5 * size);
            let seam = 4.0 * half[0].hypot(half[1]);
            let at = |distance: f64| {
                contact.slipping(&about([distance * angle.cos(), distance * angle.sin()]))
            };
            let (inside, outside) = (at(seam * (1.0 - 1e-9)), at(seam * (1.0 + 1e-9)));
            prop_assert!((inside.moment - outside.moment).abs() < 1e-8);
            prop_assert!((inside.force[0] - outside.force[0]).abs() < 1e-8);
        }
    }
}
