//! What was found: JSON, tables and figures.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use palpate::cli::ask::Answer as Found;
use palpate::files::plan::REPORT;
use palpate::files::write_whole;
use palpate::report::{
    Axis, Bars, Block, Callout, Colour, Dash, Figure, HeatMap, Origin, Page, Panels, Plot, Scale,
    Section, Series, Style, Table,
};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::data::{DataSet, allowed};
use crate::error::{broken, failed};
use crate::model::Model;

/// What a question found. It never changes.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct Answer {
    /// What was found.
    pub found: Arc<dyn Found>,
}

#[pymethods]
impl Answer {
    /// The JSON object of `--json`.
    fn json(&self, py: Python<'_>) -> String {
        py.detach(|| self.found.json().to_string())
    }

    /// What it is of.
    fn title(&self) -> &'static str {
        self.found.title()
    }

    /// What is to be said aside.
    fn remarks(&self) -> Vec<String> {
        self.found.remarks()
    }

    /// Why the work failed although there is something to show.
    fn failed(&self) -> Option<String> {
        self.found.failed()
    }

    /// The model that came of it.
    fn model(&self) -> PyResult<Option<Model>> {
        let model = self.found.model().map_err(|failure| failed(&failure))?;
        Ok(model.map(|inner| Model { inner }))
    }

    /// The traces that came of it.
    fn traces(&self, py: Python<'_>) -> DataSet {
        py.detach(|| self.found.traces()).into()
    }

    /// The sections of the report, or those of the terminal, as plain objects.
    fn sections<'py>(&self, py: Python<'py>, short: bool) -> PyResult<Bound<'py, PyList>> {
        let told = |found: &dyn Found| if short { found.in_short() } else { found.sections() };
        let sections = py.detach(|| told(&*self.found)).map_err(|failure| failed(&failure))?;
        list(py, &sections, section)
    }

    /// Writes the report that `--report` writes.
    fn report(&self, py: Python<'_>, path: PathBuf, force: bool) -> PyResult<()> {
        allowed(&path, &REPORT, force)?;
        py.detach(|| {
            let origin = Origin {
                program: concat!("palpate ", env!("CARGO_PKG_VERSION")).into(),
                command: String::new(),
                inputs: self.found.inputs(),
            };
            let mut page = Page::new(self.found.title(), self.found.subtitle(), origin);
            page.sections = self.found.sections().map_err(|failure| failed(&failure))?;
            write_whole(&path, |file| file.write_all(page.to_html().as_bytes())).map_err(broken)
        })
    }
}

/// A thing of the report as a plain object.
type Object<'py> = PyResult<Bound<'py, PyDict>>;

fn list<'py, T>(
    py: Python<'py>,
    things: &[T],
    object: impl Fn(Python<'py>, &T) -> Object<'py>,
) -> PyResult<Bound<'py, PyList>> {
    let objects = things.iter().map(|thing| object(py, thing)).collect::<PyResult<Vec<_>>>()?;
    PyList::new(py, objects)
}

/// An object of a kind.
fn object<'py>(py: Python<'py>, kind: &str) -> Object<'py> {
    let object = PyDict::new(py);
    object.set_item("kind", kind)?;
    Ok(object)
}

fn section<'py>(py: Python<'py>, section: &Section) -> Object<'py> {
    let it = object(py, "section")?;
    it.set_item("title", &section.title)?;
    it.set_item("blocks", list(py, &section.blocks, block)?)?;
    Ok(it)
}

fn block<'py>(py: Python<'py>, block: &Block) -> Object<'py> {
    let text = |kind: &str, text: &str| {
        let it = object(py, kind)?;
        it.set_item("text", text)?;
        Ok(it)
    };
    match block {
        Block::Heading(words) => text("heading", words),
        Block::Paragraph(words) => text("paragraph", words),
        Block::Code(words) => text("code", words),
        Block::List(points) => {
            let it = object(py, "list")?;
            it.set_item("points", points)?;
            Ok(it)
        }
        Block::Figure { figure: drawn, caption } => {
            let it = figure(py, drawn)?;
            it.set_item("caption", caption)?;
            it.set_item("svg", drawn.to_svg())?;
            Ok(it)
        }
        Block::Table(rows) => table(py, rows),
        Block::Callout { kind, title, text } => {
            let it = object(py, "callout")?;
            it.set_item("warning", *kind == Callout::Warning)?;
            it.set_item("title", title)?;
            it.set_item("text", text)?;
            Ok(it)
        }
        Block::Definitions(terms) => {
            let it = object(py, "definitions")?;
            it.set_item("terms", terms)?;
            Ok(it)
        }
        Block::Details { summary, blocks } => {
            let it = object(py, "details")?;
            it.set_item("summary", summary)?;
            it.set_item("blocks", list(py, blocks, self::block)?)?;
            Ok(it)
        }
    }
}

fn table<'py>(py: Python<'py>, table: &Table) -> Object<'py> {
    let it = object(py, "table")?;
    let columns: Vec<(&str, &str)> =
        table.columns.iter().map(|column| (&*column.name, &*column.unit)).collect();
    it.set_item("caption", &table.caption)?;
    it.set_item("columns", columns)?;
    it.set_item("rows", &table.rows)?;
    it.set_item("notes", &table.notes)?;
    Ok(it)
}

fn figure<'py>(py: Python<'py>, figure: &Figure) -> Object<'py> {
    match figure {
        Figure::Plot(plot) => panels(py, &plot.title, &plot.summary, std::slice::from_ref(plot)),
        Figure::Panels(Panels { title, summary, plots }) => panels(py, title, summary, plots),
        Figure::HeatMap(map) => heat_map(py, map),
        Figure::Bars(drawn) => bars(py, drawn),
    }
}

fn panels<'py>(py: Python<'py>, title: &str, summary: &str, plots: &[Plot]) -> Object<'py> {
    let it = object(py, "panels")?;
    it.set_item("title", title)?;
    it.set_item("summary", summary)?;
    it.set_item("plots", list(py, plots, plot)?)?;
    Ok(it)
}

fn plot<'py>(py: Python<'py>, plot: &Plot) -> Object<'py> {
    let it = object(py, "plot")?;
    it.set_item("title", &plot.title)?;
    it.set_item("x", axis(py, &plot.x)?)?;
    it.set_item("y", axis(py, &plot.y)?)?;
    it.set_item("series", list(py, &plot.series, series)?)?;
    let spans = plot.spans.iter().map(|span| (span.from, span.to, &*span.label));
    it.set_item("spans", spans.collect::<Vec<_>>())?;
    let marks = plot.marks.iter().map(|mark| (mark.x, &*mark.label));
    it.set_item("marks", marks.collect::<Vec<_>>())?;
    let levels = plot.levels.iter().map(|level| (level.y, &*level.label));
    it.set_item("levels", levels.collect::<Vec<_>>())?;
    let texts = plot.annotations.iter().map(|note| (note.x, note.y, &*note.text));
    it.set_item("annotations", texts.collect::<Vec<_>>())?;
    Ok(it)
}

fn axis<'py>(py: Python<'py>, axis: &Axis) -> Object<'py> {
    let it = object(py, "axis")?;
    it.set_item("label", &axis.label)?;
    it.set_item("unit", &axis.unit)?;
    it.set_item("log", axis.scale == Scale::Log)?;
    it.set_item("range", axis.range)?;
    Ok(it)
}

fn series<'py>(py: Python<'py>, series: &Series) -> Object<'py> {
    let kind = match &series.style {
        Style::Line => "line",
        Style::Step => "step",
        Style::Points => "points",
        Style::Band { .. } => "band",
        Style::ErrorBars { .. } => "error bars",
    };
    let it = object(py, kind)?;
    it.set_item("name", &series.name)?;
    it.set_item("x", PyArray1::from_slice(py, &series.x))?;
    it.set_item("y", PyArray1::from_slice(py, &series.y))?;
    match &series.style {
        Style::Band { upper } => it.set_item("upper", PyArray1::from_slice(py, upper))?,
        Style::ErrorBars { error } => it.set_item("error", PyArray1::from_slice(py, error))?,
        _ => {}
    }
    it.set_item("colour", colour(series.colour))?;
    it.set_item("dashed", series.dash == Dash::Dashed)?;
    it.set_item("width", series.width)?;
    Ok(it)
}

/// The number of a hue, −1 for ink and −2 for grey.
fn colour(colour: Colour) -> i64 {
    match colour {
        Colour::Ink => -1,
        Colour::Muted => -2,
        Colour::Hue(hue) => hue as i64,
    }
}

fn heat_map<'py>(py: Python<'py>, map: &HeatMap) -> Object<'py> {
    let it = object(py, "heat map")?;
    it.set_item("title", &map.title)?;
    it.set_item("summary", &map.summary)?;
    it.set_item("rows", &map.rows)?;
    it.set_item("columns", &map.columns)?;
    it.set_item("values", PyArray2::from_vec2(py, &map.values).map_err(broken)?)?;
    Ok(it)
}

fn bars<'py>(py: Python<'py>, bars: &Bars) -> Object<'py> {
    let it = object(py, "bars")?;
    it.set_item("title", &bars.title)?;
    it.set_item("summary", &bars.summary)?;
    it.set_item("axis", axis(py, &bars.axis)?)?;
    it.set_item("groups", &bars.groups)?;
    let levels = bars.levels.iter().map(|level| (level.y, &*level.label));
    it.set_item("levels", levels.collect::<Vec<_>>())?;
    let one = |py: Python<'py>, series: &palpate::report::BarSeries| {
        let it = object(py, "bar series")?;
        it.set_item("name", &series.name)?;
        it.set_item("values", PyArray1::from_slice(py, &series.values))?;
        it.set_item("errors", PyArray1::from_slice(py, &series.errors))?;
        it.set_item("colour", colour(series.colour))?;
        Ok(it)
    };
    it.set_item("series", list(py, &bars.series, one)?)?;
    Ok(it)
}
