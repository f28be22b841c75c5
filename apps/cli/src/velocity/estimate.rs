//! `proofmass velocity estimate`: the velocity with its uncertainty.

use super::method::method;
use super::sensors::{Bench, Sensors, failure};
use crate::delivery::{Delivery, Results};
use crate::{Failure, Outcome, clock};
use proofmass::core::Unwatched;
use proofmass::io::{Cell, ResultDocument, Software, Table};
use proofmass::motion::{EstimateResult, Method, MotionRecord, estimate};
use proofmass::report::VelocityReport;
use proofmass::uncertainty::Finding;

/// Velocity with its uncertainty; slip, collisions and ripple of the encoder are found and named.
///
/// Without --method the Kalman filter, its noise found by maximum likelihood and its gains by the smoother, which
/// uses the readings before and after. With -o, a folder gets result.json, report.html and velocity.csv.
#[derive(clap::Args)]
pub(crate) struct Estimate {
    #[command(flatten)]
    sensors: Sensors,
    /// Method with its settings, such as observer:5,25 or savitzky-golay:9,2 [default: Kalman, tuned]
    #[arg(long, value_name = "METHOD", value_parser = method)]
    method: Option<Method>,
    /// Distance of one turn of the wheel, m: its ripple is then told by itself
    #[arg(long, value_name = "METRES")]
    circumference: Option<f64>,
    #[command(flatten)]
    delivery: Delivery,
}

impl Estimate {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let folder = self.delivery.begin(&self.sensors.files())?;
        let bench = self.sensors.read(None)?;
        let result = estimate(&bench.record, self.method, self.circumference, &Unwatched)
            .map_err(|e| failure(e, &self.sensors.recording))?;
        let mut findings = bench.findings.clone();
        findings.extend(result.findings.iter().cloned());
        let title = format!("Velocity of {}", self.sensors.recording.display());
        let json = document("velocity-estimate", &bench, &findings)?
            .section("date", &clock::today())?
            .section("estimate", &result)?
            .to_json()?;
        let text = report(title, &bench, &findings);
        self.delivery.hand_over(
            folder,
            &Results {
                json,
                summary: &|| text.estimate_summary(&result),
                report: &|| text.estimate(&result),
                files: vec![("velocity.csv", table(&bench, &result)?)],
                findings: &findings,
            },
        )
    }
}

/// The beginning of result.json.
pub(super) fn document(
    kind: &str,
    bench: &Bench,
    findings: &[Finding],
) -> Result<ResultDocument, Failure> {
    let mut document = ResultDocument::new(kind).findings(findings);
    for input in &bench.inputs {
        document = document.input(input.clone());
    }
    let MotionRecord {
        sample_time,
        source,
        increment,
        initial_velocity,
        ..
    } = bench.record;
    Ok(document.section(
        "record",
        &serde_json::json!({
            "samples": bench.record.reading.len(),
            "readings": bench.record.reading.iter().flatten().count(),
            "sample_time_s": sample_time,
            "start_s": bench.origin + bench.start,
            "source": source,
            "increment_m": increment,
            "initial_velocity_m_per_s": initial_velocity,
        }),
    )?)
}

/// What every report of this command tells beside its result.
pub(super) fn report<'a>(
    title: String,
    bench: &Bench,
    findings: &'a [Finding],
) -> VelocityReport<'a> {
    VelocityReport {
        title,
        meta: vec![("Evaluated on".to_owned(), clock::today())],
        inputs: bench
            .inputs
            .iter()
            .map(|i| (i.path.clone(), i.sha256.clone()))
            .collect(),
        findings,
        start: bench.origin + bench.start,
        sample_time: bench.record.sample_time,
        footer: Software::default().to_string(),
    }
}

/// One row per sample.
fn table(bench: &Bench, result: &EstimateResult) -> Result<Vec<u8>, Failure> {
    let reading = if super::sensors::is_speed(&bench.record) {
        "speed_m/s"
    } else {
        "position_m"
    };
    let mut table = Table::new([
        "time_s",
        "velocity_m/s",
        "standard_uncertainty_m/s",
        "smoothed_m/s",
        "smoothed_standard_uncertainty_m/s",
        reading,
        "acceleration_m/s2",
        "slip",
    ]);
    let at = |u: &Option<Vec<f64>>, k: usize| Cell::from(u.as_ref().map(|u| u[k]));
    for k in 0..bench.record.reading.len() {
        let slips = result.slip.as_ref().is_some_and(|s| s.slips(k, 0));
        table.push([
            Cell::from(bench.origin + bench.start + bench.record.sample_time * k as f64),
            Cell::from(result.trace.velocity[k]),
            at(&result.trace.standard_uncertainty, k),
            Cell::from(result.smoother.velocity[k]),
            at(&result.smoother.standard_uncertainty, k),
            Cell::from(bench.record.reading[k]),
            Cell::from(bench.record.acceleration[k]),
            Cell::from(usize::from(slips)),
        ])?;
    }
    Ok(table.to_csv()?)
}
