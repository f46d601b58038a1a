//! The messages, field by field as their definitions in `palpate_msgs/msg/` say.

use byteorder::LittleEndian;
use cdr_encoding::to_vec;
use serde::Serialize;

/// Gauges of a fingertip.
pub const GAUGES: usize = 4;

/// Little-endian CDR follows, by the rule of the OMG that ROS 2 takes.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// What the definitions are made of, in the form that a topic's schema gives them.
const PARTS: &str = "\
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// Nanoseconds in a second.
const NANO: u64 = 1_000_000_000;

/// A message of a topic.
pub trait Message: Serialize {
    /// Name of its type.
    const NAME: &'static str;
    /// Its definition, without those of its parts.
    const DEFINITION: &'static str;

    /// Its definition with those of its parts.
    #[must_use]
    fn schema() -> String {
        format!("{}{PARTS}", Self::DEFINITION)
    }

    /// The bytes that ROS 2 sends; none where a text is longer than a message can be.
    fn cdr(&self) -> Option<Vec<u8>>
    where
        Self: Sized,
    {
        let fields = to_vec::<_, LittleEndian>(self).ok()?;
        Some([&ENCAPSULATION[..], &fields].concat())
    }
}

/// A time since 1970.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Stamp {
    /// Whole seconds.
    pub sec: i32,
    /// The rest, ns.
    pub nanosec: u32,
}

impl Stamp {
    /// So many nanoseconds after 1970; a time past 2038 stops there, as the type does.
    #[must_use]
    pub fn of(unix_ns: u64) -> Self {
        let sec = i32::try_from(unix_ns / NANO).unwrap_or(i32::MAX);
        Self { sec, nanosec: (unix_ns % NANO) as u32 }
    }

    /// Nanoseconds after 1970.
    #[must_use]
    pub fn unix_ns(self) -> u64 {
        u64::try_from(self.sec).unwrap_or_default() * NANO + u64::from(self.nanosec)
    }
}

/// Where and when a message is of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Header {
    /// By the clock of the computer.
    pub stamp: Stamp,
    /// The finger.
    pub frame_id: String,
}

/// One row of a fingertip. Strains are in µε.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fingertip {
    /// When it was sampled.
    pub header: Header,
    /// Rows since the start of the stream.
    pub number: u64,
    /// The same instant by the clock of the device, µs.
    pub device_time_us: u64,
    /// Raw counts of the converter.
    pub counts: [i32; GAUGES],
    /// Fast-adapting part.
    pub fa: [f64; GAUGES],
    /// Slow-adapting part.
    pub sa: [f64; GAUGES],
    /// Elastic input of the filter; empty if it is not sent.
    pub elastic: Vec<f64>,
    /// Equilibrium of the filter; empty if it is not sent.
    pub equilibrium: Vec<f64>,
    /// Region of the grasp, 0 to 6, as far as it is known at this row.
    pub region: [u8; GAUGES],
    /// Where a region was recognised at this row: how many rows ago it was entered; else −1.
    pub entered_rows_ago: [i32; GAUGES],
    /// Type of relaxation, 0 to 2.
    pub relaxation: [u8; GAUGES],
    /// Sum of warnings.
    pub flags: [u8; GAUGES],
}

impl Message for Fingertip {
    const NAME: &'static str = "palpate_msgs/msg/Fingertip";
    const DEFINITION: &'static str = include_str!("../palpate_msgs/msg/Fingertip.msg");
}

/// A touch, a release or a slip.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TouchEvent {
    /// When it became known.
    pub header: Header,
    /// Events since the start of the stream.
    pub number: u32,
    /// The row at which it became known.
    pub row: u64,
    /// So many rows before that one it showed first.
    pub began_rows_before: u32,
    /// 0 touch, 1 release, 2 slip.
    pub kind: u8,
    /// The gauge that told it, from 1.
    pub gauge: u8,
}

impl Message for TouchEvent {
    const NAME: &'static str = "palpate_msgs/msg/TouchEvent";
    const DEFINITION: &'static str = include_str!("../palpate_msgs/msg/TouchEvent.msg");
}

/// How much more than its load a grasp holds. NaN stands for what is not known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GraspMargin {
    /// Of the row it follows from.
    pub header: Header,
    /// N.
    pub normal_force: f64,
    /// N.
    pub tangential_force: f64,
    /// About the normal, N mm.
    pub moment: f64,
    /// The load could be so many times as large.
    pub margin: f64,
    /// The same once the silicone has settled.
    pub settled_margin: f64,
    /// Until it slips if nothing moves, s.
    pub slips_in: f64,
    /// Normal force to add now, N.
    pub tighten: f64,
}

impl Message for GraspMargin {
    const NAME: &'static str = "palpate_msgs/msg/GraspMargin";
    const DEFINITION: &'static str = include_str!("../palpate_msgs/msg/GraspMargin.msg");
}
