//! Tables and small line plots for the terminal.

mod fitting;

use comfy_table::{CellAlignment, ColumnConstraint, LineStyle, TableStyle, Width};

use self::fitting::{DIGITS_DROPPED, Fitted, TIE, fitted, stacked, transposed};
use super::number::significant;
use super::table::{Align, Table, split_decimal};

/// What the terminal can show. Every function here returns text; whoever prints it knows the terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terminal {
    /// Columns of the terminal; wider tables wrap their cells.
    pub width: usize,
    /// Whether it shows more than ASCII.
    pub unicode: bool,
    /// Whether it shows ANSI colours.
    pub colour: bool,
}

impl Default for Terminal {
    /// 80 columns, Unicode, no colour: safe where nothing is known.
    fn default() -> Self {
        Self { width: 80, unicode: true, colour: false }
    }
}

const BOLD: &str = "1";
const FAINT: &str = "2";
const CYAN: &str = "36";

impl Terminal {
    /// A table: caption, columns with units, notes; numbers on their decimal points, none of them cut: where the terminal is too
    /// narrow, words wrap and are shortened, then rows become columns, then numbers lose a digit or rows are stacked. Ends with a line
    /// feed.
    #[must_use]
    pub fn table(&self, table: &Table) -> String {
        let mut out = String::new();
        if !table.caption.is_empty() {
            for line in textwrap(&self.plain(&table.caption), self.width) {
                out += &(self.paint(BOLD, &line) + "\n");
            }
        }
        // A digit is worth more than the shape of a table, unless many rows are to be compared.
        let several = table.rows.len() > 1;
        let as_it_is = |dropped| fitted(table, self.width, dropped);
        let turned = |dropped| transposed(table).and_then(|t| fitted(&t, self.width, dropped));
        let rounded = || several.then(|| as_it_is(DIGITS_DROPPED)).flatten();
        let whole = as_it_is(0).or_else(|| turned(0));
        out += &match whole.or_else(rounded).or_else(|| turned(DIGITS_DROPPED)) {
            Some(fitted) => self.grid(&fitted),
            None => self.stack(table),
        };
        for note in table.notes.iter().flat_map(|n| textwrap(&self.plain(n), self.width)) {
            out += &(self.paint(FAINT, &note) + "\n");
        }
        out
    }

    fn grid(&self, Fitted { table, widths, padding }: &Fitted) -> String {
        let mut grid = comfy_table::Table::new();
        let rule = if self.unicode { '─' } else { '-' };
        let rule = LineStyle::none().fill(rule).junction(rule);
        grid.load_style(TableStyle::new().header_separator(rule).bottom_border(rule));
        grid.set_header(table.columns.iter().map(|c| self.plain(&c.title())));
        for row in 0..table.rows.len() {
            grid.add_row((0..table.columns.len()).map(|column| self.cell(table, row, column)));
        }
        for (index, column) in table.columns.iter().enumerate() {
            if let (Some(set), true) = (grid.column_mut(index), column.align != Align::Left) {
                set.set_cell_alignment(CellAlignment::Right);
            }
        }
        for (index, width) in widths.iter().enumerate() {
            let width = u16::try_from(width + padding).unwrap_or(u16::MAX);
            if let Some(column) = grid.column_mut(index) {
                column.set_padding((1, u16::from(*padding > 1)));
                column.set_constraint(ColumnConstraint::Absolute(Width::Fixed(width)));
            }
        }
        grid.to_string().lines().map(|line| untied(line).trim_end().to_owned() + "\n").collect()
    }

    /// Each row as its name with what the columns say of it below.
    fn stack(&self, table: &Table) -> String {
        let mut out = String::new();
        for (name, told) in stacked(table) {
            out += &self.text("", &name);
            for (title, cell) in told {
                let title = if title.is_empty() { title } else { title + ": " };
                out += &self.text("  ", &(title + &cell));
            }
        }
        untied(&out)
    }

    /// Running text after a mark, its lines no longer than the terminal and below each other. Ends with a
    /// line feed.
    #[must_use]
    pub fn text(&self, mark: &str, text: &str) -> String {
        let indent = mark.chars().count();
        let lines = textwrap(&self.plain(text), self.width.saturating_sub(indent).max(12));
        let line = |(number, line): (usize, &String)| {
            let before = if number == 0 { mark.to_owned() } else { " ".repeat(indent) };
            format!("{before}{line}\n")
        };
        lines.iter().enumerate().map(line).collect()
    }

    fn cell(&self, table: &Table, row: usize, column: usize) -> String {
        let text = table.cell(row, column);
        if table.columns[column].align != Align::Decimal {
            return self.plain(text);
        }
        let missing = table.tail(column) - split_decimal(text).1.chars().count();
        // It is not trimmed off the end of a cell.
        self.plain(text) + &TIE.to_string().repeat(missing)
    }

    /// A trace in one row of `width` blocks, scaled from its least to its greatest value; a gap is a space.
    #[must_use]
    pub fn sparkline(&self, values: &[f64], width: usize) -> String {
        let levels: Vec<char> = if self.unicode { "▁▂▃▄▅▆▇█" } else { "_.-~^" }.chars().collect();
        let (low, high) = extent(values);
        let width = width.min(values.len());
        let column = |index: usize| {
            let part = &values[index * values.len() / width..(index + 1) * values.len() / width];
            // The value furthest from the middle: a peak narrower than a column stays visible.
            let middle = 0.5 * (low + high);
            let finite = part.iter().copied().filter(|v| v.is_finite());
            finite.max_by(|a, b| (a - middle).abs().total_cmp(&(b - middle).abs()))
        };
        let level = |value: Option<f64>| match value {
            None => ' ',
            Some(_) if high <= low => levels[0],
            Some(v) => {
                let steps = (levels.len() - 1) as f64;
                levels[((v - low) / (high - low) * steps).round() as usize]
            }
        };
        self.paint(CYAN, &(0..width).map(|i| level(column(i))).collect::<String>())
    }

    /// A line plot of `y` over `x` in `height` rows of characters, with the range of both axes beside it.
    /// Braille dots, 2 × 4 to a character; stars in ASCII. Nothing finite gives an empty string.
    #[must_use]
    pub fn chart(
        &self,
        x: &[f64],
        y: &[f64],
        y_label: &str,
        x_label: &str,
        height: usize,
    ) -> String {
        let points = || x.iter().zip(y).filter(|(a, b)| a.is_finite() && b.is_finite());
        if points().next().is_none() || height == 0 {
            return String::new();
        }
        let (low, high) = extent(&points().map(|(_, b)| *b).collect::<Vec<_>>());
        let (from, to) = extent(&points().map(|(a, _)| *a).collect::<Vec<_>>());
        let labels = [high, low].map(|v| self.plain(&significant(v, 3)));
        let margin = labels.iter().map(|l| l.chars().count()).max().unwrap_or(0);
        let width = self.width.saturating_sub(margin + 3).max(10);
        let mut canvas = Canvas::new(width, height, self.unicode);
        let (right, bottom) = (canvas.dots().0 - 1.0, canvas.dots().1 - 1.0);
        let share =
            |v: f64, low: f64, high: f64| if high > low { (v - low) / (high - low) } else { 0.5 };
        let mut before: Option<(f64, f64)> = None;
        for (a, b) in x.iter().zip(y) {
            let here = (share(*a, from, to) * right, (1.0 - share(*b, low, high)) * bottom);
            if !(here.0.is_finite() && here.1.is_finite()) {
                before = None;
                continue;
            }
            canvas.line(before.unwrap_or(here), here);
            before = Some(here);
        }
        let bar = if self.unicode { "┤" } else { "|" };
        let side = if self.unicode { "│" } else { "|" };
        let mut out = format!("{}{}\n", " ".repeat(margin + 1), self.plain(y_label));
        for (row, line) in canvas.rows().iter().enumerate() {
            let (label, edge) = match row {
                0 => (labels[0].as_str(), bar),
                r if r + 1 == height => (labels[1].as_str(), bar),
                _ => ("", side),
            };
            out += &format!("{label:>margin$} {edge}{}\n", self.paint(CYAN, line.trim_end()));
        }
        let ends = [from, to].map(|v| significant(v, 3));
        let x_label = self.plain(x_label);
        let used = ends[0].chars().count() + ends[1].chars().count() + x_label.chars().count();
        let room = width.saturating_sub(used);
        let (before, after) = (" ".repeat(room / 2), " ".repeat(room - room / 2));
        out + &format!("{}{}{before}{x_label}{after}{}\n", " ".repeat(margin + 2), ends[0], ends[1])
    }

    /// Text the terminal can show: itself, or its nearest ASCII.
    fn plain(&self, text: &str) -> String {
        // An escape in a file's head must not reach the terminal.
        let text = text.chars().filter(|c| !c.is_control() || *c == '\n');
        if self.unicode {
            return text.collect();
        }
        text.map(ascii).collect()
    }

    fn paint(&self, code: &str, text: &str) -> String {
        if self.colour { format!("\u{1b}[{code}m{text}\u{1b}[0m") } else { text.to_owned() }
    }
}

/// With plain spaces for those that kept words together.
fn untied(text: &str) -> String {
    text.replace(TIE, " ")
}

fn ascii(c: char) -> String {
    match c {
        '±' => "+-".into(),
        '−' | '–' | '—' => "-".into(),
        '×' | '·' => "x".into(),
        'µ' | 'μ' => "u".into(),
        'ν' => "v".into(),
        '∞' => "inf".into(),
        '°' => "deg ".into(),
        '²' => "^2".into(),
        '³' => "^3".into(),
        '…' => "...".into(),
        '₀'..='₉' => (c as u32 - '₀' as u32).to_string(),
        TIE => TIE.into(),
        c if c.is_ascii() => c.into(),
        _ => "?".into(),
    }
}

/// Lines of words; a number and its unit stay together.
fn textwrap(text: &str, width: usize) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    // What is tied together stays so.
    for word in text.split_ascii_whitespace() {
        let unit = word.chars().filter(|c| !matches!(c, '.' | ',' | ';' | ')')).count() <= 2;
        match words.last_mut() {
            Some(last) if unit && last.ends_with(|c: char| c.is_ascii_digit()) => {
                last.push(' ');
                last.push_str(word);
            }
            _ => words.push(word.to_owned()),
        }
    }
    let mut lines: Vec<String> = Vec::new();
    for word in words {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    lines
}

fn extent(values: &[f64]) -> (f64, f64) {
    let finite = values.iter().copied().filter(|v| v.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
}

/// Dots drawn with characters.
struct Canvas {
    width: usize,
    height: usize,
    cell: (usize, usize),
    cells: Vec<u8>,
}

impl Canvas {
    fn new(width: usize, height: usize, unicode: bool) -> Self {
        let cell = if unicode { (2, 4) } else { (1, 1) };
        Self { width, height, cell, cells: vec![0; width * height] }
    }

    fn dots(&self) -> (f64, f64) {
        ((self.width * self.cell.0) as f64, (self.height * self.cell.1) as f64)
    }

    fn line(&mut self, from: (f64, f64), to: (f64, f64)) {
        let steps = (to.0 - from.0).abs().max((to.1 - from.1).abs()).ceil().max(1.0);
        for step in 0..=steps as usize {
            let share = step as f64 / steps;
            let x = (from.0 + share * (to.0 - from.0)).round() as usize;
            let y = (from.1 + share * (to.1 - from.1)).round() as usize;
            let dot = match self.cell {
                (2, 4) => [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]][y % 4][x % 2],
                _ => 1,
            };
            self.cells[y / self.cell.1 * self.width + x / self.cell.0] |= dot;
        }
    }

    fn rows(&self) -> Vec<String> {
        let show = |cell: &u8| match (self.cell, *cell) {
            (_, 0) => ' ',
            ((2, 4), dots) => char::from_u32(0x2800 + u32::from(dots)).unwrap_or(' '),
            _ => '*',
        };
        self.cells.chunks(self.width).map(|row| row.iter().map(show).collect()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::Column;
    use super::*;

    fn table() -> Table {
        Table::new(
            "Fit",
            vec![Column::text("Parameter"), Column::number("Value", "N"), Column::whole("n")],
        )
        .row(["N", "3.981 ± 0.074", "860"])
        .row(["v₁", "-12.5 ± 1.2", "7"])
        .note("µ and ± become ASCII where asked.")
    }

    #[test]
    fn numbers_stand_on_their_decimal_points() {
        let text = Terminal::default().table(&table());
        let points: Vec<_> =
            text.lines().filter_map(|l| l.chars().position(|c| c == '.')).collect();
        assert_eq!(points[0], points[1], "{text}");
        assert!(text.contains("Value (N)"));
    }

    #[test]
    fn ascii_and_no_colour_are_honoured() {
        let terminal = Terminal { unicode: false, ..Terminal::default() };
        let text =
            terminal.table(&table()) + &terminal.chart(&[0.0, 1.0], &[0.0, 1.0], "µε", "s", 4);
        assert!(text.is_ascii() && !text.contains('\u{1b}'), "{text}");
        let colour = Terminal { colour: true, ..Terminal::default() }.table(&table());
        assert!(colour.starts_with("\u{1b}[1mFit\u{1b}[0m"));
    }

    #[test]
    fn a_table_is_no_wider_than_the_terminal() {
        let long =
            table().row(["a parameter with a name that goes on and on and on", "1.0 ± 0.1", "3"]);
        for width in [20, 30, 40, 60, 120] {
            let text = Terminal { width, ..Terminal::default() }.table(&long);
            assert!(text.lines().all(|l| l.chars().count() <= width), "{text}");
        }
    }

    /// What is printed of numbers at every width, from very narrow on.
    #[test]
    fn a_number_is_never_cut() {
        let columns = ["early hold", "late hold", "unloading"].map(|name| Column::number(name, ""));
        let columns = std::iter::once(Column::text("trace")).chain(columns).collect();
        let table = Table::new("Root mean square error, N", columns)
            .row(["table-3.1-row-01.csv", "0.00785", "0.0122", "-12.5 ± 1.2"])
            .row(["table-3.1-row-02.csv", "0.00691", "0.0118", "881(24)"]);
        for width in 16..100 {
            for unicode in [true, false] {
                let text = Terminal { width, unicode, colour: false }.table(&table);
                let shown = text.replace('\u{a0}', " ").replace("+-", "±");
                let has = |forms: &[&str]| forms.iter().any(|form| shown.contains(form));
                assert!(
                    has(&["0.00785", "0.0078"]) && has(&["0.0118", "0.012"]),
                    "{width}\n{text}"
                );
                assert!(has(&["-12.5 ± 1.2", "-12 ± 1", "-13 ± 1"]), "{width}\n{text}");
                assert!(has(&["881(24)", "880(20)"]), "{width}\n{text}");
            }
        }
    }

    #[test]
    fn text_is_no_wider_than_the_terminal_and_hangs_from_its_mark() {
        let terminal = Terminal { width: 30, ..Terminal::default() };
        let text = terminal.text("=> ", "a finding that takes more than one line of this terminal");
        assert!(text.lines().all(|l| l.chars().count() <= 30), "{text}");
        assert!(text.starts_with("=> a finding") && text.contains("\n   than one line"), "{text}");
    }

    #[test]
    fn escapes_in_the_data_do_not_reach_the_terminal() {
        let text = Terminal::default().table(&table().row(["\u{1b}[31mred", "1", "1"]));
        assert!(!text.contains('\u{1b}'));
    }

    #[test]
    fn a_sparkline_shows_peaks_gaps_and_constants() {
        let mut values = vec![0.0; 800];
        values[399] = 1.0;
        let line = Terminal::default().sparkline(&values, 8);
        assert_eq!(line, "▁▁▁█▁▁▁▁");
        assert_eq!(Terminal::default().sparkline(&[1.0, f64::NAN, 1.0], 3), "▁ ▁");
        assert_eq!(Terminal::default().sparkline(&[], 10), "");
    }

    #[test]
    fn a_chart_fits_its_width_and_says_its_ranges() {
        let x: Vec<f64> = (0..500).map(|i| f64::from(i) * 0.01).collect();
        let y: Vec<f64> = x.iter().map(|t| (t * 3.0).sin()).collect();
        let text =
            Terminal { width: 60, ..Terminal::default() }.chart(&x, &y, "force (N)", "time (s)", 6);
        assert_eq!(text.lines().count(), 8);
        assert!(text.lines().all(|l| l.chars().count() <= 60), "{text}");
        assert!(text.contains("1.00") && text.contains("-1.00") && text.contains("4.99"), "{text}");
        assert_eq!(Terminal::default().chart(&[], &[], "", "", 4), "");
    }
}
