//! Stress in a half space below a Hertzian contact.

use std::f64::consts::PI;

/// Normal stresses at a point, in polar coordinates about the axis of the contact, tension positive, Pa. The shear in the
/// plane of radius and axis is left out: it strains no gauge that lies flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stress {
    /// Along the radius.
    pub radial: f64,
    /// Around the axis.
    pub hoop: f64,
    /// Along the axis.
    pub axial: f64,
}

/// The contact of a paraboloid: p(r) = 3/2 p_m √(1 − r²/a²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzField {
    /// Mean pressure p_m, Pa.
    pub mean_pressure: f64,
    /// Radius of the contact a, m; above 0.
    pub contact_radius: f64,
}

impl HertzField {
    /// The field of a force, N, on a contact of a radius, m.
    #[must_use]
    pub fn of_force(force: f64, contact_radius: f64) -> Self {
        Self { mean_pressure: force / (PI * contact_radius * contact_radius), contact_radius }
    }

    /// Stress at a distance r from the axis and a depth z > 0, m, in a body of a Poisson's ratio: Huber's closed form
    /// (1904), which is the Boussinesq kernel integrated over the pressure.
    #[must_use]
    pub fn stress(&self, r: f64, z: f64, poisson_ratio: f64) -> Stress {
        let (p, a, v) = (1.5 * self.mean_pressure, self.contact_radius, poisson_ratio);
        let (a2, z2) = (a * a, z * z);
        let b = r * r + z2 - a2;
        let u = 0.5 * (b + (b * b + 4.0 * a2 * z2).sqrt());
        let root = u.sqrt();
        let q = z / root;
        // a²/r² (1 − q³), whose limit on the axis is 3/2 a²/(a² + z²).
        let ring = if r > 1e-4 * (a + z) {
            a2 / (r * r) * (1.0 - q.powi(3))
        } else {
            1.5 * a2 / (a2 + z2)
        };
        let ring = (1.0 - 2.0 * v) / 3.0 * ring;
        let down = q.powi(3) * a2 * u / (u * u + a2 * z2);
        let bent = u * (1.0 - v) / (a2 + u);
        let spread = (1.0 + v) * root / a * (a / root).atan();
        Stress {
            radial: p * (ring + down + q * (bent + spread - 2.0)),
            hoop: -p * (ring + q * (2.0 * v + bent - spread)),
            axial: -p * down,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boussinesq's point force (Johnson 1985, eqs 3.19) integrated over the pressure with the midpoint rule.
    fn integrated(field: &HertzField, r: f64, z: f64, v: f64) -> Stress {
        let (rings, spokes) = (400, 400);
        let a = field.contact_radius;
        let mut sum = Stress { radial: 0.0, hoop: 0.0, axial: 0.0 };
        for i in 0..rings {
            // s² even in steps makes rings of equal area; the pressure is √ of what is left.
            let s2 = (f64::from(i) + 0.5) / f64::from(rings);
            let force = 1.5 * field.mean_pressure * (1.0 - s2).sqrt() * PI * a * a
                / f64::from(rings * spokes);
            for k in 0..spokes {
                let angle = (f64::from(k) + 0.5) * 2.0 * PI / f64::from(spokes);
                let (x, y) = (r - a * s2.sqrt() * angle.cos(), -a * s2.sqrt() * angle.sin());
                let flat2 = x * x + y * y;
                let rho = (flat2 + z * z).sqrt();
                let ring = (1.0 - 2.0 * v) / flat2 * (1.0 - z / rho);
                let own = force / (2.0 * PI) * (ring - 3.0 * z * flat2 / rho.powi(5));
                let around = -force / (2.0 * PI)
                    * (1.0 - 2.0 * v)
                    * (1.0 / flat2 - z / rho.powi(3) - z / (flat2 * rho));
                let (c2, s2) = (x * x / flat2, y * y / flat2);
                sum.radial += own * c2 + around * s2;
                sum.hoop += own * s2 + around * c2;
                sum.axial -= force * 3.0 * z.powi(3) / (2.0 * PI * rho.powi(5));
            }
        }
        sum
    }

    #[test]
    fn the_closed_form_is_the_boussinesq_kernel_integrated_over_the_pressure() {
        let field = HertzField { mean_pressure: 2.0, contact_radius: 1.5 };
        for (r, z) in [(1e-3, 2.0), (0.7, 1.0), (2.5, 0.8), (4.0, 3.0)] {
            for v in [0.3, 0.48, 0.5] {
                let (closed, sum) = (field.stress(r, z, v), integrated(&field, r, z, v));
                for (a, b) in [
                    (closed.radial, sum.radial),
                    (closed.hoop, sum.hoop),
                    (closed.axial, sum.axial),
                ] {
                    assert!((a - b).abs() < 2e-4, "r {r}, z {z}, v {v}: {closed:?} {sum:?}");
                }
            }
        }
    }

    #[test]
    fn on_the_axis_radius_and_hoop_are_one() {
        let field = HertzField { mean_pressure: 1.0, contact_radius: 1.0 };
        let on_axis = field.stress(0.0, 0.7, 0.4);
        assert!((on_axis.radial - on_axis.hoop).abs() < 1e-12);
        assert!((on_axis.axial + 1.5 / (1.0 + 0.49)).abs() < 1e-12);
    }
}
