//! Scale and offset of a logger from the still moments of days of free living.

mod calibration;
mod floats;

use crate::block_clock::stands_still;
use crate::campaign::{FreeLivingCampaign, StreamFormat, Unsaid};
use crate::multi_position::gravity;
use crate::outcome::{Job, Outcome, section};
use crate::page::parameters::stated_parameters;
use crate::record::Record;
use crate::trouble::{Result, Trouble};
use proofmass_core::{Error, Gravity, STANDARD_GRAVITY, Watch};
use proofmass_documents::{AnyCalibration, StatedQuantity};
use proofmass_io::{
    ClockUnit, ColumnRef, Input, Layout, Reading, RowReader, Thermometer, TimeWindow, Unit,
};
use proofmass_report::{Axis, KeyFigure, Report, Section, Series, XyPlot};
use proofmass_signal::Trace;
use proofmass_static::{
    AutoCalibration, AutoCalibrationFit, StillWindow, StillWindows, WindowRule,
};
use proofmass_uncertainty::findings::gaps_in_record;
use proofmass_uncertainty::{Estimate, Finding, Severity};
use serde::{Deserialize, Serialize};

/// By how much a time may lie before the one ahead of it, s: a logger that writes in bursts puts them back a little.
const MOST_BACK: f64 = 10.0;

/// Which windows are still, and how they are fitted.
///
/// ```
/// use proofmass_jobs::free_living::{FreeLivingJob, FreeLivingWindows};
/// use proofmass_jobs::{Job, TroubleKind, Unwatched};
///
/// // Without still windows there is nothing to be said, and that is said.
/// let nothing = FreeLivingWindows { name: "a logger".into(), ..FreeLivingWindows::default() };
/// let refused = FreeLivingJob::default().evaluate(&nothing, &Unwatched).err().unwrap();
/// assert_eq!(refused.kind(), TroubleKind::Data);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FreeLivingJob {
    /// What a still window is.
    #[serde(default)]
    pub rule: WindowRule,
    /// The fit.
    #[serde(default)]
    pub fit: AutoCalibration,
    /// Probability of the intervals.
    pub probability: f64,
    /// Gravity where it was worn, which turns multiples of it into m/s²; without it anything on the ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Gravity>,
}

impl Default for FreeLivingJob {
    fn default() -> Self {
        Self {
            rule: WindowRule::default(),
            fit: AutoCalibration::default(),
            probability: 0.95,
            gravity: None,
        }
    }
}

impl FreeLivingJob {
    /// Standard uncertainty of standard gravity as that of a place on the ground (9.76 to 9.84 m/s²), m/s².
    const ANYWHERE: f64 = 0.03;
}

/// The still windows of a recording that was never held.
#[derive(Clone, Debug, Default)]
pub struct FreeLivingWindows {
    /// Still windows in the order of time.
    pub still: Vec<StillWindow>,
    /// All windows.
    pub seen: usize,
    /// What reading found.
    pub findings: Vec<Finding>,
    /// Files.
    pub inputs: Vec<Input>,
    /// What the recording is called in messages.
    pub name: String,
    /// How x, y, z are called in the recording, for compensating others of its kind.
    pub columns: Option<[ColumnRef; 3]>,
}

/// Gaps that were filled with something else than zeros.
fn filled(windows: &StillWindows) -> Option<Finding> {
    let (filled, seen) = (windows.filled(), windows.seen());
    (filled > 0).then(|| {
        gaps_in_record(
            " and were filled with the last value or a straight line: such windows are not taken for stillness",
            &format!("{filled} of {seen} windows change on no axis, or as a straight line on all"),
            "nothing, where the logger sleeps while it is not moved",
        )
        .at(Severity::Note)
    })
}

impl FreeLivingCampaign {
    /// Reads the recording block by block and keeps its still windows only.
    ///
    /// # Errors
    /// A file that cannot be read, a column that is missing, an output that is no acceleration.
    pub fn load(&self, watch: &dyn Watch) -> Result<FreeLivingWindows> {
        let table = &self.recording;
        let mut source = self.source.source(&table.file)?;
        if table.format == StreamFormat::F32 {
            return self.load_floats(source, watch);
        }
        let name = source.name().display().to_string();
        source = source.with_stream(table.source.as_deref(), false);
        let layout = Layout::of(&mut source, &table.layout())?;
        let axes = [&table.columns.x, &table.columns.y, &table.columns.z];
        let mut selected = Vec::new();
        let mut factors = [1.0; 3];
        for column in axes {
            selected.push(layout.find(column)?);
        }
        let time = table.time.as_ref().map(|t| layout.find(t)).transpose()?;
        let unsaid = Unsaid {
            signals: &selected,
            unit: table.unit,
            time,
            time_unit: table.time_unit,
            rate_hz: table.sampling_rate_hz,
            timeless: false,
        };
        unsaid
            .refuse(&layout, false)
            .map_err(|e| e.at(source.name()))?;
        for (factor_of, &index) in factors.iter_mut().zip(&selected) {
            let unit = layout.unit(index).or(table.unit).unwrap_or(Unit::One);
            let (si, factor) = unit.si();
            if !si.is_acceleration() {
                return Err(Trouble::data(format!("{name}: {unit} is no acceleration"))
                    .with_hint("auto-calibration needs outputs in g or m/s²"));
            }
            *factor_of = factor / proofmass_core::STANDARD_GRAVITY;
        }
        let time = match table.sampling_rate_hz {
            Some(_) => time,
            None => time.or_else(|| layout.time_column()),
        };
        let clock = time
            .map(|column| {
                ClockUnit::of(
                    &layout,
                    column,
                    table.time_unit,
                    table.sampling_rate_hz,
                    false,
                )
                .map_err(|e| e.at(source.name()))
            })
            .transpose()?;
        let window = table.between_s.and_then(|between| {
            TimeWindow::of(
                between,
                selected.len(),
                clock.as_ref(),
                table.sampling_rate_hz,
            )
        });
        let per_second = clock.as_ref().map_or(1.0, |c| c.per_second);
        let rate = table.sampling_rate_hz;
        layout.refuse_grouped(&selected, table.unit)?;
        let mut reading = Reading::of(
            &layout,
            &selected,
            table.unit,
            time.zip(clock.as_ref()),
            rate,
        );
        reading.between_s = table.between_s;
        selected.extend(time);
        let asked = Thermometer::asked(&layout, table.temperature.as_ref())?;
        let (temperature, thermometer) = asked.unzip();
        selected.extend(temperature);
        let told = temperature.zip(thermometer.as_ref());
        reading.temperature = told.map(|(index, told)| Reading::thermometer(&layout, index, told));
        let temperature_slot = temperature.map(|_| selected.len() - 1);

        let mut windows = StillWindows::new(self.job()?.rule)?;
        let mut findings = layout.findings();
        findings.extend(clock.and_then(|c| c.finding));
        let mut reader = RowReader::new(source, layout, &selected)?.between(window);
        let size = reader.size().unwrap_or(0);
        let mut rows = 0usize;
        let (mut first, mut last) = (None, 0.0);
        while let Some(block) = reader.next_block()? {
            watch.step("reading", reader.bytes_read(), size)?;
            let [x, y, z] = [0, 1, 2].map(|axis| block.column(axis));
            for row in 0..block.rows() {
                let at = match (time, table.sampling_rate_hz) {
                    (Some(_), _) => block.column(3)[row] / per_second,
                    (None, Some(rate)) => (rows + row) as f64 / rate,
                    (None, None) => 0.0,
                };
                if first.is_some() && at < last - MOST_BACK {
                    return Err(Trouble::data(proofmass_io::backwards(last, at))
                        .detail(format!("{name}:{}", block.line(row)))
                        .with_hint("export the times with their dates, or read one part with --between FROM TO (`between_s = [FROM, TO]` in a campaign)"));
                }
                let output = [
                    x[row] * factors[0],
                    y[row] * factors[1],
                    z[row] * factors[2],
                ];
                let temperature = temperature_slot.zip(thermometer.as_ref());
                let temperature = temperature.map(|(slot, t)| t.celsius(block.column(slot)[row]));
                first = first.or(Some(at));
                last = at;
                windows.push(at, output, temperature);
            }
            rows += block.rows();
        }
        findings.extend(reader.findings());
        findings.extend(filled(&windows));
        let duration = last - first.unwrap_or(last);
        if time.is_some() && rows > 1 {
            if duration <= 0.0 {
                return Err(stands_still(&name));
            }
            reading.time.rate_hz = Some((rows - 1) as f64 / duration);
        }
        let recording = reader.finish()?.with_reading(reading);
        let mut inputs = self.source.as_inputs();
        inputs.push(recording);
        Ok(FreeLivingWindows {
            seen: windows.seen(),
            still: windows.finish(),
            findings,
            inputs,
            name,
            columns: Some([&table.columns.x, &table.columns.y, &table.columns.z].map(Clone::clone)),
        })
    }

    /// The question of the campaign.
    ///
    /// # Errors
    /// A gravity that cannot be.
    pub fn job(&self) -> Result<FreeLivingJob> {
        let mut job = FreeLivingJob::default();
        job.fit.stop = self.method.stop;
        job.fit.temperature = self.method.temperature;
        job.probability = self.method.confidence;
        job.gravity = self.gravity.as_ref().map(gravity).transpose()?;
        Ok(job)
    }

    /// What the result is filed with.
    pub fn record(&self, data: &FreeLivingWindows, date: Option<String>) -> Record {
        self.filed(date, data.inputs.clone())
    }
}

impl Job for FreeLivingJob {
    type Data<'a> = FreeLivingWindows;
    type Outcome = FreeLivingOutcome;

    fn evaluate(&self, data: &FreeLivingWindows, watch: &dyn Watch) -> Result<FreeLivingOutcome> {
        watch.step("fit", 0, 1)?;
        let place = format!(
            "{}: {} of {} windows of {} s are still",
            data.name,
            data.still.len(),
            data.seen,
            self.rule.duration
        );
        let fit = self.fit.fit(&data.still).map_err(|error| {
            let trouble = match error {
                Error::Unobservable { parameter, .. } => Trouble::data(format!(
                    "the still windows do not populate the sphere: {parameter} is not determined"
                ))
                .detail(format!(
                    "every axis must have still windows below −{reach} g and above +{reach} g",
                    reach = self.fit.reach
                )),
                other => Trouble::from(other),
            };
            trouble.detail(&place).with_hint(match data.seen {
                0 => "no window holds samples enough: rows that are means of windows themselves are read with `--rows readings` in the place of --free-living",
                _ => "record longer, or lay the logger still on each of its sides for a minute",
            })
        })?;
        watch.step("fit", 1, 1)?;
        let still = data.still.iter();
        let departures = still.map(|w| (w.time, departures(w, &fit))).collect();
        let mut findings = data.findings.clone();
        findings.extend(fit.findings.iter().cloned());
        findings.sort_by_key(|f| std::cmp::Reverse(f.severity()));
        Ok(FreeLivingOutcome {
            quantities: StatedQuantity::list(&fit.quantities(), self.probability),
            probability: self.probability,
            seen: data.seen,
            findings,
            gravity: match self.gravity {
                Some(gravity) => gravity,
                None => Gravity::given(STANDARD_GRAVITY, Self::ANYWHERE)?,
            },
            temperature_range: temperature_range(&data.still),
            columns: data.columns.clone(),
            departures,
            fit,
        })
    }
}

/// Scale, offset and temperature coefficient of each axis.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeLivingOutcome {
    quantities: Vec<StatedQuantity>,
    probability: f64,
    seen: usize,
    findings: Vec<Finding>,
    gravity: Gravity,
    /// Lowest and highest temperature of the still windows, °C.
    temperature_range: Option<[f64; 2]>,
    columns: Option<[ColumnRef; 3]>,
    /// Of each still window its time, s, and ‖a‖ − 1 g before and after, mg.
    departures: Vec<(f64, [f64; 2])>,
    fit: AutoCalibrationFit,
}

fn departures(window: &StillWindow, fit: &AutoCalibrationFit) -> [f64; 2] {
    let of = |a: [f64; 3]| 1e3 * (a.iter().map(|v| v * v).sum::<f64>().sqrt() - 1.0);
    let p = &fit.parameters;
    let warmer = fit.mean_temperature.zip(window.temperature);
    let warmer = warmer.map_or(0.0, |(mean, t)| t - mean);
    let corrected = std::array::from_fn(|i| {
        p.scale[i] * (window.mean[i] + p.offset[i]) + p.temperature[i] * warmer
    });
    [of(window.mean), of(corrected)]
}

fn temperature_range(windows: &[StillWindow]) -> Option<[f64; 2]> {
    let temperatures = windows.iter().filter_map(|w| w.temperature);
    let low = temperatures.clone().fold(f64::INFINITY, f64::min);
    let high = temperatures.fold(f64::NEG_INFINITY, f64::max);
    (low <= high).then_some([low, high])
}

impl FreeLivingOutcome {
    /// The fit itself.
    pub fn fit(&self) -> &AutoCalibrationFit {
        &self.fit
    }
}

impl Outcome for FreeLivingOutcome {
    const KIND: &'static str = "free-living";
    const PRINCIPAL_TABLE: &'static str = "parameters.csv";

    fn title(&self, record: &Record) -> String {
        record.title("Auto-calibration of", "Auto-calibration of a logger")
    }

    fn quantities(&self) -> Vec<StatedQuantity> {
        self.quantities.clone()
    }

    fn findings(&self) -> &[Finding] {
        &self.findings
    }

    fn estimate(&self) -> Option<&Estimate> {
        Some(&self.fit.estimate)
    }

    fn sections(&self) -> Result<Vec<(&'static str, serde_json::Value)>> {
        Ok(vec![section("fit", &self.fit.parameters)?])
    }

    fn calibration(&self, record: &Record) -> Result<Option<AnyCalibration>> {
        Ok(Some(self.file(record)?.into()))
    }

    fn page(&self, page: Report) -> Report {
        let fit = &self.fit;
        let figure = |label: &str, value: f64| KeyFigure::new(label, format!("{value:.2}"), "mg");
        let caption = format!(
            "Parameters with their {:.0} % intervals",
            100.0 * self.probability
        );
        let six = |q: &StatedQuantity| [q.value, q.expanded].map(|v| format!("{v:.6}"));
        let temperature = fit
            .mean_temperature
            .map_or(String::new(), |t| format!(" T̄ = {t:.2} °C."));
        let result = Section::new("Result")
            .paragraph(format!(
                "Corrected output a = scale · (output + offset) + temperature · (T − T̄), axis by axis, in g.{temperature} \
                 Offsets and scale factors make ‖a‖ = 1 g where the sensor was still; misalignment is not part of the model."
            ))
            .key_figures([
                KeyFigure::new("still windows", fit.windows.to_string(), ""),
                figure("error before", fit.error_before_mg),
                figure("error after", fit.error_after_mg).note("mean of |‖a‖ − 1 g|"),
                KeyFigure::new("iterations", fit.iterations.to_string(), ""),
            ])
            .table(stated_parameters(caption, &self.quantities, six));
        let time: Vec<f64> = self.departures.iter().map(|d| d.0 / 3600.0).collect();
        let mut plot = XyPlot::new(Axis::linear("time", "h"), Axis::linear("‖a‖ − 1 g", "mg"))
            .horizontal(0.0, "");
        for (k, name) in ["before", "after"].into_iter().enumerate() {
            let departures: Vec<f64> = self.departures.iter().map(|d| d.1[k]).collect();
            let shown = Trace::new(&time, &departures, Trace::RUNS / 4);
            plot = plot.series(Series::markers(name, &shown.x, &shown.y));
        }
        page.subtitle(format!(
            "Auto-calibration from {} still windows of {} ({} independent blocks of time)",
            fit.windows, self.seen, fit.blocks
        ))
        .verdict(format!(
            "Where the sensor was still, ‖a‖ is 1 g within {:.1} mg on average; it was {:.1} mg before.",
            fit.error_after_mg, fit.error_before_mg
        ))
        .section(result.summarised())
        .shown_by("Departure of each still window from 1 g, as recorded and calibrated", plot)
    }
}
