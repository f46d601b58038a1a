//! Formulas for what no effect of the library explains: in words, as tables and figures.

use super::dependence::{dependence_plot, scale};
use super::diagnosis::NextCommand;
use super::ladder::{ABOUT, ladder_bars, rung_name};
use super::unit_of;
use palpate_diagnose::criticism::covariate::Covariate;
use palpate_diagnose::criticism::dependence::Dependence;
use palpate_diagnose::criticism::diagnose::Verdict;
use palpate_diagnose::discover::causes::cause_of;
use palpate_diagnose::discover::formula::{Alternative, Formula, Shares};
use palpate_diagnose::discover::grammar::Term;
use palpate_diagnose::discover::surface::Surface;
use palpate_diagnose::discover::{Discovery, Outcome};
use palpate_model::StoredEffect;
use palpate_report::number::{percent, significant, with_error};
use palpate_report::{Block, Callout, CellFormat, Column, HeatMap, Section, Table};

/// Shares whose distance from 1 is less than this are all of a term.
const ALL: f64 = 0.25;
/// A dependence up to this p value is drawn.
const CLEAR: f64 = 0.01;
/// Most that are drawn.
const MAX_DRAWN: usize = 3;

/// A discovery with all that is told about it.
pub struct DiscoverySummary<'a> {
    pub(crate) discovery: &'a Discovery,
    labels: &'a [String],
    next: NextCommand,
    written: Option<String>,
}

impl<'a> DiscoverySummary<'a> {
    /// A discovery on traces of these labels; `next` names model and traces as they were given, `written` the file of the model
    /// with the formulas.
    #[must_use]
    pub fn new(
        discovery: &'a Discovery,
        labels: &'a [String],
        next: NextCommand,
        written: Option<String>,
    ) -> Self {
        Self { discovery, labels, next, written }
    }

    /// The formulas; none where another outcome is.
    pub(crate) fn formulas(&self) -> &[Formula] {
        match &self.discovery.outcome {
            Outcome::Formulas(formulas) => formulas,
            _ => &[],
        }
    }

    pub(crate) fn unit(&self) -> &str {
        unit_of(&self.discovery.diagnosis.signal)
    }

    /// What a terminal shows.
    #[must_use]
    pub fn in_short(&self) -> Vec<Section> {
        let mut sections = vec![self.answer()];
        sections.extend(self.formulas().iter().map(|formula| self.formula(formula)));
        sections
    }

    /// What a report shows: all.
    #[must_use]
    pub fn sections(&self) -> Vec<Section> {
        let mut sections = self.in_short();
        if !self.discovery.ladder.is_empty() {
            let noise = Some(self.discovery.diagnosis.noise.level);
            sections[0] = std::mem::replace(&mut sections[0], Section::new(""))
                .figure(ladder_bars(&self.discovery.ladder, self.unit(), noise), ABOUT);
        }
        sections.push(self.dependences());
        sections
    }

    fn answer(&self) -> Section {
        let (kind, title, text) = match &self.discovery.outcome {
            Outcome::Adequate => (
                Callout::Finding,
                "Only noise is left",
                "The model describes these traces to the noise: there is nothing to find a formula for.".to_owned(),
            ),
            Outcome::Library => (Callout::Finding, "The library explains it", self.library()),
            Outcome::Nothing => (
                Callout::Warning,
                "No formula",
                format!(
                    "Something is missing, and none of {} terms lowers the error on what it was not fitted to. The table of \
                     pairs in the report shows what the rest depends on without any law.",
                    self.discovery.terms
                ),
            ),
            Outcome::Formulas(formulas) => (
                Callout::Finding,
                if formulas.len() == 1 { "A formula" } else { "Formulas" },
                self.beside() + &formulas.iter().map(|it| self.sentence(it)).collect::<Vec<_>>().join(" "),
            ),
        };
        let mut section = Section::new("What is missing").callout(kind, title, text);
        if matches!(self.discovery.outcome, Outcome::Library) {
            section = section.block(Block::Code(self.next.diagnose()));
        }
        if let Some(first) = self.formulas().first() {
            let model = self.written.as_deref().unwrap_or("found.toml");
            let words = match self.written {
                Some(_) => {
                    "The formulas stand in the model file as candidates. Add one like an effect of the library:"
                }
                None => {
                    "With `-o found.toml` the formulas are written as candidates, which are added like effects of the library:"
                }
            };
            section =
                section.paragraph(words).block(Block::Code(self.next.add_to(&first.name, model)));
        }
        if self.discovery.ladder.is_empty() { section } else { section.table(self.ladder()) }
    }

    /// The effects of the library that the diagnosis kept.
    fn names(&self) -> Vec<String> {
        let steps = self.discovery.diagnosis.found.steps.iter();
        steps.map(|step| format!("`{}`", step.credible.join("` or `"))).collect()
    }

    /// What the library has a name for, where formulas stand beside that.
    fn beside(&self) -> String {
        match self.discovery.beside_library {
            true => format!("The library names {}. Beside that: ", self.names().join(" and ")),
            false => String::new(),
        }
    }

    fn library(&self) -> String {
        let diagnosis = &self.discovery.diagnosis;
        let names = self.names();
        let sure = if diagnosis.verdict == Verdict::Named {
            ""
        } else {
            ", though these traces do not say which"
        };
        format!(
            "What is missing is in the library: {}{sure}. No formula is needed.",
            names.join(" and ")
        )
    }

    /// What a formula says, in a sentence.
    fn sentence(&self, formula: &Formula) -> String {
        format!(
            "{}: {} {}. It is {}, {}.",
            formula.name,
            subject(&formula.term),
            described(&formula.term, &formula.law),
            both_ways(&formula.shares),
            in_traces(&formula.shares, self.labels),
        )
    }

    fn ladder(&self) -> Table {
        let unit = self.unit();
        let noise = self.discovery.diagnosis.noise.level;
        let columns = vec![
            Column::text("model"),
            Column::number("error", unit),
            Column::number("held out", unit),
            Column::number("held out / noise", ""),
        ];
        let mut table = Table::new("The error falls", columns);
        for (index, rung) in self.discovery.ladder.iter().enumerate() {
            let held_out = |text: fn(f64, f64) -> String| {
                rung.heldout_rms.map_or_else(|| "–".to_owned(), |rms| text(rms, noise))
            };
            table = table.row([
                rung_name((index, rung)),
                significant(rung.fitted_rms, 3),
                held_out(|rms, _| significant(rms, 3)),
                held_out(|rms, noise| format!("{:.2}", rms / noise)),
            ]);
        }
        table.note(format!(
            "Noise: {} {unit}. Searched: {} terms.",
            significant(noise, 3),
            self.discovery.terms
        ))
    }

    fn formula(&self, formula: &Formula) -> Section {
        let cause = cause_of(&formula.term);
        let code = format!("{}\n{}", law_in_words(&formula.law), values_in_words(&formula.law));
        let mut section = Section::new(formula.name.clone()).block(Block::Code(code)).paragraph(
            format!("It can come from this: {}. To confirm it: {}.", cause.cause, cause.experiment),
        );
        if formula.resembles.is_empty() {
            section = section.paragraph("No effect of the library leaves a mark like it.");
        } else {
            let alike: Vec<String> = formula
                .resembles
                .iter()
                .map(|(name, cosine)| format!("`{name}` ({cosine:.2})"))
                .collect();
            section = section.paragraph(format!(
                "On these traces its mark looks like that of {} of the library (cosine of the two).",
                alike.join(", ")
            ));
        }
        if formula.alternatives.is_empty() {
            return section;
        }
        let columns = vec![Column::text("law"), Column::text("values"), Column::number("ΔBIC", "")];
        let mut table = Table::new("These traces do not distinguish it from", columns);
        for Alternative { law, delta_bic, .. } in &formula.alternatives {
            table = table.row([law_in_words(law), values_in_words(law), format!("{delta_bic:.0}")]);
        }
        section.table(table)
    }

    /// What the residual depends on without any law.
    fn dependences(&self) -> Section {
        let columns = vec![
            Column::text("quantities"),
            Column::number("explain", ""),
            Column::number("each by itself", ""),
            Column::number("only together", ""),
            Column::number("on traces left out", ""),
            Column::number("p value", ""),
        ];
        let mut table = Table::new("Pairs of quantities", columns);
        for surface in &self.discovery.surfaces {
            let [a, b] = surface.of;
            table = table.row([
                format!("{}, {}", a.name(), b.name()),
                percent(surface.explained, 2),
                percent(surface.additive, 2),
                percent(surface.interaction(), 2),
                percent(surface.held_out.max(0.0), 2),
                format!("{:.2}", surface.p_value),
            ]);
        }
        let mut section = Section::new("What the rest depends on, without any law").table(table.note(
            "Means of the residual in ten classes of each quantity; each trace left out is predicted by those of the others.",
        ));
        if let Some(best) = self.discovery.surfaces.first() {
            section = section.figure(
                self.surface_map(best),
                "Mean residual over the noise; empty where there is no sample.",
            );
        }
        let columns = vec![
            Column::text("quantity"),
            Column::number("explains", ""),
            Column::number("p value", ""),
        ];
        let mut single = Table::new("Single quantities", columns);
        for dependence in &self.discovery.dependences {
            single = single.row([
                dependence.covariate.name().to_owned(),
                percent(dependence.explained, 2),
                format!("{:.3}", dependence.p_value),
            ]);
        }
        let clear = self.discovery.dependences.iter().filter(|it| it.p_value <= CLEAR);
        let drawn: Vec<&Dependence> = clear.take(MAX_DRAWN).collect();
        let most = scale(drawn.iter().copied());
        drawn.into_iter().fold(section.table(single), |section, dependence| {
            section.figure(dependence_plot(dependence, self.unit(), most), "")
        })
    }

    fn surface_map(&self, surface: &Surface) -> HeatMap {
        let unit = self.unit();
        let [a, b] = surface.of;
        let label = |of: Covariate| {
            let unit = of.unit(unit);
            if unit.is_empty() { of.name().to_owned() } else { format!("{}, {unit}", of.name()) }
        };
        let noise = self.discovery.diagnosis.noise.level;
        // To a tenth: more is not to be told in a cell.
        let in_noises = |mean: f64| (10.0 * mean / noise).round() / 10.0;
        let names = |at: &[f64]| at.iter().map(|value| significant(*value, 2)).collect();
        HeatMap {
            title: format!("Residual over {} and {}, in noises", a.name(), b.name()),
            summary: format!("Mean residual in classes of {} and {}", a.name(), b.name()),
            row_label: label(a),
            column_label: label(b),
            rows: names(&surface.at[0]),
            columns: names(&surface.at[1]),
            values: surface
                .means
                .iter()
                .map(|row| row.iter().map(|mean| mean.map_or(f64::NAN, in_noises)).collect())
                .collect(),
            format: CellFormat::Significant(2),
            strongest: None,
        }
    }
}

/// The law with what it adds to.
fn law_in_words(law: &StoredEffect) -> String {
    let stage = law.stage.map_or("", |stage| stage.name());
    format!("{stage}: {}", law.expression.as_deref().unwrap_or_default())
}

/// The parameters of a law with their errors and units.
fn values_in_words(law: &StoredEffect) -> String {
    let value = |(name, parameter): (&String, &palpate_model::StoredParameter)| {
        let value = match parameter.standard_error {
            Some(error) => with_error(parameter.value, error),
            None => significant(parameter.value, 4),
        };
        format!("{name} = {value} {}", parameter.unit).trim_end().to_owned()
    };
    law.parameters.iter().map(value).collect::<Vec<_>>().join(", ")
}

/// What a term adds to.
fn subject(term: &Term) -> &'static str {
    use palpate_model::Stage;
    match term.stage {
        Stage::Motion => "something added to the displacement",
        Stage::Elasticity => "a part of the elastic response",
        Stage::Relaxation => "a change of all rates of relaxation",
        Stage::Contact => "a part of the force",
        Stage::Sensor => "something added to the signal",
    }
}

/// What a term does, with its numbers.
fn described(term: &Term, law: &StoredEffect) -> String {
    let mut words = term.words();
    for (name, parameter) in &law.parameters {
        let value = format!("{} {}", significant(parameter.value, 3), parameter.unit);
        words = words.replace(&format!("{{{name}}}"), value.trim_end());
    }
    words
}

/// Whether it is the same both ways of the motion.
fn both_ways(shares: &Shares) -> String {
    let ((pressing, error), (releasing, other)) = (shares.pressing, shares.releasing);
    if !pressing.is_finite() || !releasing.is_finite() {
        return "there on one way of the motion alone".to_owned();
    }
    if (pressing - releasing).abs() <= 2.0 * error.hypot(other).max(0.05) {
        return "the same while pressing and while not".to_owned();
    }
    format!("{} of it while pressing and {} otherwise", percent(pressing, 2), percent(releasing, 2))
}

/// In which traces it is.
fn in_traces(shares: &Shares, labels: &[String]) -> String {
    if shares.traces.len() < 2 {
        return "in the one trace there is".to_owned();
    }
    let off: Vec<&str> = shares
        .traces
        .iter()
        .zip(labels)
        .filter(|(share, _)| share.is_finite() && (**share - 1.0).abs() > ALL)
        .map(|(_, label)| label.as_str())
        .collect();
    match off.len() {
        0 => "in every trace alike".to_owned(),
        1..=3 => format!("in every trace alike but {}", off.join(", ")),
        count => format!("of another size in {count} of {} traces", shares.traces.len()),
    }
}
