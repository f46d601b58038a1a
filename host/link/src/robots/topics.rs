//! Rows, events and margins as messages of ROS 2.

use std::net::IpAddr;
use std::time::Instant;

use palpate_robots::{Door, Fingertip, GraspMargin, Topics, TouchEvent};
use shared::events::Kind;
use shared::fixed::microstrain;
use shared::wire::{Felt, Row};

use super::stamps::Stamps;
use super::{Listener, RobotsError};
use palpate_analysis::regions::{code, type_code};
use palpate_contact::grasp::live::Reading;

/// Viewers that are let in, until this ends.
pub struct Viewers {
    door: Door,
    url: String,
}

impl Viewers {
    /// Lets viewers in at an address; port 0 stands for any that is free.
    ///
    /// # Errors
    /// [`RobotsError::Door`] if the address cannot be had.
    pub fn serve(address: IpAddr, port: u16) -> Result<Self, RobotsError> {
        let mut door = Door::new();
        let url = door.serve(address, port)?;
        Ok(Self { door, url })
    }

    /// Address of a viewer's connection.
    #[must_use]
    pub fn url(&self) -> &str {
        &self.url
    }

    /// The topics of the finger with this number, from 1.
    ///
    /// # Errors
    /// [`RobotsError::Door`].
    pub fn finger(&self, number: usize) -> Result<Box<dyn Listener>, RobotsError> {
        Ok(Box::new(Finger::new(self.door.finger(number)?)))
    }
}

/// One finger, as it is published.
pub(super) struct Finger {
    topics: Topics,
    stamps: Stamps,
    /// Number of the row that comes next.
    next_row: u64,
    /// The latest stamp: they do not go back where the clocks are related anew.
    latest_ns: u64,
}

impl Finger {
    pub(super) fn new(topics: Topics) -> Self {
        Self { topics, stamps: Stamps::new(), next_row: 0, latest_ns: 0 }
    }

    fn row(&mut self, row: &Row) {
        self.latest_ns = self.latest_ns.max(self.stamps.unix_ns(row.time_us));
        if !self.topics.is_heard() {
            return;
        }
        let strains = |gauges: &[i32; 4]| gauges.map(microstrain);
        let (elastic, equilibrium) =
            row.rest.map(|(elastic, rest)| (strains(&elastic), strains(&rest))).unzip();
        self.topics.row(&Fingertip {
            header: self.topics.header(self.latest_ns),
            number: row.number,
            device_time_us: row.time_us,
            counts: row.counts,
            fa: strains(&row.fa),
            sa: strains(&row.sa),
            elastic: elastic.map_or_else(Vec::new, Vec::from),
            equilibrium: equilibrium.map_or_else(Vec::new, Vec::from),
            region: row.states.map(|state| code(state.region) as u8),
            entered_rows_ago: row
                .entered
                .map(|rows| rows.map_or(-1, |rows| i32::try_from(rows).unwrap_or(i32::MAX))),
            relaxation: row.states.map(|state| type_code(state.relaxation) as u8),
            flags: row.states.map(|state| state.flags.bits()),
        });
    }
}

impl Listener for Finger {
    fn rows(&mut self, rows: &[Row], at: Instant) {
        let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return };
        if first.number < self.next_row {
            self.stamps.restart();
        }
        self.next_row = last.number + 1;
        self.stamps.hear(last.time_us, at);
        rows.iter().for_each(|row| self.row(row));
    }

    fn event(&mut self, felt: &Felt) {
        self.topics.event(&TouchEvent {
            header: self.topics.header(self.stamps.unix_ns(felt.time_us)),
            number: felt.number,
            row: felt.row,
            began_rows_before: felt.event.began_samples_ago,
            kind: match felt.event.kind {
                Kind::Touch => 0,
                Kind::Release => 1,
                Kind::Slip => 2,
            },
            gauge: felt.event.channel.saturating_add(1),
        });
    }

    fn margin(&mut self, reading: &Reading) {
        let device_us = (reading.time * 1e6).round() as u64;
        let known = |number: Option<f64>| number.unwrap_or(f64::NAN);
        self.topics.margin(&GraspMargin {
            header: self.topics.header(self.stamps.unix_ns(device_us)),
            normal_force: reading.now.normal,
            tangential_force: reading.now.load.force[0],
            moment: reading.now.load.moment,
            margin: known(reading.now.margin),
            settled_margin: known(reading.settled.margin),
            slips_in: known(reading.slips_in),
            tighten: known(reading.tighten),
        });
    }
}
