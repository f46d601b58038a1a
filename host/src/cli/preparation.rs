//! What is done to traces before anything is fitted to them.

use std::path::Path;

use super::Failure;
use crate::summary::Preparation;
use crate::trace::{Trace, outliers, read_set, tare, without};

/// Flags of every command that fits a model or compares it.
#[derive(clap::Args)]
pub struct Prepare {
    /// Leave out impossible samples: drop-outs of the motion, single jumps of the signal
    #[arg(long)]
    drop_outliers: bool,
    /// Take its mean before the touch off the signal of each trace
    #[arg(long)]
    tare: bool,
}

impl Prepare {
    /// Reads a data set, looks for impossible samples in its motion and in `signal`, and does what the
    /// flags ask for.
    pub fn read<P: AsRef<Path>>(
        &self,
        paths: &[P],
        signal: &str,
    ) -> Result<(Vec<Trace>, Preparation), Failure> {
        let mut traces = read_set(paths).map_err(Failure::input)?;
        let (mut found, mut tared) = (Vec::new(), Vec::new());
        for trace in &mut traces {
            let own = outliers(trace, signal);
            if self.drop_outliers && !own.is_empty() {
                *trace = without(trace, &own);
            }
            found.extend(own);
        }
        for trace in traces.iter_mut().filter(|_| self.tare) {
            let label = trace.label();
            let zero = tare(trace, signal).ok_or_else(|| {
                Failure::Input(miette::miette!(
                    "--tare: {label} has no `{signal}` before the touch, displacement above 0, to take the resting value from"
                ))
            })?;
            tared.push((label, zero));
        }
        Ok((
            traces,
            Preparation { outliers: found, dropped: self.drop_outliers, tared, refit: None },
        ))
    }

    /// The flags that were given, to be put behind the traces of another command.
    pub fn flags(&self) -> String {
        let given = [(self.drop_outliers, " --drop-outliers"), (self.tare, " --tare")];
        given.into_iter().filter(|(given, _)| *given).map(|(_, flag)| flag).collect()
    }
}
