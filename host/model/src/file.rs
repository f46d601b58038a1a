//! The model file: one TOML file a person can read, edit and compare.

use std::io;
use std::path::{Path, PathBuf};

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::laws::{LawParameter, Laws};
use super::{
    BaseLaw, Coordinate, Deformation, Elastic, Gauge, Kernel, MAX_TERMS, Parameter, Separation,
    Stage,
};
use palpate_trace::files::write_whole;
use palpate_trace::meant::did_you_mean;

/// Major version of the model file that this program reads and writes.
pub const VERSION: i64 = 1;
/// Largest model file that is read, bytes.
const MAX_BYTES: u64 = 4 << 20;

/// A base law with its parameters, how it was fitted, and the ladder of errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Major version of the format.
    #[serde(rename = "palpate-model")]
    pub version: i64,
    /// What the model is of.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Temperature from which effects count it, °C.
    #[serde(rename = "reference_temperature_C", skip_serializing_if = "Option::is_none")]
    pub reference_temperature: Option<f64>,
    /// The base law.
    pub base: Base,
    /// The effects, in the order in which they were added.
    #[serde(default, rename = "effect", skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<StoredEffect>,
    /// Laws of the user's own that are not in the model but may be tried.
    #[serde(default, rename = "candidate", skip_serializing_if = "Vec::is_empty")]
    pub candidates: Vec<StoredEffect>,
    /// How the parameters were found; absent in a model written by hand.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fit: Option<FitRecord>,
    /// Errors after each addition, the base law first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ladder: Vec<Rung>,
}

/// A base law with its options and parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Base {
    /// Name of the law.
    pub law: String,
    /// The column it predicts.
    pub signal: String,
    /// What happens when contact breaks.
    #[serde(default)]
    pub separation: Separation,
    /// Number of segments of a latency model, where given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub segments: Option<u32>,
    /// Exponent n of the nonlinear latency model, where given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exponent: Option<f64>,
    /// Elastic response; the power law where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elastic: Option<String>,
    /// Gauge length of the specimen, mm, for a law of the stretch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gauge_length_mm: Option<f64>,
    /// How the specimen is deformed, for a law of the stretch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deformation: Option<Deformation>,
    /// How the response relaxes; exponentials where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relaxation: Option<String>,
    /// Parameters by name.
    pub parameters: IndexMap<String, StoredParameter>,
}

/// An effect in a model file: one of the library by its name, or a law of the user's own with a stage
/// and an expression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredEffect {
    /// Name of the effect.
    pub name: String,
    /// Which law of a library effect; the reference form where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<String>,
    /// Where in the chain a law of one's own acts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stage: Option<Stage>,
    /// The expression of a law of one's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expression: Option<String>,
    /// What a law of one's own means.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub meaning: Option<String>,
    /// Parameters by name; of a law of one's own, the first is the strength that makes it vanish at 0.
    #[serde(default)]
    pub parameters: IndexMap<String, StoredParameter>,
}

/// A parameter in a model file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StoredParameter {
    /// Its value, in `unit`.
    pub value: f64,
    /// Its standard error, in `unit`, where it was fitted and the data determine it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard_error: Option<f64>,
    /// Its unit, absent for a pure number.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// Smallest value that a fit may give it, in a law of one's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower: Option<f64>,
    /// Largest value that a fit may give it, in a law of one's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper: Option<f64>,
}

impl Base {
    /// The law with its options, as one of these.
    fn law(&self, laws: &Laws) -> Result<BaseLaw, String> {
        let name = self.law.as_str();
        let family = laws.family(name).ok_or_else(|| {
            let meant = did_you_mean(name, laws.names());
            format!("unknown law `{name}`{meant}; known: {}", laws.names().join(", "))
        })?;
        let (elastic, kernel) = (self.elastic(laws)?, self.kernel(laws)?);
        let law = |terms| BaseLaw {
            segments: self.segments,
            exponent: self.exponent,
            ..BaseLaw::new(family, terms, self.separation).with(elastic, kernel)
        };
        // One of these stands for each exponential or branch.
        let each =
            |parameter: &LawParameter| matches!(parameter.coordinate, Coordinate::Force(1..));
        let names = law(MAX_TERMS).declared().into_iter().filter(each).map(|one| one.name);
        let names: Vec<&str> = names.collect();
        let terms = names.iter().filter(|name| self.parameters.contains_key(**name)).count();
        if law(1).has_terms() && terms == 0 {
            let first = names.first().copied().unwrap_or_default();
            return Err(format!("`{name}` lacks {first}, of its first {}", family.term[0]));
        }
        let law = law(terms);
        law.check().map_err(|error| error.to_string())?;
        Ok(law)
    }

    fn elastic(&self, laws: &Laws) -> Result<Elastic, String> {
        let Some(name) = self.elastic.as_deref() else { return Ok(Elastic::POWER) };
        let law = laws.elastic_law(name).ok_or_else(|| {
            let known: Vec<&str> = laws.elastic().iter().map(|law| law.name).collect();
            format!("unknown elastic response `{name}`; known: {}", known.join(", "))
        })?;
        if !law.needs_gauge() {
            return Ok(Elastic { law, gauge: None });
        }
        let missing = |key: &str| format!("`{name}` needs {key} in [base]");
        let length_mm = self.gauge_length_mm.ok_or_else(|| missing("gauge_length_mm"))?;
        let deformation = self.deformation.ok_or_else(|| missing("deformation"))?;
        if !(length_mm > 0.0 && length_mm.is_finite()) {
            return Err(format!("gauge_length_mm = {length_mm}, a length is above 0"));
        }
        Ok(Elastic::stretch(law, Gauge { length_mm, deformation }))
    }

    fn kernel(&self, laws: &Laws) -> Result<&'static Kernel, String> {
        let Some(name) = self.relaxation.as_deref() else { return Ok(Kernel::EXPONENTIALS) };
        laws.kernel(name).ok_or_else(|| {
            let known: Vec<&str> = laws.kernels().iter().map(|kernel| kernel.name).collect();
            format!("unknown relaxation `{name}`; known: {}", known.join(", "))
        })
    }
}

impl StoredParameter {
    /// A fitted value.
    #[must_use]
    pub fn fitted(parameter: &Parameter, value: f64, standard_error: Option<f64>) -> Self {
        let unit = parameter.unit.to_string();
        Self { value, standard_error, unit, lower: None, upper: None }
    }
}

/// How the parameters were found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitRecord {
    /// Names of the traces fitted.
    pub traces: Vec<String>,
    /// Number of samples fitted.
    pub samples: usize,
    /// Unit of the two errors below.
    pub unit: String,
    /// Root mean square of what the model leaves.
    pub residual_rms: f64,
    /// Standard deviation of the noise, where it could be told from the data without the model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_rms: Option<f64>,
    /// Coefficient of determination.
    pub r_squared: f64,
    /// Largest compression the model has seen, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest_compression_mm: Option<f64>,
    /// Why the search stopped.
    pub stop: String,
}

/// One rung of the ladder: the errors once a law or an effect was in the model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rung {
    /// The law or effect that was added.
    pub add: String,
    /// Root mean square error on the traces fitted.
    pub fitted_rms: f64,
    /// Root mean square error on whole traces left out of the fit, each in turn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heldout_rms: Option<f64>,
}

/// Why a model file cannot be used.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum FileError {
    #[error("{path}: {source}")]
    Io { path: PathBuf, source: io::Error },
    #[error("{path}: not a model file: {source}")]
    Toml { path: PathBuf, source: Box<toml::de::Error> },
    #[error(
        "{path}: a model of version {found}; this palpate reads version {VERSION}: install a newer palpate"
    )]
    Newer { path: PathBuf, found: i64 },
    #[error("{path}: {problem}")]
    Content { path: PathBuf, problem: String },
}

/// Refuses a TOML text with a number that is not finite, by its line.
fn check_finite(text: &str) -> Result<(), String> {
    let Ok(table) = DeTable::parse(text) else { return Ok(()) };
    let Some(at) = table.get_ref().values().find_map(not_finite) else { return Ok(()) };
    let number = 1 + text[..at].matches('\n').count();
    let line = text.lines().nth(number - 1).unwrap_or_default().trim();
    Err(format!("line {number}: `{line}` is not a finite number"))
}

/// Where the first number stands that is not finite.
fn not_finite(value: &Spanned<DeValue<'_>>) -> Option<usize> {
    match value.get_ref() {
        DeValue::Float(float) => {
            let finite = float.as_str().parse().is_ok_and(f64::is_finite);
            (!finite).then(|| value.span().start)
        }
        DeValue::Array(values) => values.iter().find_map(not_finite),
        DeValue::Table(table) => table.values().find_map(not_finite),
        _ => None,
    }
}

impl Model {
    /// Reads a model file.
    ///
    /// # Errors
    /// When the file cannot be read, is of a newer version, or does not describe a model.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::read_with(path, &Laws::library())
    }

    /// Reads a model file whose base law is one of these.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn read_with(path: &Path, laws: &Laws) -> Result<Self, FileError> {
        let failed = |source| FileError::Io { path: path.into(), source };
        if std::fs::metadata(path).map_err(failed)?.len() > MAX_BYTES {
            let problem = format!("larger than {} MiB: not a model file", MAX_BYTES >> 20);
            return Err(FileError::Content { path: path.into(), problem });
        }
        Self::parse_with(path, &std::fs::read_to_string(path).map_err(failed)?, laws)
    }

    /// Reads a model from the text of a file; `path` is what errors call it.
    ///
    /// # Errors
    /// As [`Model::read`], but for those of the file system.
    pub fn parse(path: &Path, text: &str) -> Result<Self, FileError> {
        Self::parse_with(path, text, &Laws::library())
    }

    fn parse_with(path: &Path, text: &str, laws: &Laws) -> Result<Self, FileError> {
        let not_toml = |source| FileError::Toml { path: path.into(), source: Box::new(source) };
        let content = |problem: String| FileError::Content { path: path.into(), problem };
        // The version first: a newer file may hold keys that this program would call wrong.
        let table: toml::Table = toml::from_str(text).map_err(not_toml)?;
        match table.get("palpate-model").and_then(toml::Value::as_integer) {
            Some(VERSION) => {}
            Some(found) if found > VERSION => {
                return Err(FileError::Newer { path: path.into(), found });
            }
            _ => {
                return Err(content(format!(
                    "no line `palpate-model = {VERSION}`: not a model file"
                )));
            }
        }
        check_finite(text).map_err(content)?;
        let model: Self = toml::from_str(text).map_err(not_toml)?;
        model.law_of(laws).map_err(content)?;
        Ok(model)
    }

    /// Writes the model file, whole or not at all.
    ///
    /// # Errors
    /// When the file cannot be written, or a number of the model is not finite.
    pub fn write(&self, path: &Path) -> Result<(), FileError> {
        let content = |problem: String| FileError::Content { path: path.into(), problem };
        let text = self.to_toml().map_err(content)?;
        write_whole(path, |file| file.write_all(text.as_bytes()))
            .map_err(|source| FileError::Io { path: path.into(), source })
    }

    /// The text of the model file.
    ///
    /// # Errors
    /// In words, when a number of the model is not finite.
    pub fn to_toml(&self) -> Result<String, String> {
        let text = toml::to_string(self).map_err(|error| error.to_string())?;
        check_finite(&text).map_err(|problem| format!("not written: {problem}"))?;
        Ok(text)
    }

    /// A model of the law with these values, in the order of [`BaseLaw::parameters`].
    #[must_use]
    pub fn of(
        law: &BaseLaw,
        signal: &str,
        values: &[f64],
        standard_errors: &[Option<f64>],
    ) -> Self {
        let stored = |((parameter, &value), &standard_error): ((Parameter, &f64), &Option<f64>)| {
            let stored = StoredParameter::fitted(&parameter, value, standard_error);
            (parameter.name.to_string(), stored)
        };
        let parameters =
            law.parameters().into_iter().zip(values).zip(standard_errors).map(stored).collect();
        let base = Base {
            law: law.name().into(),
            signal: signal.into(),
            separation: law.separation,
            segments: law.segments,
            exponent: law.exponent,
            elastic: (law.elastic != Elastic::POWER).then(|| law.elastic.name().into()),
            gauge_length_mm: law.elastic.gauge.map(|gauge| gauge.length_mm),
            deformation: law.elastic.gauge.map(|gauge| gauge.deformation),
            relaxation: (law.kernel != Kernel::EXPONENTIALS).then(|| law.kernel.name.into()),
            parameters,
        };
        Self {
            version: VERSION,
            name: None,
            reference_temperature: None,
            base,
            effects: Vec::new(),
            candidates: Vec::new(),
            fit: None,
            ladder: Vec::new(),
        }
    }

    /// The law and its parameter values, in the order of [`BaseLaw::parameters`].
    ///
    /// # Errors
    /// In words, when the law is unknown or a parameter is missing, unknown or out of its range.
    pub fn law(&self) -> Result<(BaseLaw, Vec<f64>), String> {
        self.law_of(&Laws::library())
    }

    /// The law, as one of these, and its parameter values, in the order of [`BaseLaw::parameters`].
    ///
    /// # Errors
    /// As [`Model::law`].
    pub fn law_of(&self, laws: &Laws) -> Result<(BaseLaw, Vec<f64>), String> {
        let law = self.base.law(laws)?;
        let names = &self.base.parameters;
        let declared = law.parameters();
        if let Some(unknown) =
            names.keys().find(|name| declared.iter().all(|p| p.name != name.as_str()))
        {
            return Err(format!("{} has no parameter `{unknown}`", law.in_words()));
        }
        let value = |parameter: &Parameter| {
            let name = parameter.name.as_ref();
            let value = names.get(name).ok_or(format!("parameter `{name}` is missing"))?.value;
            if !value.is_finite() || value < parameter.lower || value > parameter.upper {
                return Err(format!(
                    "parameter `{name}` is {value}; it must lie between {} and {}",
                    parameter.lower, parameter.upper
                ));
            }
            Ok(value)
        };
        let values = declared.iter().map(value).collect::<Result<Vec<_>, _>>()?;
        Ok((law, values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ElasticLaw;

    fn example() -> Model {
        let law = BaseLaw::fung(2, Separation::Free);
        let values = [0.07, 0.9, 0.25, 0.26, 4.0, 0.5];
        let errors = [Some(0.001), None, Some(0.01), Some(0.01), Some(0.1), Some(0.02)];
        let mut model = Model::of(&law, "force_N", &values, &errors);
        model.ladder.push(Rung { add: "fung".into(), fitted_rms: 0.02, heldout_rms: Some(0.03) });
        model
    }

    #[test]
    fn a_model_comes_back_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.toml");
        example().write(&path).unwrap();
        assert_eq!(Model::read(&path).unwrap(), example());
        let (law, values) = example().law().unwrap();
        assert_eq!((law.terms, law.separation), (2, Separation::Free));
        assert_eq!(values, [0.07, 0.9, 0.25, 0.26, 4.0, 0.5]);
    }

    #[test]
    fn elastic_response_and_relaxation_come_back_as_they_were_written() {
        let gauge = Gauge { length_mm: 33.0, deformation: Deformation::Tension };
        let elastic = Elastic::stretch(ElasticLaw::GENT, gauge);
        let law = BaseLaw::fung(2, Separation::Bonded).with(elastic, Kernel::STRETCHED);
        let values = [3.0, 50.0, 0.4, 2.5, 0.3];
        let model = Model::of(&law, "force_N", &values, &[None; 5]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.toml");
        model.write(&path).unwrap();
        assert_eq!(Model::read(&path).unwrap().law().unwrap(), (law, values.to_vec()));
        let refusal = |from: &str, to: &str| {
            let written = toml::to_string(&model).unwrap();
            assert!(written.contains(from), "{written}");
            std::fs::write(&path, written.replacen(from, to, 1)).unwrap();
            Model::read(&path).unwrap_err().to_string()
        };
        assert!(refusal("gauge_length_mm = 33.0\n", "").contains("needs gauge_length_mm"));
        assert!(refusal("\"gent\"", "\"gant\"").contains("unknown elastic response `gant`"));
        assert!(refusal("\"stretched\"", "\"bent\"").contains("unknown relaxation `bent`"));
    }

    #[test]
    fn a_number_that_is_not_finite_is_neither_written_nor_read_and_its_line_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.toml");
        for (wrong, shown) in [(f64::NAN, "nan"), (f64::INFINITY, "inf"), (-f64::INFINITY, "-inf")]
        {
            let mut model = example();
            model.ladder[0].fitted_rms = wrong;
            let error = model.write(&path).unwrap_err().to_string();
            assert!(error.contains("not written") && error.contains(shown), "{error}");
            assert!(!path.exists());
            let text = toml::to_string(&model).unwrap();
            let line = 1 + text.lines().position(|line| line.contains("fitted_rms")).unwrap();
            std::fs::write(&path, &text).unwrap();
            let error = Model::read(&path).unwrap_err().to_string();
            assert!(error.contains(&format!("line {line}: `fitted_rms = {shown}`")), "{error}");
            std::fs::remove_file(&path).unwrap();
        }
        let written = toml::to_string(&example()).unwrap();
        std::fs::write(&path, written.replace("value = 0.07", "value = 7e999")).unwrap();
        assert!(Model::read(&path).unwrap_err().to_string().contains("7e999"));
        std::fs::write(&path, written.replace("value = 0.07", "value = 1_0.0_7")).unwrap();
        Model::read(&path).unwrap();
    }

    #[test]
    fn a_file_too_large_for_a_model_is_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.toml");
        std::fs::File::create(&path).unwrap().set_len(MAX_BYTES + 1).unwrap();
        let error = Model::read(&path).unwrap_err().to_string();
        assert!(error.contains("larger than 4 MiB"), "{error}");
    }

    #[test]
    fn what_is_wrong_with_a_model_file_is_said() {
        let written = toml::to_string(&example()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.toml");
        let refusal = |from: &str, to: &str| {
            assert!(written.contains(from), "{written}");
            std::fs::write(&path, written.replacen(from, to, 1)).unwrap();
            Model::read(&path).unwrap_err().to_string()
        };
        assert!(refusal("palpate-model = 1", "palpate-model = 7").contains("version 7"));
        assert!(refusal("palpate-model = 1", "").contains("no line `palpate-model = 1`"));
        assert!(refusal("law = \"fung\"", "law = \"fang\"").contains("unknown law `fang`"));
        assert!(refusal("value = 4.0", "value = -4.0").contains("`v1` is -4"));
        assert!(refusal("parameters.v2]", "parameters.v9]").contains("no parameter `v9`"));
        assert!(refusal("value = 4.0", "value = \"x\"").contains("line"));
    }
}
