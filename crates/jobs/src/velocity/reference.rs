//! A reference velocity, where one was recorded.

use super::reading::Samples;
use super::sensors::{AxisRecordings, stated_unit, unknown_unit};
use crate::findings;
use crate::trouble::Trouble;
use proofmass_io::{Recording, SaidBy, Unit};
use proofmass_motion::OnLines;

/// A reference velocity: its column, and its file where it has one of its own.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[non_exhaustive]
pub struct Reference {
    /// Column of a reference velocity, from a better instrument or a simulation
    #[cfg_attr(
        feature = "clap",
        arg(
            id = "reference",
            long = "reference",
            required = false,
            value_name = "COLUMN"
        )
    )]
    pub column: String,
    /// Unit of the reference, where the heading does not say it: m/s, km/h, mm/s, …
    #[cfg_attr(
        feature = "clap",
        arg(
            id = "reference_unit",
            long = "reference-unit",
            value_name = "UNIT",
            requires = "reference"
        )
    )]
    pub unit: Option<Unit>,
    /// File of the reference, when it has its own; its clock must be that of the recording
    #[cfg_attr(
        feature = "clap",
        arg(
            id = "reference_file",
            long = "reference-file",
            value_name = "FILE",
            value_hint = clap::ValueHint::FilePath,
            requires = "reference"
        )
    )]
    pub file: Option<String>,
    /// Time column of that file, where no heading names it
    #[cfg_attr(
        feature = "clap",
        arg(
            id = "reference_time",
            long = "reference-time",
            value_name = "COLUMN",
            requires = "reference_file"
        )
    )]
    pub time: Option<String>,
    /// Sampling rate of that file in hertz, when it has no time column
    #[cfg_attr(
        feature = "clap",
        arg(
            id = "reference_rate",
            long = "reference-rate",
            value_name = "HZ",
            requires = "reference_file"
        )
    )]
    pub rate: Option<f64>,
    /// Time by which the reference is late, s; it is shifted back by it
    #[cfg_attr(
        feature = "clap",
        arg(
            id = "reference_latency",
            long = "reference-latency",
            value_name = "SECONDS",
            default_value_t = 0.0,
            requires = "reference",
            allow_negative_numbers = true
        )
    )]
    pub latency: f64,
}

impl Reference {
    /// States the unit of its column, where the heading does not say it.
    pub(super) fn state_unit(
        &self,
        recording: &mut Recording,
        column: usize,
    ) -> Result<(), Trouble> {
        let own = &recording.columns[column];
        let unit = stated_unit(recording, own, (self.unit, "--reference-unit"))?;
        Ok(recording.state_unit(column, unit, SaidBy::Person)?)
    }

    /// The reference in m/s, or rad/s, with its times.
    pub(super) fn samples(
        &self,
        recording: &Recording,
        clock: &[f64],
        column: usize,
        angular: bool,
    ) -> Result<Samples, Trouble> {
        let missing = recording.missing(column);
        let column = &recording.columns[column];
        let name = &column.name;
        let unit = column
            .unit
            .ok_or_else(|| unknown_unit(recording, column, "add --reference-unit m/s, km/h, …"))?;
        let (si, factor) = unit.si();
        let due = if angular {
            Unit::RadianPerSecond
        } else {
            Unit::MetrePerSecond
        };
        if si != due {
            return Err(Trouble::data(format!(
                "column {name:?} is in {unit}, the velocity in {due}"
            )));
        }
        let value: Vec<f64> = column.data.iter().map(|v| factor * v).collect();
        if !self.latency.is_finite() {
            return Err(Trouble::data("--reference-latency must be a finite number"));
        }
        let clock: Vec<f64> = clock.iter().map(|t| t - self.latency).collect();
        Ok(Samples::present(&clock, &value, &[missing]))
    }

    /// Puts the reference at every sample of the record, on straight lines between its own, and cuts off what it
    /// does not cover.
    pub(super) fn attach(
        &self,
        bench: &mut AxisRecordings,
        reference: &Samples,
    ) -> Result<(), Trouble> {
        let dt = bench.record.sample_time;
        let n = bench.record.reading.len();
        let time = |k: usize| bench.start + dt * k as f64;
        let (Some(first), Some(last)) = (reference.time.first(), reference.time.last()) else {
            return Err(Trouble::data("the reference holds no value"));
        };
        if reference.time.len() < 2 {
            return Err(Trouble::data("the reference holds a single value"));
        }
        let Some(found) = reference.on_lines(bench.start, dt, n) else {
            return Err(Trouble::data(
                "the reference and the sensors have no interval of time in common",
            )
            .detail(format!(
                "reference {first:.3} s to {last:.3} s, sensors {:.3} s to {:.3} s",
                time(0),
                time(n - 1)
            ))
            .with_hint("both clocks must share their zero"));
        };
        let OnLines {
            used,
            value,
            step,
            bridged,
            ..
        } = found;
        let (from, to) = (used.start, used.end);
        if bridged > 0 {
            bench
                .findings
                .push(proofmass_uncertainty::findings::gaps_in_record(
                    " in the reference, and are bridged by straight lines",
                    &format!("{bridged} of {} samples", to - from),
                    "leave them out with --between FROM,TO",
                ));
        }
        if step > 1.5 * dt {
            bench
                .findings
                .push(findings::slow_reference(1.0 / step, 1.0 / dt));
        }
        if to - from < n {
            bench
                .findings
                .push(findings::cut_to_reference(to - from, n));
            let record = &mut bench.record;
            record.reading = record.reading[from..to].to_vec();
            record.acceleration = record.acceleration[from..to].to_vec();
            let holes = record.holes.iter();
            record.holes = holes.filter_map(|h| h.within(&(from..to))).collect();
            if from > 0 && record.initial_velocity.is_some() {
                return Err(Trouble::request(format!(
                    "the velocity at the first sample is stated, and the reference begins {} s later",
                    from as f64 * dt
                ))
                .with_hint("leave --initial-velocity or --at-rest out, or begin with the reference by --between FROM TO"));
            }
            bench.start += from as f64 * dt;
            record.check()?;
        }
        bench.reference = Some(value);
        Ok(())
    }
}
