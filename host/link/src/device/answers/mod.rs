//! What the commands of a device answer, as types: `--json` prints them, the page and other programs get them.
//!
//! One subject a file: its types, and how they follow from what was heard. Nothing is computed here.

mod calibration;
mod identity;
mod ports;
mod recording;
mod release;
mod self_test;
mod settings;
mod status;

pub use calibration::{CalibratedAnswer, CalibrationAnswer};
pub use identity::{DeviceAnswer, IdentityAnswer};
pub use ports::{PortAnswer, PortsAnswer};
pub use recording::{EventAnswer, PartsAnswer, RecordedAnswer, SecondAnswer, ViewAnswer};
pub use release::ReleaseAnswer;
pub use self_test::{CheckAnswer, OwnAnswer, SelfTestAnswer, SelfTestInFull};
pub use settings::{
    GaugeAnswer, RelaxationAnswer, SetAnswer, SettingsAnswer, TareAnswer, ThresholdsAnswer,
};
pub use status::{CountersAnswer, SourceAnswer, StatusAnswer};
