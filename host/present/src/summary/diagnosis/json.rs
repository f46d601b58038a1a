//! The answer that other programs read.

use serde_json::{Map, Value, json};

use super::DiagnosisSummary;
use palpate_diagnose::criticism::adequacy::Adequacy;
use palpate_diagnose::criticism::noise::Seen;
use palpate_diagnose::criticism::search::Rival;
use palpate_diagnose::criticism::{agreement, dependence, screen};

impl DiagnosisSummary<'_> {
    /// The diagnosis as one JSON object, as the format has it, with more beside.
    #[must_use]
    pub fn json(&self) -> Value {
        let diagnosis = self.diagnosis;
        let found = &diagnosis.found;
        let steps: Vec<Value> = (0..found.steps.len()).map(|index| self.step_json(index)).collect();
        let places: Vec<Value> = diagnosis
            .places
            .iter()
            .map(|cell| {
                self.with_newtons(json!({
                    "trace": diagnosis.labels[cell.trace],
                    "phase": cell.region.name(),
                    "share_of_excess": cell.share_of_excess,
                    "rms": cell.rms,
                }))
            })
            .collect();
        let untestable = diagnosis.untestable.iter();
        let untestable: Vec<Value> = untestable
            .map(|(effect, reason)| json!({"effect": effect, "reason": reason}))
            .collect();
        self.with_newtons(json!({
            "palpate_diagnosis": 1,
            "verdict": diagnosis.verdict.word(),
            "signal": diagnosis.signal,
            "unit": self.unit(),
            "noise_rms": self.noise(),
            "given_rms": diagnosis.given_rms,
            "base_rms": found.base.rms(),
            "final_rms": found.model().rms(),
            "discrepancy_rms": diagnosis.discrepancy,
            "p_values": if found.inexact { "agreement between parts of the data" } else { "noise" },
            "standard_errors": if found.inexact { "jackknife over parts of the data" } else { "noise" },
            "steps": steps,
            "refused": self.refused_json(),
            "where": places,
            "depends_on": self.dependences_json(),
            "untestable": untestable,
            "next_experiment": self.next_experiment(),
            "in_words": self.verdict_in_words().replace('`', ""),
            "candidates": self.candidates_json(),
            "noise": {
                "standard_deviation": self.noise(),
                "autoregression": diagnosis.noise.whitening.coefficients(),
                "flicker": diagnosis.noise.whitening.flicker() > 0.0,
                "seen_off_the_specimen": diagnosis.noise.seen == Seen::OffTheSpecimen,
                "samples": diagnosis.noise.samples,
            },
            "adequacy": {
                "before": adequacy(&diagnosis.before),
                "after": adequacy(&diagnosis.after),
                "unexplained": diagnosis.unexplained,
            },
            "notes": diagnosis.notes,
            "left_out": self.data.left_out,
            "seeds": {
                "null": screen::SEED,
                "resampling": self.diagnosis.options.seed,
                "dependence": dependence::SEED,
                "agreement": agreement::SEED,
            },
        }))
    }

    /// An object with every error under its name of version 1 as well, where the unit is N.
    fn with_newtons(&self, mut object: Value) -> Value {
        const ERRORS: [&str; 8] = [
            "rms",
            "noise_rms",
            "base_rms",
            "final_rms",
            "rms_before",
            "rms_after",
            "heldout_rms_before",
            "heldout_rms_after",
        ];
        if self.unit() == "N" {
            for name in ERRORS {
                if let Some(value) = object.get(name).cloned() {
                    object[format!("{name}_N")] = value;
                }
            }
        }
        object
    }

    fn step_json(&self, index: usize) -> Value {
        let found = &self.diagnosis.found;
        let step = &found.steps[index];
        let before = if index == 0 { &found.base } else { &found.models[index - 1] };
        let after = &found.models[index];
        let held_out = |index: usize| self.diagnosis.held_out[index].as_ref().map(|h| h.rms);
        let parameters: Map<String, Value> = self
            .parameters(index)
            .into_iter()
            .map(|(parameter, value, standard_error)| {
                let value =
                    json!({"value": value, "standard_error": standard_error, "unit": parameter.unit});
                (parameter.name.to_string(), value)
            })
            .collect();
        let rival = |rival: &Rival| {
            self.with_newtons(json!({
                "effect": rival.effect,
                "law": rival.law(),
                "delta_bic_to_best": rival.fitted.bic() - step.rivals[0].fitted.bic(),
                "won": rival.won,
                "rms": rival.fitted.rms(),
            }))
        };
        self.with_newtons(json!({
            "effect": step.effect,
            "law": self.applied(index).law,
            "credible_set": step.credible,
            "parameters": parameters,
            "rms_before": before.rms(),
            "rms_after": after.rms(),
            "heldout_rms_before": held_out(index),
            "heldout_rms_after": held_out(index + 1),
            "heldout_gain_sure": self.diagnosis.sure[index],
            "delta_bic": before.bic() - after.bic(),
            "p_value": step.p_value,
            "rivals": step.rivals.iter().map(rival).collect::<Vec<_>>(),
        }))
    }

    /// What the rest depends on, strongest first.
    fn dependences_json(&self) -> Vec<Value> {
        let dependences = self.after().dependences.iter();
        dependences
            .map(|dependence| {
                json!({
                    "covariate": dependence.covariate.symbol(),
                    "explained": dependence.explained,
                    "p_value": dependence.p_value,
                    "trend": dependence.trend,
                })
            })
            .collect()
    }

    fn candidates_json(&self) -> Vec<Value> {
        let ranked = self.ranked();
        let testable = ranked.iter().filter(|ranked| self.untestable(ranked.name).is_none());
        testable
            .map(|ranked| {
                json!({"effect": ranked.name, "gain_foretold": ranked.gain, "chance": ranked.chance})
            })
            .collect()
    }
}

fn adequacy(found: &Adequacy) -> Value {
    json!({
        "p_value": found.p_value,
        "ljung_box": found.lights.ljung_box,
        "durbin_watson": found.lights.durbin_watson,
        "runs": found.lights.runs,
    })
}
