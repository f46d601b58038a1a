//! What is done to traces before anything is fitted to them.

use std::sync::Arc;

use super::Failure;
use palpate_present::summary::Preparation;
use palpate_trace::{
    Trace, join, motion_noise, outliers, repeats, stairs, tare, without, without_repeats,
};

/// Flags of every command that fits a model or compares it.
#[derive(clap::Args)]
pub struct Prepare {
    /// Leave out impossible samples: drop-outs of the motion, single jumps of the signal
    #[arg(long)]
    drop_outliers: bool,
    /// Leave out rows that only repeat a signal that was recorded more slowly
    #[arg(long)]
    drop_repeats: bool,
    /// Take the motion as straight between its steps where the displacement was held or rounded
    #[arg(long)]
    join_steps: bool,
    /// Take its mean before the touch off the signal of each trace
    #[arg(long)]
    tare: bool,
}

/// The traces that are fitted, and what was found and done before.
pub type Prepared = (Arc<Vec<Trace>>, Preparation);

impl Prepare {
    /// Looks for impossible samples in the motion of a data set and in `signal`, for a signal that repeats and for a displacement in stairs, and
    /// does what the flags ask for. The traces are copied only where a flag changes them.
    pub fn take(&self, traces: Arc<Vec<Trace>>, signal: &str) -> Result<Prepared, Failure> {
        let mut taken = traces;
        let mut found = Vec::new();
        for k in 0..taken.len() {
            let own = outliers(&taken[k], signal);
            if self.drop_outliers && !own.is_empty() {
                let left = without(&taken[k], &own);
                Arc::make_mut(&mut taken)[k] = left;
            }
            found.extend(own);
        }
        let repeats = repeats(&taken, signal);
        if self.drop_repeats && !repeats.is_empty() {
            for trace in Arc::make_mut(&mut taken) {
                *trace = without_repeats(trace, signal);
            }
        }
        let stairs = stairs(&taken, signal);
        if self.join_steps && !stairs.is_empty() {
            for trace in Arc::make_mut(&mut taken) {
                let label = trace.label();
                if let Some(own) = stairs.iter().find(|own| own.trace == label) {
                    join(trace, own);
                }
            }
        }
        let mut tared = Vec::new();
        if self.tare {
            for trace in Arc::make_mut(&mut taken) {
                let label = trace.label();
                let zero = tare(trace, signal).ok_or_else(|| {
                    Failure::Input(miette::miette!(
                        "--tare: {label} has no `{signal}` before the touch, displacement above 0, to take the resting value from"
                    ))
                })?;
                tared.push((label, zero));
            }
        }
        let how = Preparation {
            outliers: found,
            dropped: self.drop_outliers,
            repeats,
            repeats_dropped: self.drop_repeats,
            stairs,
            joined: self.join_steps,
            motion_noise: motion_noise(&taken, signal),
            tared,
            refit: None,
        };
        Ok((taken, how))
    }

    /// The flags that were given, to be put behind the traces of another command.
    pub fn flags(&self) -> String {
        let given = [
            (self.drop_outliers, " --drop-outliers"),
            (self.drop_repeats, " --drop-repeats"),
            (self.join_steps, " --join-steps"),
            (self.tare, " --tare"),
        ];
        given.into_iter().filter(|(given, _)| *given).map(|(_, flag)| flag).collect()
    }
}
