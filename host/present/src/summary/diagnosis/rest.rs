//! What is left beside the noise, what these traces cannot show, and how all was done.

use super::DiagnosisSummary;
use palpate_diagnose::criticism::noise::Seen;
use palpate_diagnose::criticism::screen;
use palpate_diagnose::criticism::screen::{ABSORBED, DRAWS};
use palpate_diagnose::criticism::search::RESAMPLES;
use palpate_report::number::{percent, significant};
use palpate_report::{Block, Column, Section, Table};

impl DiagnosisSummary<'_> {
    /// Adequacy, lights, noise, untestable effects, seeds.
    pub(super) fn rest(&self) -> Section {
        let mut section = Section::new("Is the rest noise?")
            .paragraph(self.rest_in_words())
            .table(self.light_table())
            .paragraph(self.noise_in_words());
        if !self.diagnosis.untestable.is_empty() {
            let reason = |(effect, reason): &(String, String)| format!("`{effect}`: {reason}");
            section = section
                .block(Block::Heading("What these traces cannot show".into()))
                .block(Block::List(self.diagnosis.untestable.iter().map(reason).collect()));
        }
        section
            .block(Block::Heading("How this was found".into()))
            .paragraph(method(self.diagnosis.options.seed))
    }

    fn light_table(&self) -> Table {
        let (before, after) = (&self.diagnosis.before, &self.diagnosis.after);
        let found = !self.diagnosis.found.steps.is_empty();
        let columns = vec![
            Column::text("whitened residual"),
            Column::number(if found { "before" } else { "" }, ""),
            Column::number(if found { "after" } else { "" }, ""),
            Column::text("noise gives"),
        ];
        let mut table = Table::new("", columns);
        let mut row = |name: &str,
                       value: fn(&palpate_diagnose::criticism::adequacy::Adequacy) -> String,
                       noise: &str| {
            let after = if found { value(after) } else { String::new() };
            table = std::mem::take(&mut table).row([name, &value(before), &after, noise]);
        };
        row("p value of its block sums", |a| significant(a.p_value, 2), "above 0.001");
        row("Ljung–Box, over 20", |a| format!("{:.2}", a.lights.ljung_box), "1");
        row("Durbin–Watson", |a| format!("{:.2}", a.lights.durbin_watson), "2");
        row("runs over expected", |a| format!("{:.2}", a.lights.runs), "1");
        table.note("The block sums judge. The other three are lights: to look at, not to judge by.")
    }

    fn noise_in_words(&self) -> String {
        let noise = &self.diagnosis.noise;
        let white = &noise.whitening;
        let seen = match noise.seen {
            Seen::OffTheSpecimen => "at rest off the specimen",
            Seen::OnTheWayIn => "off the specimen, on the way to the first touch, for want of rest",
            Seen::Residual => {
                "in the residual of the model, for want of rest off the specimen: what the model lacks \
                 is in it, and little can be said of it"
            }
        };
        let coefficients: Vec<String> =
            white.coefficients().iter().map(|a| significant(*a, 2)).collect();
        let correlation = if coefficients.is_empty() {
            "white".to_owned()
        } else {
            format!(
                "an autoregression of order {} with coefficients {}",
                coefficients.len(),
                coefficients.join(", ")
            )
        };
        let flicker = if white.flicker() > 0.0 { ", with flicker (1/f) beside it" } else { "" };
        format!(
            "The noise has a standard deviation of {} {}; it is {correlation}{flicker}. It was seen {seen}, \
             in {} samples.",
            self.level(self.noise()),
            self.unit(),
            noise.samples
        )
    }
}

fn method(resampling: u64) -> String {
    format!(
        "The noise is made white by a filter; the model is refitted. Every law of every effect is screened \
         by a score test of what its sensitivity has beyond the model's own parameters; below {} of its \
         size it counts as absorbed. The chance of the largest score anywhere in the library comes from \
         {DRAWS} draws of noise (seed {}). The best are refitted, and the Bayesian information criterion \
         on whitened residuals decides; {RESAMPLES} resamplings of blocks of the data (seed {}) show how \
         firmly. Then the same for what is left, and of every effect found it is asked again whether it is \
         needed and whether another would do better.",
        percent(ABSORBED, 1),
        screen::SEED,
        resampling,
    )
}
