//! What is asked of the device itself: other settings, its test, its calibration.

use serde_json::{Value, json};
use shared::calibration::Sheet;
use shared::pipeline::GAUGES;
use shared::wire::ToDevice;

use super::feed::{Feed, Trouble, lock};
use super::wish::{Basis, Setting, change};
use palpate_link::device::answers::{CalibratedAnswer, SelfTestInFull, SettingsAnswer};
use palpate_link::device::calibrate::{Calibrated, from_one};
use palpate_link::device::change::rate_note;
use palpate_link::device::self_test;
use palpate_link::device::session::{LinkError, Session};
use palpate_present::answers;

impl Feed {
    /// Checks settings, sets them, and says what they are then.
    pub(super) fn set(
        &mut self,
        setting: &Setting,
        session: &mut Session,
    ) -> Result<Value, Trouble> {
        let change = change(setting).map_err(Trouble::Words)?;
        let (_, commands) = change
            .of(session.settings().1, session.identity())
            .map_err(|error| Trouble::Words(error.to_string()))?;
        let send = |session: &mut Session| {
            commands.iter().try_for_each(|command| session.command(command).map(drop))?;
            if setting.save {
                session.command(&ToDevice::Save)?;
            }
            Ok(())
        };
        // Filter and thresholds change between two samples; the rest needs a converter that rests.
        let rests =
            setting.save || setting.defaults || setting.rate_hz.is_some() || setting.gain.is_some();
        if rests {
            self.between_streams(session, send)?;
        } else {
            send(session)?;
        }
        // The settings have been heard before the status.
        session.command(&ToDevice::Settings)?;
        session.status()?;
        let now = session.settings().1;
        let note = setting.rate_hz.and_then(|wanted| rate_note(wanted, now));
        let words =
            if setting.save { "settings are set and saved" } else { "other settings from here on" };
        lock(&self.store).say(words);
        Ok(json!({
            "settings": SettingsAnswer::of(now),
            "note": note,
            "saved": setting.save,
        }))
    }

    /// The device tests itself.
    pub(super) fn test(&mut self, session: &mut Session) -> Result<Value, Trouble> {
        let tested = self.between_streams(session, self_test::run)?;
        let faults = self_test::faults(&tested).len();
        lock(&self.store).say(match faults {
            0 => "the self-test passed".to_owned(),
            _ => format!("the self-test found {faults} faults"),
        });
        Ok(answers::json(&SelfTestInFull::of(&tested, session.settings().1)))
    }

    /// Sets and saves a calibration.
    pub(super) fn calibrate(
        &mut self,
        basis: &Basis,
        session: &mut Session,
    ) -> Result<Value, Trouble> {
        let (calibrated, told) = calibration(basis, &session.settings().1.calibration)?;
        self.between_streams(session, |session| {
            for &Calibrated { gauge, sheet, .. } in &calibrated {
                session.command(&ToDevice::SetCalibration { gauge, sheet })?;
            }
            session.command(&ToDevice::Save)
        })?;
        lock(&self.store).say("the calibration is set and saved");
        Ok(told)
    }

    /// Does what the device refuses while it streams; a stream that is wanted goes on afterwards.
    fn between_streams<T>(
        &mut self,
        session: &mut Session,
        what: impl FnOnce(&mut Session) -> Result<T, LinkError>,
    ) -> Result<T, Trouble> {
        if let Some((file, _)) = &self.recorder {
            return Err(Trouble::Words(format!(
                "{file} is being recorded, and the stream would be interrupted; end the recording first"
            )));
        }
        self.counts.end("the stream was interrupted; read again");
        session.quiet()?;
        let done = what(session);
        let is_there = matches!(done, Ok(_) | Err(LinkError::Refused(_) | LinkError::Unsuited(_)));
        if self.wanted && is_there {
            self.begin(session)?;
        }
        Ok(done?)
    }
}

/// What calibration follows, and how the page reads it.
pub(super) fn calibration(
    basis: &Basis,
    before: &[Sheet; GAUGES],
) -> Result<(Vec<Calibrated>, Value), Trouble> {
    let words =
        |error: palpate_link::device::calibrate::SheetError| Trouble::Words(error.to_string());
    if let Basis::Numbers { gauge, gain, offset } = *basis {
        let gauge = from_one(gauge).map_err(Trouble::Words)?;
        let made = Calibrated::by_numbers(gauge, gain, offset, &before[usize::from(gauge)]);
        let made = made.map_err(words)?;
        return Ok((vec![made], json!({ "gauges": [CalibratedAnswer::from(&made)] })));
    }
    let mut all = Vec::new();
    let mut told = Vec::new();
    for (gauge, points) in basis.points().map_err(Trouble::Words)? {
        let sheet = &before[usize::from(gauge)];
        let made = Calibrated::by_points(gauge, &points, sheet).map_err(words)?;
        let mut json = answers::json(&CalibratedAnswer::from(&made));
        json["before"] = json!({ "ustrain_per_count": sheet.gain, "offset_counts": sheet.offset });
        json["points"] = points
            .iter()
            .map(|point| {
                json!({
                    "strain_ustrain": point.strain,
                    "counts": point.counts,
                    "residual_ustrain": made.line.map(|line| line.residual(point)),
                })
            })
            .collect();
        all.push(made);
        told.push(json);
    }
    Ok((all, json!({ "gauges": told })))
}
