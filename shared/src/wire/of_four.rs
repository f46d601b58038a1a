//! How release 0.1 says what there is of every gauge: of four, without a length. Hosts and devices of that release and its recordings
//! are spoken to and read in these words.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use super::message::{ConverterFault, Counters, SelfTest, Source, Status};
use super::per_gauge::{FOUR, PerGauge};
use super::samples::Block;
use super::{Answer, Columns, Done, SettingsByRatio, ToHost};
use crate::pipeline;

/// [`Block`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[allow(missing_docs)]
pub struct BlockOfFour<'a> {
    pub first: u64,
    pub generation: u32,
    pub temperature: Option<i16>,
    pub columns: Columns,
    #[serde(borrow, with = "serde_bytes")]
    pub packed: &'a [u8],
}

/// [`Status`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema)]
#[allow(missing_docs)]
pub struct StatusOfFour {
    pub counters: Counters,
    pub gauges: [pipeline::Counters; FOUR],
    pub rows: u64,
    pub streaming: Option<Source>,
    pub temperature: Option<i16>,
    pub converter: Option<ConverterFault>,
    pub stack_used: u32,
    pub queue_most: u8,
}

/// [`SelfTest`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[allow(missing_docs)]
pub struct SelfTestOfFour {
    pub converter: Result<(), ConverterFault>,
    pub noise_counts: [f32; FOUR],
    pub mean_counts: [i32; FOUR],
    pub samples: u16,
    pub rate_ratio: f32,
}

impl ToHost<'_> {
    /// The message in the words of this release, whichever it was said in.
    #[must_use]
    pub fn in_words_of_today(self) -> Self {
        match self {
            Self::SamplesOfFour(block) => Self::Samples(block.into()),
            Self::StatusOfFour(status) => Self::Status(status.into()),
            Self::SettingsByRatio { generation, settings } => {
                let settings = settings.settings(SettingsByRatio::CLOCK_HZ);
                Self::Settings { generation, settings }
            }
            Self::Answer(Answer { to, outcome: Ok(Done::TestedOfFour(test)) }) => {
                Self::Answer(Answer { to, outcome: Ok(Done::Tested(test.into())) })
            }
            said => said,
        }
    }
}

impl<'a> From<BlockOfFour<'a>> for Block<'a> {
    fn from(block: BlockOfFour<'a>) -> Self {
        let BlockOfFour { first, generation, temperature, columns, packed } = block;
        Self { gauges: FOUR as u8, first, generation, temperature, columns, packed }
    }
}

impl From<StatusOfFour> for Status {
    fn from(status: StatusOfFour) -> Self {
        Self {
            gauges: PerGauge::of(&status.gauges),
            counters: status.counters,
            rows: status.rows,
            streaming: status.streaming,
            temperature: status.temperature,
            converter: status.converter,
            stack_used: status.stack_used,
            queue_most: status.queue_most,
        }
    }
}

impl From<Status> for StatusOfFour {
    fn from(status: Status) -> Self {
        Self {
            gauges: status.gauges.four(),
            counters: status.counters,
            rows: status.rows,
            streaming: status.streaming,
            temperature: status.temperature,
            converter: status.converter,
            stack_used: status.stack_used,
            queue_most: status.queue_most,
        }
    }
}

impl From<SelfTestOfFour> for SelfTest {
    fn from(test: SelfTestOfFour) -> Self {
        let SelfTestOfFour { converter, noise_counts, mean_counts, samples, rate_ratio } = test;
        let (noise_counts, mean_counts) = (PerGauge::of(&noise_counts), PerGauge::of(&mean_counts));
        Self { converter, noise_counts, mean_counts, samples, rate_ratio }
    }
}

impl From<SelfTest> for SelfTestOfFour {
    fn from(test: SelfTest) -> Self {
        let SelfTest { converter, noise_counts, mean_counts, samples, rate_ratio } = test;
        let (noise_counts, mean_counts) = (noise_counts.four(), mean_counts.four());
        Self { converter, noise_counts, mean_counts, samples, rate_ratio }
    }
}
