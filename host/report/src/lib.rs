//! Vector plots, self-contained HTML, tables for the terminal: data in, text out. Nothing here prints or
//! reads files, and the same data give the same bytes.
//!
//! - [`Plot`], [`Panels`], [`HeatMap`], [`Bars`]: figures as plain data; each has `to_svg()`.
//! - [`Page`]: sections of text, figures and [`Table`]s as one HTML file.
//! - [`markdown()`]: sections for a document.
//! - [`Terminal`]: tables and small line plots for the terminal.
//! - [`number`]: numbers as text, with standard errors.
//!
//! ```
//! use palpate_report::{Axis, Plot, Series};
//!
//! let time: Vec<f64> = (0..100).map(|k| 0.01 * f64::from(k)).collect();
//! let force: Vec<f64> = time.iter().map(|t| (-3.0 * t).exp()).collect();
//! let plot = Plot::new("A hold", Axis::new("time", "s"), Axis::new("force", "N"));
//! assert!(plot.series(Series::line("measured", time, force)).to_svg().starts_with("<svg"));
//! ```
#![forbid(unsafe_code)]

mod axis;
mod bars;
pub mod colour;
mod curve;
mod decimate;
mod draw;
mod embed;
mod figure;
mod heatmap;
mod layout;
mod markdown;
pub mod number;
mod page;
mod pdf;
mod plot;
mod stack;
mod svg;
mod symbol;
mod table;
mod terminal;

pub use axis::{Axis, Scale};
pub use bars::{BarSeries, Bars};
pub use colour::Colour;
pub use figure::Figure;
pub use heatmap::{CellFormat, HeatMap};
pub use markdown::markdown;
pub use page::{Block, Callout, Origin, Page, Section};
pub use pdf::{PdfError, pdf};
pub use plot::{Annotation, Dash, Legend, Level, Mark, Panels, Plot, Series, Span, Style};
pub use stack::{Sheet, stacked};
pub use table::{Align, Column, Table};
pub use terminal::Terminal;
