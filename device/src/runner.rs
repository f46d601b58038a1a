//! A fingertip that does one thing after the other: for a chip whose interrupts do no more than read the converter.

use shared::wire::{Accumulated, Accumulator, FRAME_MAX};

use crate::board::{Board, Link, Log, Restart};
use crate::conversation::Device;
use crate::stream::Sample;

/// Time from one look at what has no event of its own to the next, µs.
const TICK_US: u64 = 10_000;

/// A device with its line to a host.
#[derive(Debug)]
pub struct Runner<'a> {
    /// The device.
    pub device: Device<'a>,
    line: Accumulator,
    ticked_us: u64,
}

impl<'a> Runner<'a> {
    /// That of a device.
    #[must_use]
    pub const fn new(device: Device<'a>) -> Self {
        Self { device, line: Accumulator::new(), ticked_us: 0 }
    }

    /// One turn: what the host says, the samples that came, and what the link has room for. How to begin again, once all that was
    /// to be said before is on its way.
    pub fn turn(
        &mut self,
        now_us: u64,
        link: &mut impl Link,
        samples: &mut impl Iterator<Item = Sample>,
        board: &mut impl Board,
        log: &mut impl Log,
    ) -> Option<Restart> {
        self.receive(now_us, link, board);
        for sample in samples {
            self.device.sample(&sample);
            self.send(now_us, link, log);
        }
        self.device.drained();
        while self.device.process_injected() {
            self.send(now_us, link, log);
        }
        if now_us.saturating_sub(self.ticked_us) >= TICK_US {
            self.ticked_us = now_us;
            self.device.tick(now_us, board);
        }
        self.send(now_us, link, log);
        self.device.restart_due()
    }

    /// Carries out what the host says, as long as there is room for answers.
    fn receive(&mut self, now_us: u64, link: &mut impl Link, board: &mut impl Board) {
        while self.device.can_receive()
            && let Some(byte) = link.receive()
        {
            match self.line.push(byte) {
                Accumulated::Nothing => {}
                Accumulated::TooLong => self.device.count_damaged(),
                Accumulated::Frame(frame) => {
                    self.device.receive(frame, now_us, board);
                    // A command that is carried out may take long; samples come meanwhile.
                    return;
                }
            }
        }
    }

    fn send(&mut self, now_us: u64, link: &mut impl Link, log: &mut impl Log) {
        let mut room = [0; FRAME_MAX];
        while link.has_room()
            && let Some(frame) = self.device.next_frame(now_us, log, &mut room)
        {
            link.send(frame);
        }
    }
}
