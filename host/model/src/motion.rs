//! What was done to the specimen: displacement over time, and the rest before.

use std::borrow::Cow;

use palpate_trace::Trace;

/// Displacement over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion<'a> {
    /// Time of each sample, s, strictly increasing.
    pub time: Cow<'a, [f64]>,
    /// Displacement at each sample, mm, positive into the specimen.
    pub displacement: Cow<'a, [f64]>,
    /// Seconds between the end of the trace before and the start of this one, where the data set
    /// says so; without it the specimen counts as rested.
    pub rest_before: Option<f64>,
}

/// Why a trace cannot serve as a motion.
#[derive(Debug, thiserror::Error)]
pub enum MotionError {
    /// No `displacement_mm`.
    #[error("{trace} has no column displacement_mm, so there is no motion to run a model over.{}", of_strain(.strain.as_deref()))]
    NoDisplacement {
        /// Name of the trace.
        trace: String,
        /// A column of strain, where it has one.
        strain: Option<String>,
    },
}

/// How a strain becomes a displacement.
fn of_strain(column: Option<&str>) -> String {
    let words = |column| {
        format!(
            " Its {column} becomes one where the mapping of the import names it displacement_mm and gives the length of the specimen: \
             `gauge_length_mm`."
        )
    };
    column.map_or_else(String::new, words)
}

impl MotionError {
    fn without_displacement(trace: &Trace) -> Self {
        let mut names = trace.columns.iter().map(|column| &column.name);
        let strain = names.find(|name| name.starts_with("strain")).cloned();
        Self::NoDisplacement { trace: trace.label(), strain }
    }
}

impl<'a> Motion<'a> {
    /// Takes the motion of one trace, the specimen rested before.
    ///
    /// # Errors
    /// When the trace has no displacement.
    pub fn of(trace: &'a Trace) -> Result<Self, MotionError> {
        let displacement =
            trace.displacement().ok_or_else(|| MotionError::without_displacement(trace))?;
        Ok(Self {
            time: Cow::Borrowed(&trace.time),
            displacement: Cow::Borrowed(displacement),
            rest_before: None,
        })
    }

    /// Takes the motions of a data set in order of recording. Where every trace says when it began
    /// (`start_s`), what the specimen still remembers is carried from each to the next.
    ///
    /// # Errors
    /// When a trace has no displacement.
    pub fn of_set(traces: &'a [Trace]) -> Result<Vec<Self>, MotionError> {
        let mut motions = traces.iter().map(Self::of).collect::<Result<Vec<_>, _>>()?;
        for (pair, motion) in traces.windows(2).zip(motions.iter_mut().skip(1)) {
            let end = pair[0].head.setup.start_s.map(|start| start + pair[0].duration());
            let start = pair[1].head.setup.start_s;
            motion.rest_before =
                start.zip(end).map(|(start, end)| start - end).filter(|s| *s >= 0.0);
        }
        Ok(motions)
    }

    /// Largest compression, mm; 0 where the specimen is never reached.
    #[must_use]
    pub fn largest_compression(&self) -> f64 {
        self.displacement.iter().copied().fold(0.0, f64::max)
    }
}
