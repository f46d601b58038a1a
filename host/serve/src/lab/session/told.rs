//! What a session tells: its state, how far its work is, what is drawn.

use serde_json::{Value, json};

use super::{Session, Version};
use crate::lab::comparison::comparison_json;
use crate::lab::drawing::{Drawing, View};
use crate::lab::error::LabError;
use crate::lab::forecast::Forecast;
use crate::lab::job::Job;
use crate::lab::work::{Beside, reveal};
use palpate_diagnose::practice::SEALED;
use palpate_fit::data::Data;
use palpate_present::summary::unit_of;
use palpate_trace::Trace;

impl Session {
    /// All that the page shows beside the plots.
    #[must_use]
    pub fn state(&mut self) -> Value {
        self.settle();
        let folder = self.folder.as_ref();
        let sets = folder.and_then(|folder| folder.sets().ok()).unwrap_or_default();
        let models = folder.and_then(|folder| folder.models().ok()).unwrap_or_default();
        let trace = |(trace, chosen): (&Trace, &bool)| {
            json!({
                "name": trace.label(),
                "samples": trace.len(),
                "duration_s": trace.duration(),
                "chosen": chosen,
            })
        };
        let left_out = |(name, why): &(String, String)| json!({ "name": name, "why": why });
        let version = |version: &Version| {
            json!({
                "file": version.file,
                "saved": version.saved,
                "command": version.command,
                "said": version.said,
                "rms": version.model.fit.as_ref().map(|fit| fit.residual_rms),
            })
        };
        let beside = |beside: &Beside| {
            json!({
                "file": beside.file,
                "command": beside.command,
                "model": beside.model.as_ref(),
                "comparison": comparison_json(&beside.compared.comparison, &beside.compared.preparation),
            })
        };
        let sealed = folder
            .and_then(|folder| folder.existing(&self.set).ok())
            .is_some_and(|path| path.join(SEALED).is_file());
        json!({
            "folder": folder.map(|folder| folder.shown("")),
            "sets": sets,
            "set": self.set,
            "models": models,
            "traces": self.traces.iter().zip(&self.chosen).map(trace).collect::<Vec<_>>(),
            "left_out": self.left_out.iter().map(left_out).collect::<Vec<_>>(),
            "signals": self.signals(),
            "signal": self.signal,
            "unit": unit_of(&self.signal),
            "model": self.versions.last().map(|version| version.model.as_ref()),
            "versions": self.versions.iter().map(version).collect::<Vec<_>>(),
            "comparison": self.known.compared.as_ref().map(|of| comparison_json(&of.comparison, &of.preparation)),
            "beside": self.known.beside.as_ref().map(beside),
            "answers": self.known.answers,
            "reports": self.known.reports.iter().map(|(kind, _)| kind).collect::<Vec<_>>(),
            "practice": sealed,
            "surveys": folder.and_then(|folder| folder.surveys().ok()).unwrap_or_default(),
            "survey": self.survey,
            "job": self.job.as_ref().map(Job::json),
            "failed": self.failed,
        })
    }

    /// What is at work, how far it is, or why it gave nothing.
    #[must_use]
    pub fn progress(&mut self) -> Value {
        self.settle();
        json!({"job": self.job.as_ref().map(Job::json), "failed": self.failed})
    }

    /// Part of a trace, with the model where it was compared.
    ///
    /// # Errors
    /// When there is no such trace.
    pub fn overlay(&mut self, view: &View) -> Result<Value, LabError> {
        self.settle();
        let unknown = || LabError::Unknown { what: "trace", name: view.trace.to_string() };
        let Some(compared) = &self.known.compared else {
            return self.measured(view.trace).map(|drawing| drawing.json(view)).ok_or_else(unknown);
        };
        let mut found = compared.drawings.get(view.trace).ok_or_else(unknown)?.json(view);
        let beside = self.known.beside.as_ref().and_then(|b| b.compared.drawings.get(view.trace));
        found["beside"] = beside.map_or(Value::Null, |drawing| drawing.json(view));
        Ok(found)
    }

    /// One trace looked at more closely; null before there is a comparison.
    ///
    /// # Errors
    /// When there is no such trace.
    pub fn closer(&mut self, trace: usize) -> Result<Value, LabError> {
        self.settle();
        let Some(compared) = &self.known.compared else { return Ok(Value::Null) };
        let unknown = || LabError::Unknown { what: "trace", name: trace.to_string() };
        compared.closer.get(trace).cloned().ok_or_else(unknown)
    }

    /// A trace without a model.
    fn measured(&mut self, trace: usize) -> Option<&Drawing> {
        let known = &mut self.known.measured;
        known.resize(self.taken.len(), None);
        let drawing = known.get_mut(trace)?;
        if drawing.is_none() {
            let spans = self.spans[trace].clone();
            *drawing = Drawing::of_trace(&self.taken, trace, &self.signal, spans);
        }
        drawing.as_ref()
    }

    /// What a candidate would make of part of a trace, before anything is refitted.
    ///
    /// # Errors
    /// When nothing was diagnosed, or the screen foretells nothing for it.
    pub fn forecast(&mut self, effect: &str, view: &View) -> Result<Value, LabError> {
        self.settle();
        let none = || LabError::NoForecast(effect.into());
        if self.known.forecast.as_ref().is_none_or(|known| known.effect != effect) {
            let diagnosis = self.known.diagnosis.as_ref().ok_or_else(none)?;
            let data = Data::of_model(self.model()?, &self.taken)?;
            self.known.forecast = Forecast::new(diagnosis, &data, effect);
        }
        self.known.forecast.as_ref().and_then(|known| known.json(view)).ok_or_else(none)
    }

    /// The last report of a kind: `fit`, `compare`, `diagnosis` or `change`.
    ///
    /// # Errors
    /// When there is none.
    pub fn report(&mut self, kind: &str) -> Result<Value, LabError> {
        self.settle();
        let own = self.known.reports.iter().find(|(known, _)| *known == kind);
        let unknown = || LabError::Unknown { what: "report", name: kind.into() };
        let (kind, page) = own.ok_or_else(unknown)?;
        Ok(json!({"file": format!("{kind}.html"), "html": page}))
    }

    /// What is hidden in the practice set at hand.
    ///
    /// # Errors
    /// When it is none.
    pub fn reveal(&self) -> Result<Value, LabError> {
        let mut truth = reveal(&self.folder()?.existing(&self.set)?)?;
        truth["command"] =
            format!("palpate hide --open {}", self.folder()?.shown(&self.set)).into();
        Ok(truth)
    }
}
