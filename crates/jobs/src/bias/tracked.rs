//! The bias over a recording, read again to be subtracted.

use super::{BiasOutcome, OnChip};
use crate::outcome::Outcome;
use crate::stored_result::{StoredResult, read_section};
use crate::trouble::{Result, Trouble};
use proofmass_documents::{AnyCalibration, Device};
use proofmass_io::{Input, LARGEST_DOCUMENT, Source};
use std::path::Path;

/// Smoothed bias of three axes over time: what `proofmass bias` filed.
///
/// Between its times the bias is on the straight line, which is the conditional mean of a random walk. Its variance there is at most that
/// of the nearer ends plus Q Δ/4 of the walk between them.
///
/// **Units** s, m/s². Times count as those of the recording do that it was tracked over.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackedBias {
    name: String,
    device: Device,
    time: Vec<f64>,
    /// Bias and standard uncertainty of x, y, z.
    axes: [Vec<(f64, f64)>; 3],
    /// Density of the walk of x, y, z, (m/s²)²/s.
    walk: [f64; 3],
    /// Time between samples of its recording, s.
    period: f64,
}

impl TrackedBias {
    /// Reads a result.json of `proofmass bias`.
    ///
    /// # Errors
    /// Another kind of file or result (a calibration is named as such), a damaged one.
    pub fn read(source: Source) -> Result<(Self, Input)> {
        let name = source.name().to_path_buf();
        let shown = name.display().to_string();
        let (bytes, input) = source.into_bytes(LARGEST_DOCUMENT)?;
        let hint = "name the result.json of `proofmass bias`";
        if AnyCalibration::from_json(&bytes).is_ok() {
            return Err(Trouble::data("is a calibration, and no bias over time")
                .detail(shown)
                .with_hint(format!(
                    "a chain has one calibration, which stands first; {hint} here"
                )));
        }
        let known = proofmass_documents::is_result(&bytes);
        let document = known.then(|| proofmass_documents::ResultDocument::from_json(&bytes));
        match document {
            Some(Ok(document)) if document.kind != BiasOutcome::KIND => {
                return Err(Trouble::data(format!(
                    "is a result of kind `{}`, which holds no bias over time",
                    document.kind
                ))
                .detail(shown)
                .with_hint(hint));
            }
            None => {
                return Err(Trouble::data("is no result of `proofmass bias`")
                    .detail(shown)
                    .with_hint(hint));
            }
            _ => {}
        }
        let read = Self::of(&bytes, &name).map_err(|e| e.detail(shown))?;
        Ok((read, input))
    }

    fn of(bytes: &[u8], place: &Path) -> Result<Self> {
        let (filter, document) = read_section::<OnChip>(bytes, BiasOutcome::KIND, OnChip::SECTION)?;
        let table = StoredResult::from_json(bytes)?.table("bias.csv")?;
        let damaged = || {
            Trouble::data("the table of the bias over time is damaged")
                .with_hint("track the bias again with `proofmass bias`")
        };
        let table = String::from_utf8(table).map_err(|_| damaged())?;
        let mut lines = table.lines();
        let names: Vec<&str> = lines.next().unwrap_or("").split(',').collect();
        let index = |name: &str| names.iter().position(|n| *n == name).ok_or_else(damaged);
        let mut places = vec![index("time_s")?];
        for axis in ["x", "y", "z"] {
            places.push(index(&format!("smoothed_{axis}_m/s2"))?);
            places.push(index(&format!("u_smoothed_{axis}_m/s2"))?);
        }
        let mut read = Self {
            name: place.display().to_string(),
            device: document.device,
            time: Vec::new(),
            axes: Default::default(),
            walk: filter.walk(),
            period: filter.period(),
        };
        for line in lines {
            let cells: Vec<&str> = line.split(',').collect();
            let mut numbers = [0.0; 7];
            for (number, place) in numbers.iter_mut().zip(&places) {
                let cell = cells.get(*place).and_then(|c| c.parse::<f64>().ok());
                *number = cell.filter(|v| v.is_finite()).ok_or_else(damaged)?;
            }
            let [time, x, ux, y, uy, z, uz] = numbers;
            if read.time.last().is_some_and(|last| *last > time) {
                return Err(damaged());
            }
            read.time.push(time);
            for (axis, pair) in read.axes.iter_mut().zip([(x, ux), (y, uy), (z, uz)]) {
                axis.push(pair);
            }
        }
        match (read.time.is_empty(), read.period > 0.0) {
            (false, true) => Ok(read),
            _ => Err(damaged()),
        }
    }

    /// What it is called in messages.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// First and last time, s.
    pub fn span(&self) -> [f64; 2] {
        let at = |t: Option<&f64>| t.copied().unwrap_or(f64::NAN);
        [at(self.time.first()), at(self.time.last())]
    }

    /// Refuses a calibration of another device, or of other axes than three.
    pub(crate) fn belongs_to(&self, calibration: &AnyCalibration, axes: usize) -> Result<()> {
        if axes != 3 {
            return Err(Trouble::request(format!(
                "the bias is of three axes, the calibration of {}",
                if axes == 1 {
                    "one".to_owned()
                } else {
                    axes.to_string()
                }
            ))
            .detail(self.name.clone())
            .with_hint(
                "of one axis `proofmass test sensitivity` gives the bias with the calibration",
            ));
        }
        match (&self.device.serial, &calibration.device().serial) {
            (Some(of_bias), Some(of_calibration)) if of_bias != of_calibration => {
                Err(Trouble::request(format!(
                    "the bias is of the device with serial number {of_bias}, the calibration of {of_calibration}"
                ))
                .detail(self.name.clone())
                .with_hint("name the bias and the calibration of one device"))
            }
            _ => Ok(()),
        }
    }

    /// Bias of x, y, z at a time with a bound of its standard uncertainty; `None` beyond the track by more than a sample.
    ///
    /// `near` is where it was found the last time: times that increase are found without a search.
    pub(crate) fn at(&self, time: f64, near: &mut usize) -> Option<[(f64, f64); 3]> {
        let [first, last] = self.span();
        if !(time >= first - self.period && time <= last + self.period) {
            return None;
        }
        let held = time.clamp(first, last);
        let n = self.time.len();
        if self.time.get(*near).is_none_or(|t| *t > held) {
            *near = self.time.partition_point(|t| *t <= held).max(1) - 1;
        }
        while *near + 2 < n && self.time[*near + 1] <= held {
            *near += 1;
        }
        let (from, to) = (*near, (*near + 1).min(n - 1));
        let length = self.time[to] - self.time[from];
        let share = match length > 0.0 {
            true => ((held - self.time[from]) / length).clamp(0.0, 1.0),
            false => 0.0,
        };
        Some(std::array::from_fn(|axis| {
            let ((b0, u0), (b1, u1)) = (self.axes[axis][from], self.axes[axis][to]);
            let between = self.walk[axis] * length * share * (1.0 - share);
            let u = (u0.max(u1).powi(2) + between).sqrt();
            (b0 + share * (b1 - b0), u)
        }))
    }
}
