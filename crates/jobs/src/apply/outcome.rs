//! What became of a compensated recording.

use super::steps::Steps;
use super::{ApplyJob, ChainFigures, CompensationMethod, CompensationStream, page};
use crate::findings;
use crate::outcome::{Outcome, section};
use crate::plural::count_lying;
use crate::record::Record;
use crate::trouble::Result;
use crate::value_range::widened;
use proofmass_documents::{AnyCalibration, CalibrationFile, StatedQuantity, ThermalBlock};
use proofmass_dynamic::frequency_response::{BandMatrix, CompensationError};
use proofmass_io::{Input, rows_outside};
use proofmass_report::{Report, scientific};
use proofmass_uncertainty::findings::gaps_in_record;
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Quantity, Severity};

/// Counts while the rows go by.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Figures {
    pub(super) read: u64,
    pub(super) written: u64,
    pub(super) gaps: u64,
    /// Samples that came out of the calibration.
    pub(super) compensated: u64,
    pub(super) beyond: u64,
    /// Temperatures, where the calibration follows them.
    pub(super) temperatures: Course,
    /// Each other quantity of the surroundings that it follows.
    pub(super) environment: Vec<Course>,
    /// Smallest and largest acceleration of each axis.
    pub(super) accelerations: Vec<Option<[f64; 2]>>,
}

/// How a quantity that the calibration follows went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Course {
    /// Samples beyond the range in which its coefficients were measured.
    beyond: u64,
    /// Lowest and highest of all.
    range: Option<[f64; 2]>,
}

impl Course {
    /// Counts values beyond a range; the first of these that is.
    fn count(&mut self, values: &[f64], range: [f64; 2]) -> Option<usize> {
        self.range = widened(self.range, values.iter().copied());
        let (first, beyond) = rows_outside(&[values], range);
        self.beyond += beyond;
        first
    }

    /// That some lie beyond, with what they are in words.
    fn finding(
        &self,
        range: [f64; 2],
        unit: &str,
        words: impl FnOnce([f64; 2]) -> String,
    ) -> Option<Finding> {
        let found = self.range.filter(|_| self.beyond > 0)?;
        let finding = findings::beyond_calibrated_range(
            &count_lying(self.beyond as usize, "sample"),
            range[0],
            range[1],
            unit,
            "they are compensated as at the nearer end of that range",
            &words(found),
        );
        Some(finding.at(Severity::Warning))
    }
}

impl Figures {
    /// Counts temperatures beyond those of the coefficients; the first of these that is.
    pub(super) fn temperatures(
        &mut self,
        file: &CalibrationFile,
        temperatures: &[f64],
    ) -> Option<usize> {
        let block = file.temperature.as_ref()?;
        self.temperatures.count(temperatures, block.range)
    }

    /// The same of other quantities of the surroundings, with the name of the quantity.
    pub(super) fn environment<'a>(
        &mut self,
        file: &'a CalibrationFile,
        values: &[Vec<f64>],
    ) -> Option<(usize, &'a str)> {
        self.environment
            .resize(file.environment.len(), Course::default());
        let blocks = file.environment.iter().zip(values);
        let mut first = None;
        for ((block, column), course) in blocks.zip(&mut self.environment) {
            let row = course.count(column, block.range);
            first = first.or(row.map(|row| (row, block.name.as_str())));
        }
        first
    }

    /// Counts accelerations beyond the tested range; a tenth more than that of a resting sensor is still at rest.
    ///
    /// The first of these rows that has one.
    pub(super) fn count(
        &mut self,
        calibration: &AnyCalibration,
        values: &[&[f64]],
    ) -> Option<usize> {
        self.compensated += values.first().map_or(0, |v| v.len() as u64);
        self.accelerations.resize(values.len(), None);
        for (range, column) in self.accelerations.iter_mut().zip(values) {
            *range = widened(*range, column.iter().copied());
        }
        let [low, high] = range(calibration)?;
        let margin = 0.1 * (high - low);
        let (first, beyond) = rows_outside(values, [low - margin, high + margin]);
        self.beyond += beyond;
        first
    }
}

/// Of each axis the acceleration that the calibration knows least, among those that the recording reaches: at the ends of its ranges, or at zero.
fn least_known(figures: &Figures, calibration: &AnyCalibration) -> Vec<Quantity> {
    let AnyCalibration::Constant(file) = calibration else {
        return Vec::new();
    };
    let places = |range: &Option<[f64; 2]>| {
        range.map(|[low, high]| vec![low, high, 0.0f64.clamp(low, high)])
    };
    let Some(places) = figures.accelerations.iter().map(places).collect() else {
        return Vec::new();
    };
    let temperatures = match figures.temperatures.range {
        None => vec![None],
        Some([low, high]) => vec![Some(low), Some(high)],
    };
    let ranges = figures.environment.iter().filter_map(|c| c.range);
    // The corners of what was recorded: the variance is largest at one of them.
    let around = corners(ranges.map(|range| range.to_vec()).collect());
    let u = |q: &Quantity| q.standard_uncertainty;
    let mut least: Vec<Quantity> = Vec::new();
    for a in corners(places) {
        for t in &temperatures {
            for e in &around {
                let known = file.accelerations(&a, *t, e);
                // Where one corner is not known, none is the least.
                let Some(known) = known.filter(|k| k.iter().all(|q| u(q).is_finite())) else {
                    return Vec::new();
                };
                if least.is_empty() {
                    least = known;
                    continue;
                }
                for (least, known) in least.iter_mut().zip(known) {
                    if u(&known) > u(least) {
                        *least = known;
                    }
                }
            }
        }
    }
    least
}

/// Every choice of one place of each.
fn corners(places: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    places.iter().fold(vec![Vec::new()], |corners, places| {
        let wider = |corner: &Vec<f64>| {
            let corner = corner.clone();
            places
                .iter()
                .map(move |place| [corner.as_slice(), &[*place]].concat())
        };
        corners.iter().flat_map(wider).collect()
    })
}

fn range(calibration: &AnyCalibration) -> Option<[f64; 2]> {
    match calibration {
        AnyCalibration::Constant(file) => file.acceleration_range,
        _ => None,
    }
}

pub(super) fn findings(
    figures: &Figures,
    compensation: Option<&CompensationStream>,
    calibration: &AnyCalibration,
    steps: Option<&Steps<'_>>,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    if let Some(steps) = steps {
        findings.extend(steps.finding.clone());
        if let (Some([before, behind]), true) = (steps.left_out(), figures.gaps > 0) {
            findings.push(
                gaps_in_record(
                    "; the low-pass begins anew behind each gap",
                    &format!(
                        "{} gaps, {before} samples without a result behind each and {behind} before it",
                        figures.gaps
                    ),
                    "a low-pass with a higher corner loses less at each",
                )
                .at(Severity::Note),
            );
        }
    }
    if let (true, Some([low, high])) = (figures.beyond > 0, range(calibration)) {
        findings.push(findings::beyond_calibrated_range(
            &count_lying(figures.beyond as usize, "sample"),
            low,
            high,
            "m/s²",
            "the model is extrapolated there",
            &format!("of {} samples", figures.compensated),
        ));
    }
    if let AnyCalibration::Constant(file) = calibration {
        let read = figures.read;
        findings.extend(file.temperature.as_ref().and_then(|block| {
            let words =
                |[low, high]: [f64; 2]| format!("{low:.1} to {high:.1} °C in {read} samples");
            figures.temperatures.finding(block.range, "°C", words)
        }));
        for (block, course) in file.environment.iter().zip(&figures.environment) {
            let unit = &block.unit;
            findings.extend(course.finding(block.range, unit, |range| {
                let [low, high] = range.map(|v| scientific(v, 5));
                format!(
                    "{} from {low} to {high} {unit} in {read} samples",
                    block.name
                )
            }));
        }
    }
    let Some(compensation) = compensation else {
        return findings;
    };
    if let Some(filter) = compensation.filter() {
        if !filter.within_tolerance {
            findings.push(findings::filter_too_short(
                2 * filter.half + 1,
                100.0 * filter.error.departure,
            ));
        }
        if figures.gaps > 0 {
            findings.push(
                gaps_in_record(
                    "; the filter begins anew behind each gap",
                    &format!(
                        "{} gaps, {} samples without a result on either side of each",
                        figures.gaps, filter.half
                    ),
                    "a shorter filter loses less at each",
                )
                .at(Severity::Note),
            );
        }
    }
    if let Some(error) = compensation.error()
        && error.interpolation.is_none()
    {
        findings.push(findings::interpolation_unknown());
    }
    findings
}

/// A filter, but for its taps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FilterFigures {
    /// Sampling rate, Hz.
    pub(crate) rate: f64,
    /// Length of its impulse response, samples.
    pub(crate) length: usize,
    /// Samples without a result at the beginning and at the end of every stretch.
    pub half: usize,
}

/// Counts, digest and stated error of a compensated recording.
#[derive(Clone, Debug, PartialEq)]
pub struct ApplyOutcome {
    method: CompensationMethod,
    read: u64,
    written: u64,
    gaps: u64,
    beyond: u64,
    columns: Vec<String>,
    recording: Input,
    sha256: Option<String>,
    band: Option<BandMatrix>,
    filter: Option<FilterFigures>,
    error: Option<CompensationError>,
    /// The least known acceleration of each axis, by the covariance of the calibration.
    least_known: Vec<Quantity>,
    /// Whether the acceleration is turned to another frame behind the calibration.
    turned: bool,
    /// Whether the calibration follows the temperature in its bias alone.
    scale_at_one_temperature: bool,
    /// What followed the calibration.
    chain: Option<ChainFigures>,
    findings: Vec<Finding>,
}

impl ApplyOutcome {
    pub(super) fn new(
        job: &ApplyJob,
        (compensation, calibration): (Option<&CompensationStream>, &AnyCalibration),
        chain: Option<ChainFigures>,
        figures: Figures,
        columns: Vec<String>,
        (recording, sha256): (Input, Option<String>),
        mut findings: Vec<Finding>,
    ) -> Self {
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        Self {
            method: job.method,
            read: figures.read,
            written: figures.written,
            gaps: figures.gaps,
            beyond: figures.beyond,
            columns,
            recording,
            sha256,
            band: compensation.and_then(|c| c.band().cloned()),
            filter: compensation
                .and_then(CompensationStream::filter)
                .map(|f| FilterFigures {
                    rate: f.rate,
                    length: 2 * f.half + 1,
                    half: f.half,
                }),
            error: compensation.and_then(CompensationStream::error),
            least_known: least_known(&figures, calibration),
            turned: job.chain.rotation.is_some(),
            scale_at_one_temperature: match calibration {
                AnyCalibration::Constant(file) => {
                    let zero = |b: &ThermalBlock| b.scale.iter().flatten().all(|s| *s == 0.0);
                    file.temperature.as_ref().is_some_and(zero)
                }
                _ => false,
            },
            chain,
            findings,
        }
    }

    /// What followed the calibration, step by step; `None` where nothing did.
    pub fn chain(&self) -> Option<&ChainFigures> {
        self.chain.as_ref()
    }

    /// Rows written.
    pub fn rows(&self) -> u64 {
        self.written
    }

    /// Rows of the recording that are not among them.
    pub(super) fn left_out(&self) -> u64 {
        self.read - self.written
    }

    /// The constant matrix of a band, where it is one.
    pub(super) fn band(&self) -> Option<&BandMatrix> {
        self.band.as_ref()
    }

    /// Samples beyond the tested range.
    pub fn beyond(&self) -> u64 {
        self.beyond
    }

    /// Headings of the compensated columns.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The recording with its digest.
    pub fn recording(&self) -> &Input {
        &self.recording
    }

    /// SHA-256 of what was written, where a file of it stays.
    pub fn sha256(&self) -> Option<&str> {
        self.sha256.as_deref()
    }

    /// What the compensation states about itself, where it is one over frequency.
    pub fn error(&self) -> Option<&CompensationError> {
        self.error.as_ref()
    }

    /// The stated error in one line: of a compensation over frequency, or of each axis by the covariance of its calibration.
    pub fn statement(&self) -> Option<String> {
        if !self.least_known.is_empty() {
            let told = match self.scale_at_one_temperature {
                true => {
                    "; how the scale follows the temperature was not measured, and is not in it"
                }
                false => "",
            };
            let most = match self.least_known.as_slice() {
                [one] => format!("at {:.3} m/s²", one.value),
                _ if self.turned => {
                    "of x, y and z of the sensor, before they are turned".to_owned()
                }
                _ => "of x, y and z over the accelerations of the recording".to_owned(),
            };
            let of = |q: &Quantity| format!("{:.3e}", q.expanded(0.95));
            let expanded: Vec<String> = self.least_known.iter().map(of).collect();
            return Some(format!(
                "uncertainty by the calibration: at most {} m/s² with 95 % probability, {most}{told}",
                expanded.join(", ")
            ));
        }
        let error = self.error.as_ref()?;
        let [low, high] = error.band;
        let delay = match &self.filter {
            Some(_) => "the delay of sensor and filter is taken out".to_owned(),
            None => format!(
                "after a delay of {:.1} µs; {:.3} % where that is not taken into account",
                1e6 * error.delay,
                100.0 * error.stated_with_delay
            ),
        };
        Some(format!(
            "stated error: {:.3} % of the acceleration at any frequency from {low} Hz to {high} Hz with 95 % \
             probability, {delay}",
            100.0 * error.stated
        ))
    }

    /// The constant matrix that was applied, in one line, where it was one.
    pub fn matrix(&self) -> Option<String> {
        self.band.as_ref().map(matrix_applied)
    }

    /// The filter, where it was one.
    pub fn filter(&self) -> Option<&FilterFigures> {
        self.filter.as_ref()
    }
}

/// The matrix of a band with what it is.
pub(super) fn matrix_applied(matrix: &BandMatrix) -> String {
    let [low, high] = matrix.error.band;
    format!(
        "acceleration = M⁻¹ output, constant from {low} Hz to {high} Hz, M⁻¹ = {}",
        matrix.inverse_line()
    )
}

impl Outcome for ApplyOutcome {
    const KIND: &'static str = "apply";

    fn title(&self, record: &Record) -> String {
        record.title("Compensated recording of", "Compensated recording")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        // A relative error that is zero as far as anyone knows, and within the stated one.
        let statement = |name: &str, unit: &str, value: f64, expanded: f64| StatedQuantity {
            name: name.to_owned(),
            unit: unit.to_owned(),
            value,
            u: None,
            expanded,
            k: None,
            nu_eff: None,
            probability: 0.95,
            interval: None,
            method: None,
        };
        let by_frequency = self.error.as_ref();
        let by_frequency = by_frequency.map(|e| statement("relative_error", "1", 0.0, e.stated));
        let by_covariance = self.least_known.iter().map(|q| {
            let name = q.name.replacen("acceleration", "calibration_error", 1);
            statement(&name, "m/s²", 0.0, q.expanded(0.95))
        });
        let mut stated: Vec<StatedQuantity> =
            by_frequency.into_iter().chain(by_covariance).collect();
        if let Some(chain) = &self.chain {
            let normal = DegreesOfFreedom::INFINITE.coverage_factor(0.95);
            let of_bias = chain.bias_uncertainty;
            stated.extend(of_bias.map(|u| statement("bias_error", "m/s²", 0.0, normal * u)));
            let of_angles = chain.rotation_uncertainty;
            stated.extend(of_angles.map(|u| statement("rotation_error", "1", 0.0, normal * u)));
        }
        stated
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        let chain = self.chain.as_ref().map(|c| section("chain", c));
        chain.into_iter().collect()
    }

    fn page(&self, page: Report) -> Report {
        page::add(page, self)
    }
}
