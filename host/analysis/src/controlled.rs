//! Analyses of relaxation need a held displacement.

use palpate_trace::{Control, Trace, control};

/// Force was controlled where a held displacement is needed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{trace}: force was controlled ({}), so its holds creep: use `palpate creep`.{}",
    if *told { "the head says so" } else { "the data say so" },
    if *told { "" } else { " If displacement was, write control = \"displacement\" into the head." }
)]
pub struct ForceControlled {
    /// Name of the trace.
    pub trace: String,
    /// Whether the head says so; else the data do.
    pub told: bool,
}

/// Refuses a trace whose force was controlled.
///
/// # Errors
/// [`ForceControlled`].
pub fn displacement_controlled(trace: &Trace) -> Result<(), ForceControlled> {
    match control(trace) {
        Control::Displacement => Ok(()),
        Control::Force => {
            Err(ForceControlled { trace: trace.label(), told: trace.head.control.is_some() })
        }
    }
}
