//! What is pressed, and how its contact grows with the compression.

use std::str::FromStr;

use super::contact::Shape;
use palpate_model::widened;
use palpate_trace as trace;

/// What is pressed by a flat surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Body {
    /// A contact whose size is known and stays.
    Fixed(Shape),
    /// A ball: a² = r² − (r − d)² (eq. 7.7), with the compression d from this side alone; a ball between two
    /// plates that moves in on both has half the displacement on each.
    Sphere {
        /// Radius r, mm.
        radius: f64,
    },
    /// Pressed along its axis; the Poisson effect widens it (eq. 5.5).
    Cylinder {
        /// Radius without load, mm.
        radius: f64,
        /// Height without load, mm.
        height: f64,
        /// Poisson's ratio.
        poisson: f64,
    },
    /// Pressed along its height; the Poisson effect widens it as a cylinder (eq. 5.5).
    Block {
        /// Length without load, mm.
        length: f64,
        /// Width without load, mm.
        width: f64,
        /// Height without load, mm.
        height: f64,
        /// Poisson's ratio.
        poisson: f64,
    },
}

/// Why it is not known what is pressed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum BodyError {
    #[error(
        "`{0}` is no contact; give sizes in mm: circle:R, ellipse:XxY, rectangle:LxW, sphere:R, cylinder:RxH:POISSON or \
         block:LxWxH:POISSON"
    )]
    Text(String),
    #[error("this contact grows as it is pressed: give --compression MM")]
    Compression,
    #[error("a ball touches from a compression above 0 on")]
    Apart,
    #[error("the head of the trace lacks {0} in its [specimen]; write it there, or give --contact")]
    Head(&'static str),
}

impl Body {
    /// From the head of a trace. A cylinder or block without height or Poisson's ratio keeps its size.
    ///
    /// # Errors
    /// [`BodyError::Head`] names the key that is missing.
    pub fn of(specimen: &trace::Specimen) -> Result<Self, BodyError> {
        let size = |value: Option<f64>, key| value.ok_or(BodyError::Head(key));
        let growth = specimen.height_mm.zip(specimen.poisson_ratio);
        match specimen.shape.ok_or(BodyError::Head("shape"))? {
            trace::Shape::Sphere => {
                Ok(Self::Sphere { radius: size(specimen.radius_mm, "radius_mm")? })
            }
            trace::Shape::Cylinder => {
                let radius = size(specimen.radius_mm, "radius_mm")?;
                Ok(match growth {
                    Some((height, poisson)) => Self::Cylinder { radius, height, poisson },
                    None => Self::Fixed(Shape::Circle { radius }),
                })
            }
            trace::Shape::Block => {
                let length = size(specimen.length_mm, "length_mm")?;
                let width = size(specimen.width_mm, "width_mm")?;
                Ok(match growth {
                    Some((height, poisson)) => Self::Block { length, width, height, poisson },
                    None => Self::Fixed(Shape::Rectangle { length, width }),
                })
            }
        }
    }

    /// The contact at a compression, mm. A ball that is not compressed does not touch.
    #[must_use]
    pub fn contact(&self, compression: f64) -> Option<Shape> {
        match *self {
            Self::Fixed(shape) => Some(shape),
            Self::Sphere { radius } => {
                let depth = compression.clamp(0.0, radius);
                let radius = (depth * (2.0 * radius - depth)).sqrt();
                (radius > 0.0).then_some(Shape::Circle { radius })
            }
            Self::Cylinder { radius, height, poisson } => Some(Shape::Circle {
                radius: radius * widened(compression.max(0.0), height, poisson),
            }),
            Self::Block { length, width, height, poisson } => {
                let factor = widened(compression.max(0.0), height, poisson);
                Some(Shape::Rectangle { length: length * factor, width: width * factor })
            }
        }
    }

    /// The contact at a compression, mm, which must be known if the contact depends on it.
    ///
    /// # Errors
    /// [`BodyError::Compression`], [`BodyError::Apart`].
    pub fn pressed(&self, compression: Option<f64>) -> Result<Shape, BodyError> {
        if self.grows() && compression.is_none() {
            return Err(BodyError::Compression);
        }
        self.contact(compression.unwrap_or_default()).ok_or(BodyError::Apart)
    }

    /// Whether the contact depends on the compression.
    #[must_use]
    pub const fn grows(&self) -> bool {
        !matches!(self, Self::Fixed(_))
    }
}

impl FromStr for Body {
    type Err = BodyError;

    /// `circle:R`, `ellipse:XxY`, `rectangle:LxW`, `sphere:R`, `cylinder:RxH:POISSON`,
    /// `block:LxWxH:POISSON`.
    fn from_str(text: &str) -> Result<Self, BodyError> {
        let wrong = || BodyError::Text(text.into());
        let mut parts = text.split(':');
        let kind = parts.next().unwrap_or_default();
        let size = |size: &str| size.parse().ok().filter(|&mm: &f64| mm > 0.0 && mm < 1e9);
        let sizes: Option<Vec<f64>> =
            parts.next().and_then(|all| all.split('x').map(size).collect());
        let sizes = sizes.ok_or_else(wrong)?;
        let poisson = parts.next().map(|ratio| {
            ratio
                .parse()
                .ok()
                .filter(|ratio: &f64| *ratio > -1.0 && *ratio <= 0.5)
                .ok_or_else(wrong)
        });
        let poisson = poisson.transpose()?;
        match (kind, &sizes[..], poisson, parts.next()) {
            ("circle", &[radius], None, None) => Ok(Self::Fixed(Shape::Circle { radius })),
            ("ellipse", &[x, y], None, None) => Ok(Self::Fixed(Shape::Ellipse { x, y })),
            ("rectangle", &[length, width], None, None) => {
                Ok(Self::Fixed(Shape::Rectangle { length, width }))
            }
            ("sphere", &[radius], None, None) => Ok(Self::Sphere { radius }),
            ("cylinder", &[radius, height], Some(poisson), None) => {
                Ok(Self::Cylinder { radius, height, poisson })
            }
            ("block", &[length, width, height], Some(poisson), None) => {
                Ok(Self::Block { length, width, height, poisson })
            }
            _ => Err(wrong()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_are_read_from_text() {
        let parsed = |text: &str| text.parse::<Body>();
        assert_eq!(parsed("circle:5"), Ok(Body::Fixed(Shape::Circle { radius: 5.0 })));
        assert_eq!(
            parsed("rectangle:42.22x26.38"),
            Ok(Body::Fixed(Shape::Rectangle { length: 42.22, width: 26.38 }))
        );
        let block = Body::Block { length: 40.0, width: 25.0, height: 50.0, poisson: 0.48 };
        assert_eq!(parsed("block:40x25x50:0.48"), Ok(block));
        for wrong in [
            "",
            "circle",
            "circle:",
            "circle:0",
            "circle:-1",
            "circle:5x",
            "circle:5:0.4",
            "ellipse:3",
            "block:40x25x50",
            "block:40x25x50:0.7",
            "cone:3",
            "rectangle:4xx3",
            "sphere:inf",
            "cylinder:3x4:0.4:1",
        ] {
            assert!(parsed(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_ball_touches_over_a_circle_that_ends_at_its_equator() {
        let ball = Body::Sphere { radius: 35.0 };
        assert_eq!(ball.contact(-1.0), None);
        assert_eq!(ball.pressed(None), Err(BodyError::Compression));
        assert_eq!(ball.pressed(Some(0.0)), Err(BodyError::Apart));
        let radius = |compression| match ball.contact(compression) {
            Some(Shape::Circle { radius }) => radius,
            other => panic!("{other:?}"),
        };
        assert!((radius(5.0) - (35f64.powi(2) - 30f64.powi(2)).sqrt()).abs() < 1e-12);
        assert_eq!(radius(40.0), 35.0);
    }

    #[test]
    fn a_head_without_what_is_needed_is_told_what_is_missing() {
        let mut specimen = trace::Specimen::default();
        assert_eq!(Body::of(&specimen), Err(BodyError::Head("shape")));
        specimen.shape = Some(trace::Shape::Block);
        assert_eq!(Body::of(&specimen), Err(BodyError::Head("length_mm")));
        (specimen.length_mm, specimen.width_mm) = (Some(4.0), Some(3.0));
        assert!(!Body::of(&specimen).unwrap().grows());
        (specimen.height_mm, specimen.poisson_ratio) = (Some(5.0), Some(0.48));
        assert!(Body::of(&specimen).unwrap().grows());
    }
}
