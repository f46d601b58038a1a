//! The topics of one finger.

use std::sync::Arc;

use foxglove::{Context, FoxgloveError, PartialMetadata, RawChannel, Schema};

use crate::messages::{Fingertip, GraspMargin, Header, Message, Stamp, TouchEvent};

/// What is published of one finger. Messages go to whoever listens at that moment: viewers, and files that are being written.
#[derive(Clone, Debug)]
pub struct Topics {
    frame_id: String,
    fingertip: Arc<RawChannel>,
    events: Arc<RawChannel>,
    margin: Arc<RawChannel>,
}

impl Topics {
    /// The topics of the finger with this number, from 1.
    pub(crate) fn new(context: &Arc<Context>, finger: usize) -> Result<Self, FoxgloveError> {
        let frame_id = format!("finger_{finger}");
        Ok(Self {
            fingertip: channel::<Fingertip>(context, &frame_id, "fingertip")?,
            events: channel::<TouchEvent>(context, &frame_id, "events")?,
            margin: channel::<GraspMargin>(context, &frame_id, "margin")?,
            frame_id,
        })
    }

    /// What a message of this finger begins with, at a time in ns since 1970.
    #[must_use]
    pub fn header(&self, unix_ns: u64) -> Header {
        Header { stamp: Stamp::of(unix_ns), frame_id: self.frame_id.clone() }
    }

    /// Whether anybody listens.
    #[must_use]
    pub fn is_heard(&self) -> bool {
        [&self.fingertip, &self.events, &self.margin].iter().any(|channel| channel.has_sinks())
    }

    /// Publishes a row.
    pub fn row(&self, row: &Fingertip) {
        publish(&self.fingertip, row, &row.header);
    }

    /// Publishes an event.
    pub fn event(&self, event: &TouchEvent) {
        publish(&self.events, event, &event.header);
    }

    /// Publishes the margin of a grasp.
    pub fn margin(&self, margin: &GraspMargin) {
        publish(&self.margin, margin, &margin.header);
    }
}

fn channel<M: Message>(
    context: &Arc<Context>,
    finger: &str,
    topic: &str,
) -> Result<Arc<RawChannel>, FoxgloveError> {
    context
        .channel_builder(format!("/palpate/{finger}/{topic}"))
        .message_encoding("cdr")
        .schema(Schema::new(M::NAME, "ros2msg", M::schema().into_bytes()))
        .build_raw()
}

fn publish<M: Message>(channel: &RawChannel, message: &M, header: &Header) {
    if let Some(bytes) = message.cdr() {
        let log_time = header.stamp.unix_ns();
        channel.log_with_meta(&bytes, PartialMetadata { log_time: Some(log_time) });
    }
}
