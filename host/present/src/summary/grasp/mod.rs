//! What a contact carries before it slips, in words, tables and plots.

mod friction;
mod growth;
mod history;
mod live;
mod plan;
mod surface;

pub use friction::friction_sections;
pub use growth::growth_sections;
pub use history::{HISTORY_HEADER, history_csv, history_sections};
pub use live::reading_line;
pub use plan::{Forecast, HandPlan, plan_sections};
pub use surface::{SURFACE_HEADER, SurfaceSummary, pressure_plot, surface_csv};

use palpate_contact::grasp::Shape;
use palpate_report::number::significant;

/// A shape in words.
fn shape_words(shape: &Shape) -> String {
    match *shape {
        Shape::Rectangle { length, width } => {
            format!("rectangle {} × {} mm", significant(length, 5), significant(width, 5))
        }
        Shape::Circle { radius } => format!("circle of radius {} mm", significant(radius, 5)),
        Shape::Ellipse { x, y } => {
            format!("ellipse of semi-axes {} and {} mm", significant(x, 5), significant(y, 5))
        }
    }
}

/// An exponent k in words.
fn exponent_words(exponent: f64) -> String {
    match exponent {
        2.0 => "k = 2 (Hertz)".into(),
        _ if exponent.is_infinite() => "k = ∞ (uniform)".into(),
        _ => format!("k = {exponent}"),
    }
}

/// A margin in words; without a load there is none.
fn margin_words(margin: f64) -> String {
    if margin.is_infinite() { "∞".into() } else { significant(margin, 4) }
}
