//! The errors of an encoder that repeat with its reading.

use super::outcome::{Head, quantity};
use super::{AxisData, Piece, explain, lacking_two, page};
use crate::firmware::{Firmware, encoder_map};
use crate::outcome::{Job, Outcome, section};
use crate::record::Record;
use crate::stored_result::read_section;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Error, Watch};
use proofmass_documents::StatedQuantity;
use proofmass_io::{Input, LARGEST_DOCUMENT, Source};
use proofmass_motion::{EncoderMap, FoundMap, MapSearch, Pairing};
use proofmass_report::Report;
use proofmass_uncertainty::{Finding, Severity};
use serde::{Deserialize, Serialize};

/// Eccentricity, gears and their like, found with the accelerometer's help.
///
/// ```
/// use proofmass_jobs::{Job, Outcome, Unwatched, velocity::{AxisData, VelocityMapJob}};
/// use proofmass_motion::{MotionRecord, ReadingSource};
/// use proofmass_rig::{AxisMotion, DrivenAxis};
///
/// // A wheel of 2 cm rolls ±0.2 m with an eccentric disc: 0.02 rad are 0.4 mm.
/// let mut axis = DrivenAxis::new(AxisMotion::DampedOscillation { amplitude: 0.2, frequency: 0.7, damping: 0.01 });
/// axis.encoder.radius = 0.02;
/// axis.encoder.eccentricity = 0.02;
/// let recording = axis.simulate(1)?;
/// let (x, a) = (recording.position(), recording.acceleration.clone());
/// let mut record = MotionRecord::new(recording.sample_time, ReadingSource::Position, x, a)?;
/// record.increment = Some(recording.increment);
/// let job = VelocityMapJob::new(std::f64::consts::TAU * 0.02);
/// let outcome = job.evaluate(&AxisData::new(&record), &Unwatched)?;
/// let amplitude = &outcome.quantities()[0];
/// assert_eq!(amplitude.name, "amplitude.1");
/// assert!((amplitude.value - 4e-4).abs() < 1.5 * amplitude.expanded, "{amplitude:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct VelocityMapJob {
    /// What is looked for. The turn is in the unit of the readings.
    pub search: MapSearch,
}

impl VelocityMapJob {
    /// The first four orders of a turn, in m or rad.
    pub fn new(turn: f64) -> Self {
        let mut job = Self::default();
        job.search.turn = turn;
        job
    }
}

impl Job for VelocityMapJob {
    type Data<'a> = AxisData<'a>;
    type Outcome = VelocityMap;

    fn evaluate(&self, data: &AxisData<'_>, watch: &dyn Watch) -> Result<VelocityMap> {
        let piece = Piece::of(data);
        let data = &piece.as_ref().map_or(*data, |piece| piece.data(data));
        lacking_two(data, "a map is found with both sensors")?;
        if self.search.quarters && data.record.increment.is_none() {
            return Err(Trouble::request(
                "unequal quarters are those of counted lines, and no counts are read",
            )
            .with_hint(
                "give --counts-per-turn N or --counts-per-metre N, or leave out --quarters",
            ));
        }
        let rate = self.search.false_alarm_rate;
        if !(rate > 0.0 && rate < 1.0) {
            return Err(Trouble::request(format!(
                "a false-alarm rate of {rate} is no probability"
            ))
            .with_hint("it lies between 0 and 1"));
        }
        let found = self.search.run(data.record, watch);
        let found = found.map_err(|e| {
            let singular = matches!(e, Error::Singular { .. });
            let trouble = explain(e, data.name);
            match against(data).filter(|_| singular) {
                Some(doubt) => trouble.with_hint(doubt),
                None => trouble,
            }
        })?;
        Ok(VelocityMap::new(data, self.search.clone(), found))
    }
}

/// What speaks against both sensors together, and what to do: without one motion in both no lines are told.
fn against(data: &AxisData<'_>) -> Option<String> {
    let pairing = Pairing::of(data.record).ok();
    let beside = pairing.iter().flat_map(|p| &p.findings);
    let mut all = data.findings.iter().chain(beside);
    let decision = all.find(|f| f.severity() == Severity::Decision)?;
    Some(format!("{}: {}", decision.what(), decision.advice_text()))
}

/// The map of an encoder.
#[derive(Clone, Debug, PartialEq)]
pub struct VelocityMap {
    pub(super) head: Head,
    search: MapSearch,
    pub(super) found: FoundMap,
}

impl VelocityMap {
    fn new(data: &AxisData<'_>, search: MapSearch, found: FoundMap) -> Self {
        let quantities = found.map.lines.iter().map(|line| {
            quantity(
                &format!("amplitude.{}", line.order),
                "m",
                line.amplitude(),
                line.amplitude_uncertainty(),
            )
        });
        Self {
            head: Head::new(data, quantities.collect(), &found.findings),
            search,
            found,
        }
    }

    /// The search's answer.
    pub fn found(&self) -> &FoundMap {
        &self.found
    }

    /// The map from a result.json.
    ///
    /// # Errors
    /// Another file; a map of angles where lengths are read, or the other way round.
    pub(super) fn read(source: Source, angular: bool) -> Result<(EncoderMap, Input)> {
        let name = source.name().display().to_string();
        let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
        let stored = StoredMap::read(&bytes).map_err(|e| {
            e.detail(name.clone())
                .with_hint("an encoder map is the result.json of `proofmass velocity map`")
        })?;
        if stored.angular != angular {
            let unit = |angular| if angular { "rad" } else { "m" };
            return Err(Trouble::data(format!(
                "{name}: the map is in {}, the readings are in {}",
                unit(stored.angular),
                unit(angular)
            ))
            .with_hint("read both with --angular, or both with the same --radius"));
        }
        Ok((stored.map, input))
    }
}

/// What another job and firmware need of a map.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct StoredMap {
    angular: bool,
    #[serde(flatten)]
    map: EncoderMap,
}

impl StoredMap {
    const SECTION: &'static str = "encoder_map";

    pub(crate) fn read(bytes: &[u8]) -> Result<Self> {
        let stored: Self = read_section(bytes, VelocityMap::KIND, Self::SECTION)?.0;
        stored.map.check()?;
        Ok(stored)
    }

    pub(crate) fn firmware(&self) -> Firmware {
        encoder_map(&self.map, self.angular)
    }
}

impl Outcome for VelocityMap {
    const KIND: &'static str = "velocity-map";

    fn title(&self, record: &Record) -> String {
        self.head.title("Encoder map", record)
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.head.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.head.findings
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![
            self.head.section()?,
            section("search", &self.search)?,
            section(
                StoredMap::SECTION,
                &StoredMap {
                    angular: self.head.angular,
                    map: self.found.map.clone(),
                },
            )?,
        ])
    }

    fn page(&self, page: Report) -> Report {
        page::map(page, self)
    }
}
