//! A report as one HTML file: no network, works without scripts, reads well on paper.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::colour::{FIGURE_CSS, standalone_css, variables};
use super::draw::Place;
use super::figure::Figure;
use super::number::typographic;
use super::symbol;
use super::table::{Align, Column, Table, split_decimal};

const CSS: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Nothing may be fetched, framed or sent; style and script are those in the file.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
                      img-src data: blob:; base-uri 'none'; form-action 'none'";

/// A report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// Title of the report.
    pub title: String,
    /// One line below the title; empty for none.
    pub subtitle: String,
    /// Sections, each with an entry in the table of contents.
    pub sections: Vec<Section>,
    /// Where the report comes from, shown at its end.
    pub origin: Origin,
}

/// Where a report comes from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// Program with its version: `palpate 0.1.0`.
    pub program: String,
    /// The command that makes the report again; empty for none.
    pub command: String,
    /// Files it was made from.
    pub inputs: Vec<String>,
}

/// One section of a report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// Heading.
    pub title: String,
    /// Contents from top to bottom.
    pub blocks: Vec<Block>,
}

/// One part of a section. In all texts here, what stands between backticks is set as code.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// A heading within a section.
    Heading(String),
    /// Running text.
    Paragraph(String),
    /// A list of points.
    List(Vec<String>),
    /// A figure with a caption, which may be empty.
    Figure {
        /// What to draw.
        figure: Box<Figure>,
        /// Text below it.
        caption: String,
    },
    /// A table.
    Table(Table),
    /// A remark that must not be missed.
    Callout {
        /// How serious it is.
        kind: Callout,
        /// The remark in a few words.
        title: String,
        /// The rest.
        text: String,
    },
    /// Terms, each with its meaning.
    Definitions(Vec<(String, String)>),
    /// Commands or other text to copy, as it is.
    Code(String),
    /// Blocks that are folded away until asked for; on paper too, unless they were opened before.
    Details {
        /// What is folded away.
        summary: String,
        /// The blocks.
        blocks: Vec<Block>,
    },
}

/// How serious a remark is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Callout {
    /// A result.
    Finding,
    /// Something to beware of.
    Warning,
}

impl Page {
    /// A report without sections.
    #[must_use]
    pub fn new(title: impl Into<String>, subtitle: impl Into<String>, origin: Origin) -> Self {
        Self { title: title.into(), subtitle: subtitle.into(), sections: Vec::new(), origin }
    }

    /// The same report with one more section.
    #[must_use]
    pub fn section(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// The report as an HTML file.
    #[must_use]
    pub fn to_html(&self) -> String {
        let mut writer = Writer::default();
        let sections: Vec<Markup> =
            self.sections.iter().enumerate().map(|(i, s)| writer.section(i, s)).collect();
        let markup = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    meta name="generator" content=(self.origin.program);
                    title { (self.title) }
                    style { (PreEscaped(style_sheet())) }
                }
                body {
                    header {
                        h1 { (self.title) }
                        @if !self.subtitle.is_empty() { p.subtitle { (inline(&self.subtitle)) } }
                    }
                    @if self.sections.len() > 1 { (self.contents()) }
                    main { @for section in &sections { (section) } }
                    (self.footer())
                    @if writer.figures > 0 {
                        script type="application/json" id="figure-style" {
                            (PreEscaped(serde_json::Value::String(standalone_css()).to_string()))
                        }
                    }
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        };
        markup.into_string()
    }

    fn contents(&self) -> Markup {
        html! {
            nav aria-label="Contents" {
                ol {
                    @for (index, section) in self.sections.iter().enumerate() {
                        li { a href=(format!("#section-{}", index + 1)) { (section.title) } }
                    }
                }
            }
        }
    }

    fn footer(&self) -> Markup {
        html! {
            footer {
                @if !self.origin.program.is_empty() { p { "Made by " (self.origin.program) "." } }
                @if !self.origin.inputs.is_empty() {
                    p { "From:" }
                    ul { @for input in &self.origin.inputs { li { (input) } } }
                }
                @if !self.origin.command.is_empty() {
                    p { "Again with:" }
                    pre { code { (self.origin.command) } }
                }
            }
        }
    }
}

impl Section {
    /// A section without contents.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), blocks: Vec::new() }
    }

    /// The same section with one more block.
    #[must_use]
    pub fn block(mut self, block: Block) -> Self {
        self.blocks.push(block);
        self
    }

    /// The same section with one more paragraph.
    #[must_use]
    pub fn paragraph(self, text: impl Into<String>) -> Self {
        self.block(Block::Paragraph(text.into()))
    }

    /// The same section with one more figure.
    #[must_use]
    pub fn figure(self, figure: impl Into<Figure>, caption: impl Into<String>) -> Self {
        self.block(Block::Figure { figure: Box::new(figure.into()), caption: caption.into() })
    }

    /// The same section with one more table.
    #[must_use]
    pub fn table(self, table: Table) -> Self {
        self.block(Block::Table(table))
    }

    /// The same section with a remark.
    #[must_use]
    pub fn callout(self, kind: Callout, title: impl Into<String>, text: impl Into<String>) -> Self {
        self.block(Block::Callout { kind, title: title.into(), text: text.into() })
    }
}

/// Style of the page, its colours in both themes, and paper, which is always light.
fn style_sheet() -> String {
    let (light, dark) = (variables(false), variables(true));
    format!(
        ":root{{color-scheme:light;{light}}}\
         @media (prefers-color-scheme:dark){{:root:not([data-theme=light]){{color-scheme:dark;{dark}}}}}\
         :root[data-theme=dark]{{color-scheme:dark;{dark}}}\
         {FIGURE_CSS}{CSS}\
         @media print{{:root,:root:not([data-theme=light]),:root[data-theme=dark]{{color-scheme:light;{light}}}}}"
    )
}

/// A table of no more rows is not torn between two pages.
const SHORT: usize = 16;

/// Writes blocks and counts what needs a number.
#[derive(Default)]
struct Writer {
    figures: usize,
}

impl Writer {
    fn section(&mut self, index: usize, section: &Section) -> Markup {
        let id = format!("section-{}", index + 1);
        let blocks = self.blocks(&section.blocks);
        html! { section id=(id) { h2 { (section.title) } (blocks) } }
    }

    fn blocks(&mut self, blocks: &[Block]) -> Markup {
        let blocks: Vec<Markup> = blocks.iter().map(|b| self.block(b)).collect();
        html! { @for block in &blocks { (block) } }
    }

    fn block(&mut self, block: &Block) -> Markup {
        match block {
            Block::Heading(text) => html! { h3 { (inline(text)) } },
            Block::Paragraph(text) => html! { p { (inline(text)) } },
            Block::List(points) => html! { ul { @for point in points { li { (inline(point)) } } } },
            Block::Figure { figure, caption } => self.figure(figure, caption),
            Block::Table(table) => html_table(table),
            Block::Callout { kind, title, text } => callout(*kind, title, text),
            Block::Definitions(terms) => html! {
                dl { @for (term, meaning) in terms { dt { (inline(term)) } dd { (inline(meaning)) } } }
            },
            Block::Code(text) => html! { div.code { pre { code { (text) } } } },
            Block::Details { summary, blocks } => {
                let blocks = self.blocks(blocks);
                html! { details { summary { (inline(summary)) } (blocks) } }
            }
        }
    }

    fn figure(&mut self, figure: &Figure, caption: &str) -> Markup {
        self.figures += 1;
        let id = format!("figure-{}", self.figures);
        let drawing = figure.draw(&id, Place::Page);
        html! {
            figure id=(id) {
                div.canvas { (PreEscaped(&drawing.svg)) }
                @if !caption.is_empty() || drawing.note.is_some() {
                    figcaption {
                        @if !caption.is_empty() { span { (inline(caption)) } " " }
                        @if let Some(note) = &drawing.note { span.note { (note) } }
                    }
                }
                @if let Some(data) = &drawing.data {
                    script.data type="application/json" { (PreEscaped(data)) }
                }
            }
        }
    }
}

fn callout(kind: Callout, title: &str, text: &str) -> Markup {
    let (class, word) = match kind {
        Callout::Finding => ("callout finding", "Finding"),
        Callout::Warning => ("callout warning", "Warning"),
    };
    html! {
        div class=(class) role="note" {
            p { strong { (word) @if !title.is_empty() { ": " (inline(title)) } } }
            @if !text.is_empty() { p { (inline(text)) } }
        }
    }
}

fn html_table(table: &Table) -> Markup {
    let class = |column: &Column| (column.align != Align::Left).then_some("num");
    html! {
        div.table.short[table.rows.len() <= SHORT] {
            table {
                @if !table.caption.is_empty() { caption { (inline(&table.caption)) } }
                thead { tr {
                    @for column in &table.columns {
                        @if column.name.is_empty() && column.unit.is_empty() {
                            td {}
                        } @else {
                            th scope="col" class=[class(column)] {
                                (inline(&column.name))
                                @if !column.unit.is_empty() { " " span.unit { "(" (column.unit) ")" } }
                            }
                        }
                    }
                } }
                tbody {
                    @for row in 0..table.rows.len() { tr {
                        @for (index, column) in table.columns.iter().enumerate() {
                            @if index == 0 && !table.cell(row, 0).is_empty() {
                                th scope="row" class=[row_class(table, row)] { (html_cell(table, row, index)) }
                            } @else {
                                td class=[class(column).or_else(|| short(table.cell(row, index)))] {
                                    (html_cell(table, row, index))
                                }
                            }
                        }
                    } }
                }
            }
            @for note in &table.notes { p.note { (inline(note)) } }
        }
    }
}

/// Characters of a cell that stays on one line.
const SHORT_CELL: usize = 20;
/// Characters of the name of a row that does, as of a hold in a file: in a narrow column it would be a column of words.
const SHORT_NAME: usize = 36;

fn short(cell: &str) -> Option<&'static str> {
    (1..=SHORT_CELL).contains(&cell.chars().count()).then_some("line")
}

/// A short name, or one of one word, as of a file, is not broken at its hyphens.
fn row_class(table: &Table, row: usize) -> Option<&'static str> {
    match table.columns[0].align {
        Align::Left => {
            let name = table.cell(row, 0);
            (!name.contains(' ') || name.chars().count() <= SHORT_NAME).then_some("name")
        }
        Align::Right | Align::Decimal => Some("num"),
    }
}

/// A cell; the part after a decimal point is as wide as the widest of its column, so the points line up.
fn html_cell(table: &Table, row: usize, column: usize) -> Markup {
    let cell = table.cell(row, column);
    match table.columns[column].align {
        Align::Left => inline(cell),
        Align::Right => html! { (typographic(cell)) },
        Align::Decimal => {
            let cell = typographic(cell);
            let (whole, tail) = split_decimal(&cell);
            let width = format!("min-width:{}ch", table.tail(column));
            html! { (whole) span.tail style=(width) { (tail) } }
        }
    }
}

/// Units that a line never begins with.
const UNITS: &[&str] = &[
    "N", "mN", "N·s/mm", "N/mm", "mm", "µm", "nm", "mm/s", "mm/s²", "s", "ms", "min", "h", "1/s",
    "Hz", "kHz", "%", "µε", "Pa", "kPa", "MPa", "mJ", "g", "°C", "K",
];

/// Text in which no number is parted from its unit at the end of a line.
fn unparted(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for (index, word) in text.split(' ').enumerate() {
        let unit = word.trim_end_matches([',', '.', ';', ':', ')', '?']);
        let number = out.ends_with(|c: char| c.is_ascii_digit());
        if index > 0 {
            out.push(if number && UNITS.contains(&unit) { '\u{a0}' } else { ' ' });
        }
        out.push_str(word);
    }
    out
}

/// Text with indices set lower.
fn symbols(text: &str) -> Markup {
    let text = unparted(text);
    html! {
        @for part in symbol::parts(&text) {
            @match part.place {
                symbol::Place::Line => { (part.text) },
                symbol::Place::Index => { sub { (part.text) } },
                symbol::Place::Power => { sup { (part.text) } },
            }
        }
    }
}

/// Text in which what stands between backticks is code.
fn inline(text: &str) -> Markup {
    let parts: Vec<&str> = text.split('`').collect();
    // An odd number of backticks is just text.
    if parts.len().is_multiple_of(2) {
        return symbols(text);
    }
    html! {
        @for (index, part) in parts.iter().enumerate() {
            @if index % 2 == 1 { code { (part) } } @else { (symbols(part)) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::axis::Axis;
    use super::super::plot::{Plot, Series};
    use super::*;

    const EVIL: &str = "</script><img src=x onerror=alert(1)>\"'&";

    fn page() -> Page {
        let plot = Plot::new(EVIL, Axis::new(EVIL, "s"), Axis::new("Force", "N"))
            .series(Series::line(EVIL, vec![0.0, 1.0], vec![0.0, 1.0]))
            .span(0.0, 1.0, EVIL)
            .level(0.5, EVIL)
            .annotation(0.5, 0.5, EVIL);
        let table = Table::new(EVIL, vec![Column::text("p"), Column::number("v", "N")])
            .row([EVIL, "-3.98 ± 0.07"])
            .note("Standard errors.");
        Page::new(
            EVIL,
            EVIL,
            Origin {
                program: "palpate 0.1.0".into(),
                command: EVIL.into(),
                inputs: vec![EVIL.into()],
            },
        )
        .section(Section::new(EVIL).paragraph(EVIL).figure(plot, EVIL).table(table))
        .section(
            Section::new("More")
                .callout(Callout::Warning, EVIL, "use `palpate plan`")
                .block(Block::Code(EVIL.into()))
                .block(Block::List(vec![EVIL.into()]))
                .block(Block::Definitions(vec![(EVIL.into(), EVIL.into())]))
                .block(Block::Details {
                    summary: EVIL.into(),
                    blocks: vec![Block::Heading(EVIL.into())],
                }),
        )
    }

    #[test]
    fn a_number_is_not_parted_from_its_unit() {
        let set = unparted("from 1.12 N towards 0.720 N, 39 % of it in 2 holds");
        assert_eq!(
            set.replace('\u{a0}', "~"),
            "from 1.12~N towards 0.720~N, 39~% of it in 2 holds"
        );
    }

    #[test]
    fn no_text_of_the_data_can_become_markup() {
        let html = page().to_html();
        assert!(!html.contains("<img"), "markup from data");
        // Its own script, the figure's data, the style of downloads; nothing from the data.
        assert_eq!(html.matches("</script>").count(), 3);
    }

    #[test]
    fn the_page_is_one_file_without_any_address() {
        let html = page().to_html().replace("http://www.w3.org/2000/svg", "");
        for address in ["http:", "https:", "//cdn", "@import", "url(h", "src="] {
            assert!(
                !html
                    .replace(&EVIL.replace('<', "&lt;").replace('>', "&gt;"), "")
                    .contains(address)
                    || address == "src=",
                "{address}"
            );
        }
        assert!(html.contains("default-src 'none'"));
    }

    #[test]
    fn the_same_data_give_the_same_bytes() {
        assert_eq!(page().to_html(), page().to_html());
    }

    #[test]
    fn tables_name_their_rows_and_columns_and_align_on_the_decimal_point() {
        let html = page().to_html();
        assert!(
            html.contains("<th scope=\"col\" class=\"num\">v <span class=\"unit\">(N)</span></th>")
        );
        assert!(html.contains("<th scope=\"row\">"));
        assert!(
            html.contains("−3<span class=\"tail\" style=\"min-width:10ch\">.98 ± 0.07</span>"),
            "{html}"
        );
    }

    #[test]
    fn backticks_make_code_only_in_pairs() {
        assert_eq!(inline("run `x<y` now").into_string(), "run <code>x&lt;y</code> now");
        assert_eq!(inline("a ` b").into_string(), "a ` b");
    }
}
