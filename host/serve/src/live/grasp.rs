//! The margin of what the fingertip holds, as `palpate grasp watch` tells it.

use std::collections::VecDeque;

use serde::Deserialize;
use serde_json::{Value, json};
use shared::pipeline::GAUGES;
use shared::wire::Row;

use palpate_contact::grasp::live::{Felt, Fingertip, Watch, Weights, weights};
use palpate_contact::grasp::{Body, Contact, PressureLaw};
use palpate_link::robots::Listener;
use palpate_present::answers::{self, GraspWatchAnswer};

/// Time between two readings, s, as of the command.
const EVERY_S: f64 = 0.2;
/// Readings kept: those of two minutes.
const KEPT: usize = 600;
/// The longest rest, s.
const REST_S: f64 = 60.0;

/// What must be known of a grasp, in the words of the command's options.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Holding {
    /// The contact, such as `circle:5`.
    pub contact: Option<String>,
    /// Compression of a contact that grows with it, mm.
    pub compression: Option<f64>,
    /// Coefficient of friction.
    pub friction: Option<f64>,
    /// Exponent k of the pressure, or `inf`.
    pub exponent: Option<String>,
    /// Normal force, N per µε: one number, or four.
    pub normal: Option<String>,
    /// Tangential force that is always there, N.
    pub tangential: Option<f64>,
    /// Tangential force, N per µε.
    pub tangential_gauges: Option<String>,
    /// Moment that is always there, N mm.
    pub moment: Option<f64>,
    /// Moment, N mm per µε.
    pub moment_gauges: Option<String>,
    /// Something is held above this normal force, N.
    pub contact_above: Option<f64>,
    /// The strain over the next so many seconds is zero.
    pub rest: Option<f64>,
}

impl Holding {
    /// The margin from time to time.
    ///
    /// # Errors
    /// Says what is missing, or wrong.
    pub fn watch(&self) -> Result<Watch, String> {
        let (Some(contact), Some(friction), Some(normal)) =
            (&self.contact, self.friction, &self.normal)
        else {
            return Err(self.missing());
        };
        let body: Body = contact.parse().map_err(|error| words("contact", &error))?;
        let exponent = self.exponent.as_deref().unwrap_or("2");
        let exponent = exponent
            .parse()
            .map_err(|_| "exponent: give a number from 1 on, or inf".to_owned())
            .and_then(|k| PressureLaw::new(k).map_err(|error| error.to_string()))?;
        let shape = body.pressed(self.compression).map_err(|error| words("contact", &error))?;
        let contact = Contact::new(shape, exponent).map_err(|error| words("contact", &error))?;
        if !(friction > 0.0 && friction.is_finite()) {
            return Err("friction: give a number above 0".into());
        }
        let rest = self.rest.unwrap_or_default();
        if !(0.0..=REST_S).contains(&rest) {
            return Err(format!("rest: give 0 to {REST_S} s"));
        }
        let of = |name, gauges: &Option<String>, constant: Option<f64>| {
            let gauges = gauges.as_deref().map_or(Ok([0.0; GAUGES]), weights);
            let gauges = gauges.map_err(|error| words(name, &error))?;
            Ok::<_, String>(Weights { gauges, constant: constant.unwrap_or_default() })
        };
        let fingertip = Fingertip {
            contact,
            friction,
            normal: of("normal force per strain", &Some(normal.clone()), None)?,
            tangential: of(
                "tangential force per strain",
                &self.tangential_gauges,
                self.tangential,
            )?,
            moment: of("moment per strain", &self.moment_gauges, self.moment)?,
            threshold: self.contact_above.unwrap_or(0.05),
            zero: [0.0; GAUGES],
            elastic_zero: [0.0; GAUGES],
            growing: None,
            relaxation: None,
        };
        Ok(Watch::new(fingertip, rest, EVERY_S))
    }

    fn missing(&self) -> String {
        let needed = [
            (self.contact.is_none(), "the contact and its size"),
            (self.friction.is_none(), "the coefficient of friction"),
            (self.normal.is_none(), "the normal force per strain"),
        ];
        let missing: Vec<&str> = needed
            .into_iter()
            .filter_map(|(is_missing, name)| is_missing.then_some(name))
            .collect();
        format!("still missing: {}", missing.join(", "))
    }

    /// The options of the command.
    #[must_use]
    pub fn options(&self) -> String {
        let text = |value: &Option<String>| value.clone();
        let number = |value: Option<f64>| value.map(|value| value.to_string());
        let all = [
            ("contact", text(&self.contact)),
            ("compression", number(self.compression)),
            ("friction", number(self.friction)),
            ("exponent", text(&self.exponent)),
            ("normal", text(&self.normal)),
            ("tangential", number(self.tangential)),
            ("tangential-gauges", text(&self.tangential_gauges)),
            ("moment", number(self.moment)),
            ("moment-gauges", text(&self.moment_gauges)),
            ("contact-above", number(self.contact_above)),
            ("rest", number(self.rest)),
        ];
        // With `=`, a value that begins with a minus is one.
        all.into_iter().filter_map(|(name, value)| Some(format!(" --{name}={}", value?))).collect()
    }

    fn json(&self) -> Value {
        json!({
            "contact": self.contact,
            "compression": self.compression,
            "friction": self.friction,
            "exponent": self.exponent,
            "normal": self.normal,
            "tangential": self.tangential,
            "tangential_gauges": self.tangential_gauges,
            "moment": self.moment,
            "moment_gauges": self.moment_gauges,
            "contact_above": self.contact_above,
            "rest": self.rest,
        })
    }
}

fn words(name: &str, error: &impl ToString) -> String {
    format!("{name}: {}", error.to_string())
}

/// A grasp that is watched, or none.
#[derive(Default)]
pub(super) struct Grasp {
    watched: Option<(Holding, Watch)>,
    last_s: f64,
}

impl Grasp {
    /// Watches from now on.
    pub(super) fn watch(&mut self, holding: Option<&Holding>) -> Result<(), String> {
        let watched = holding.map(|holding| Ok((holding.clone(), holding.watch()?)));
        self.watched = watched.transpose().map_err(|error: String| error)?;
        Ok(())
    }

    /// How it is watched, as the page reads it.
    pub(super) fn json(&self) -> Value {
        self.watched.as_ref().map_or(Value::Null, |(holding, _)| holding.json())
    }

    /// Takes rows that end at a time of the session, s; `listener` hears the readings too.
    pub(super) fn take(
        &mut self,
        rows: &[Row],
        now_s: f64,
        readings: &mut Readings,
        mut listener: Option<&mut (dyn Listener + 'static)>,
    ) {
        let Some((_, watch)) = &mut self.watched else { return };
        let Some(end) = rows.last() else { return };
        for felt in rows.iter().filter_map(Felt::of) {
            if felt.time < self.last_s {
                watch.go_on();
            }
            self.last_s = felt.time;
            if let Some(reading) = watch.take(&felt) {
                if let Some(listener) = &mut listener {
                    listener.margin(&reading);
                }
                let mut json = answers::json(&GraspWatchAnswer::from(&reading));
                json["session_s"] = (now_s - (end.time_us as f64 * 1e-6 - felt.time)).into();
                readings.push(json);
            }
        }
        readings.resting = watch.is_resting();
    }
}

/// The last readings.
#[derive(Default)]
pub struct Readings {
    kept: VecDeque<Value>,
    taken: u64,
    resting: bool,
}

impl Readings {
    fn push(&mut self, reading: Value) {
        if self.kept.len() >= KEPT {
            self.kept.pop_front();
        }
        self.kept.push_back(reading);
        self.taken += 1;
    }

    /// Forgets all; their numbers go on.
    pub(super) fn clear(&mut self) {
        self.kept.clear();
        self.resting = false;
    }

    /// Number of the reading that comes next.
    #[must_use]
    pub const fn taken(&self) -> u64 {
        self.taken
    }

    /// Whether the zero is being taken.
    #[must_use]
    pub const fn is_resting(&self) -> bool {
        self.resting
    }

    /// The readings from a number on, those that are not forgotten.
    #[must_use]
    pub fn after(&self, from: u64) -> Vec<Value> {
        let first = self.taken - self.kept.len() as u64;
        let skip = from.saturating_sub(first).min(self.kept.len() as u64) as usize;
        self.kept.range(skip..).cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holding() -> Holding {
        Holding {
            contact: Some("circle:5".into()),
            friction: Some(0.7),
            normal: Some("0.001".into()),
            tangential: Some(0.4),
            ..Holding::default()
        }
    }

    #[test]
    fn what_is_missing_is_named() {
        let refused = Holding::default().watch().unwrap_err();
        assert!(
            refused.contains("contact")
                && refused.contains("friction")
                && refused.contains("normal")
        );
        let refused = Holding { friction: None, ..holding() }.watch().unwrap_err();
        assert_eq!(refused, "still missing: the coefficient of friction");
        assert!(holding().watch().is_ok());
    }

    #[test]
    fn what_is_wrong_is_named_as_by_the_command() {
        let wrong = |holding: Holding| holding.watch().unwrap_err();
        let contact = |text: &str| Holding { contact: Some(text.into()), ..holding() };
        assert!(wrong(contact("cone:3")).contains("`cone:3` is no contact"));
        assert!(wrong(contact("sphere:35")).contains("grows as it is pressed"));
        assert!(wrong(Holding { friction: Some(-1.0), ..holding() }).starts_with("friction"));
        assert!(wrong(Holding { exponent: Some("0.5".into()), ..holding() }).contains("1 or more"));
        assert!(
            wrong(Holding { normal: Some("1,2".into()), ..holding() }).starts_with("normal force")
        );
        assert!(wrong(Holding { rest: Some(1e9), ..holding() }).starts_with("rest"));
    }

    #[test]
    fn the_options_are_those_of_the_command() {
        let holding = Holding { tangential_gauges: Some("-1,0,0,1".into()), ..holding() };
        assert_eq!(
            holding.options(),
            " --contact=circle:5 --friction=0.7 --normal=0.001 --tangential=0.4 --tangential-gauges=-1,0,0,1"
        );
    }

    #[test]
    fn readings_are_numbered_and_old_ones_forgotten() {
        let mut readings = Readings::default();
        for number in 0..KEPT + 5 {
            readings.push(json!(number));
        }
        assert_eq!(readings.after(0).len(), KEPT);
        assert_eq!(readings.after(readings.taken() - 1), [json!(KEPT + 4)]);
        readings.clear();
        assert!(readings.after(0).is_empty() && readings.after(9_999).is_empty());
    }
}
