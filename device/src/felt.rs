//! Touch, release and slip on their way from the filter to the host.

use heapless::Deque;
use shared::events::{Config, Event, Settings, State};
use shared::fixed::microstrain;
use shared::pipeline::{GAUGES, Pipeline};
use shared::wire::Felt;

/// Events that may wait for the link; they come some tenths of a second apart.
const WAITING: usize = 8;

/// What is an event for gauges whose samples are `interval_s` seconds apart; none where no settings suit them.
pub(crate) fn config(interval_s: f64) -> Option<Config> {
    let settings = Settings::DEFAULT.at_interval(interval_s);
    Config::new(&settings, microstrain(1), interval_s).ok()
}

/// What is felt of one stream.
#[derive(Clone, Debug, Default)]
pub(crate) struct Feeling {
    config: Option<Config>,
    /// None before the first row, and after strain got another meaning.
    state: Option<State<GAUGES>>,
    /// Events since the start of the stream.
    number: u32,
    waiting: Deque<Felt, WAITING>,
}

impl Feeling {
    /// Of nothing yet.
    pub(crate) const fn new() -> Self {
        Self { config: None, state: None, number: 0, waiting: Deque::new() }
    }

    /// A stream begins.
    pub(crate) fn begin(&mut self, config: Option<Config>) {
        self.configure(config, false);
        self.number = 0;
        self.waiting.clear();
    }

    /// Other settings from the next row on; unless strain means what it did, that is the first.
    pub(crate) fn configure(&mut self, config: Option<Config>, same_strain: bool) {
        self.config = config;
        if !same_strain {
            self.begin_anew();
        }
    }

    /// The next row is the first: out of contact.
    pub(crate) fn begin_anew(&mut self) {
        self.state = None;
    }

    /// Takes the last sample of a pipeline.
    #[inline(always)]
    pub(crate) fn step(&mut self, pipeline: &Pipeline) -> Option<Event> {
        let config = self.config.as_ref()?;
        let at_rest = || State::at_rest(pipeline.outputs().map(|output| output.equilibrium));
        let state = self.state.get_or_insert_with(at_rest);
        state.take(config, &pipeline.outputs().map(|output| (output.strain, output.fa)))
    }

    /// An event at this row is to be sent. Without room it is lost, which its number shows.
    #[cold]
    pub(crate) fn note(&mut self, event: Event, row: u64, time_us: u64) {
        let _ = self.waiting.push_back(Felt { number: self.number, row, time_us, event });
        self.number = self.number.wrapping_add(1);
    }

    /// Whether none waits.
    pub(crate) fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// The oldest that waits.
    pub(crate) fn next(&mut self) -> Option<Felt> {
        self.waiting.pop_front()
    }
}
