//! A limit surface.

use std::f64::consts::FRAC_PI_2;

use super::{exponent_words, margin_words, shape_words};
use palpate_contact::grasp::{Contact, Load, Margin, Shape, SurfacePoint, limit_curve};
use palpate_report::number::significant;
use palpate_report::{Axis, Callout, Colour, Column, Plot, Section, Series, Table};

/// Points of a drawn curve.
const CURVE_POINTS: usize = 81;

/// A limit surface and, if there is one, a load with its margin.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceSummary<'a> {
    /// The contact.
    pub contact: &'a Contact,
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Normal force N, N.
    pub normal: f64,
    /// The surface.
    pub surface: &'a [SurfacePoint],
    /// A load and how far it is from slip.
    pub load: Option<(Load, Margin)>,
}

impl SurfaceSummary<'_> {
    /// Largest loads, margin, curves and pressure.
    #[must_use]
    pub fn sections(&self) -> Vec<Section> {
        let mut section = Section::new("Limit surface").table(self.table());
        if let Some((load, margin)) = &self.load {
            let kind = if margin.factor > 1.0 { Callout::Finding } else { Callout::Warning };
            section = section.callout(kind, "Margin", margin_sentence(load, margin));
        }
        let section = section
            .figure(
                self.plot(),
                "Loads below the curve hold; on it the contact slips. Mirrored at both axes.",
            )
            .figure(pressure_plot(self.contact, self.normal), "");
        vec![section]
    }

    /// Largest tangential force, in every direction, N.
    #[must_use]
    pub fn largest_force(&self) -> f64 {
        self.friction * self.normal
    }

    /// Largest moment about the normal, N mm.
    #[must_use]
    pub fn largest_moment(&self) -> f64 {
        self.largest_force() * self.contact.arm()
    }

    fn table(&self) -> Table {
        let shape = self.contact.shape();
        let middle = self.contact.middle_over_mean_pressure();
        let mean = self.normal / shape.area();
        let columns = vec![Column::text(""), Column::number("value", ""), Column::text("unit")];
        let row = |name: &str, value: f64, unit: &str| {
            [name.to_owned(), significant(value, 5), unit.to_owned()]
        };
        let caption = format!(
            "{}, {}, μ = {}, N = {} N",
            shape_words(&shape),
            exponent_words(self.contact.law().exponent()),
            self.friction,
            self.normal,
        );
        Table::new(caption, columns)
            .row(row("largest tangential force, in every direction", self.largest_force(), "N"))
            .row(row("largest moment about the normal", self.largest_moment(), "N mm"))
            .row(row("its arm", self.contact.arm(), "mm"))
            .row(row("contact area", shape.area(), "mm²"))
            .row(row("pressure in the middle", 1e3 * mean * middle, "kPa"))
            .row(row("pressure in the middle over mean pressure, C_k", middle, ""))
    }

    fn plot(&self) -> Plot {
        let limit = self.largest_force();
        let axes = Plot::new(
            "Limit surface",
            Axis::new("tangential force", "N"),
            Axis::new("moment about the normal", "N mm"),
        );
        let curve = |name: &str, angle: f64, hue: usize| {
            let points = limit_curve(self.contact, limit, angle, CURVE_POINTS);
            let force: Vec<f64> = points.iter().map(|point| point.load.tangential()).collect();
            let moment: Vec<f64> = points.iter().map(|point| point.load.moment).collect();
            Series::line(name, force, moment).colour(Colour::Hue(hue))
        };
        let mut plot = match self.contact.shape() {
            Shape::Circle { .. } => axes.series(curve("slip", 0.0, 0)),
            _ => axes.series(curve("force along x", 0.0, 0)).series(curve(
                "force along y",
                FRAC_PI_2,
                1,
            )),
        };
        if let Some((load, margin)) = &self.load {
            let mark = |load: &Load| (vec![load.tangential()], vec![load.moment.abs()]);
            let (force, moment) = mark(load);
            plot = plot.series(Series::points("load", force, moment).colour(Colour::MEASURED));
            if margin.factor.is_finite() {
                let (force, moment) = mark(&load.times(margin.factor));
                plot = plot
                    .series(Series::points("load at slip", force, moment).colour(Colour::Hue(3)));
            }
        }
        plot.summary(format!(
            "Largest moment {} N mm without force, falling to none at {} N",
            significant(self.largest_moment(), 4),
            significant(limit, 4)
        ))
    }
}

fn margin_sentence(load: &Load, margin: &Margin) -> String {
    let load = format!(
        "The load of {} N and {} N mm",
        significant(load.tangential(), 4),
        significant(load.moment, 4)
    );
    let factor = margin_words(margin.factor);
    let how = match margin.motion.map(|motion| motion.centre()) {
        Some(Some([x, y])) if x.hypot(y) < 1e6 => {
            // What is next to nothing beside the other comes from rounding.
            let place = |value: f64| {
                let nothing = value.abs() < 1e-9 * x.hypot(y);
                significant(if nothing { 0.0 } else { value }, 3)
            };
            format!(", turning about ({}, {}) mm", place(x), place(y))
        }
        Some(_) => ", without a turn".into(),
        None => String::new(),
    };
    if margin.factor > 1.0 {
        format!("{load} holds: it could be {factor} times as large; then the contact slips{how}.")
    } else {
        format!("{load} slips: the contact carries {factor} of it{how}.")
    }
}

/// Pressure across the middle of a contact, along x.
#[must_use]
pub fn pressure_plot(contact: &Contact, normal: f64) -> Plot {
    let half = match contact.shape() {
        Shape::Rectangle { length, .. } => 0.5 * length,
        Shape::Circle { radius } => radius,
        Shape::Ellipse { x, .. } => x,
    };
    let mean = normal / contact.shape().area();
    // Densely where it is steep.
    let place = |k: usize| (FRAC_PI_2 * (k as f64 / 100.0 - 1.0)).sin() * half;
    let x: Vec<f64> = (0..=200).map(place).collect();
    let pressure: Vec<f64> = x
        .iter()
        .map(|x| {
            let rho = (x / half).abs();
            1e3 * mean * contact.middle_over_mean_pressure() * contact.law().shape(rho)
        })
        .collect();
    Plot::new("Pressure", Axis::new("x", "mm"), Axis::new("pressure", "kPa"))
        .series(Series::line(exponent_words(contact.law().exponent()), x, pressure))
        .height(160.0)
        .summary(format!("Pressure along x, mean {} kPa", significant(1e3 * mean, 3)))
}

/// Header row of [`surface_csv`].
pub const SURFACE_HEADER: &str = "velocity_x_mm_per_s,velocity_y_mm_per_s,turn_rad_per_s,centre_x_mm,centre_y_mm,force_x_N,force_y_N,moment_Nmm";

/// The surface as CSV; the centre of a pure translation is left empty.
#[must_use]
pub fn surface_csv(surface: &[SurfacePoint]) -> String {
    let mut text = format!("{SURFACE_HEADER}\n");
    for SurfacePoint { motion, load } in surface {
        let [x, y] = motion.velocity;
        let centre = motion.centre().map_or(",".into(), |[x, y]| format!("{x},{y}"));
        let [fx, fy] = load.force;
        text += &format!("{x},{y},{},{centre},{fx},{fy},{}\n", motion.turn, load.moment);
    }
    text
}
