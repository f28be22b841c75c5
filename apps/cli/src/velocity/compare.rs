//! `proofmass velocity compare`: methods side by side, at several sample rates.

use super::estimate::{document, report};
use super::method::method;
use super::reference::ReferenceArguments;
use super::sensors::{Bench, Sensors, failure};
use crate::delivery::{Delivery, Results};
use crate::{Failure, Outcome, clock};
use proofmass::core::Unwatched;
use proofmass::io::{Cell, Table};
use proofmass::motion::{CompareResult, Method, compare};

/// Errors of many methods side by side, at any list of sample rates, against a reference or the smoother.
///
/// Without --method: differences, a fit and the integral of single sensors, two channels and observers with the
/// gains of the literature, and every fused method with gains found at that rate. With -o, a folder gets
/// result.json, report.html, errors.csv and velocities.csv.
#[derive(clap::Args)]
pub(crate) struct Compare {
    #[command(flatten)]
    sensors: Sensors,
    #[command(flatten)]
    reference: ReferenceArguments,
    /// Sample rates in hertz, to which the recording is thinned [default: its own]
    #[arg(long, value_name = "HZ,…", value_delimiter = ',')]
    rates: Vec<f64>,
    /// Method with its settings, such as observer:5,25; may be given several times [default: all]
    #[arg(long, value_name = "METHOD", value_parser = method)]
    method: Vec<Method>,
    /// Seconds at the start that are not compared: filters settle there [default: 1, at most a tenth]
    #[arg(long, value_name = "SECONDS")]
    skip: Option<f64>,
    #[command(flatten)]
    delivery: Delivery,
}

impl Compare {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let mut files = self.sensors.files();
        files.extend(self.reference.reference_file());
        let folder = self.delivery.begin(&files)?;
        let bench = self.sensors.read(self.reference.reference().as_ref())?;
        let decimations = self.decimations(&bench)?;
        let duration = bench.record.sample_time * bench.record.reading.len() as f64;
        let skip = self.skip.unwrap_or((0.1 * duration).min(1.0));
        if !(skip >= 0.0 && skip < duration) {
            return Err(Failure::new(format!(
                "--skip {skip} leaves nothing of {duration:.3} s to compare"
            )));
        }
        let result = compare(
            &bench.record,
            bench.reference.as_deref(),
            &self.method,
            &decimations,
            skip,
            &Unwatched,
        )
        .map_err(|e| failure(e, &self.sensors.recording))?;
        let mut findings = bench.findings.clone();
        findings.extend(result.findings.iter().cloned());
        let json = document("velocity-comparison", &bench, &findings)?
            .section("date", &clock::today())?
            .section("skip_s", &skip)?
            .section("comparison", &result)?
            .to_json()?;
        let title = format!(
            "Comparison of velocities on {}",
            self.sensors.recording.display()
        );
        let text = report(title, &bench, &findings);
        self.delivery.hand_over(
            folder,
            &Results {
                json,
                summary: &|| text.compare_summary(&result),
                report: &|| text.compare(&result),
                files: vec![
                    ("errors.csv", errors(&result)?),
                    ("velocities.csv", velocities(&bench, &result)?),
                ],
                findings: &findings,
            },
        )
    }

    /// Rates as whole fractions of that of the recording.
    fn decimations(&self, bench: &Bench) -> Result<Vec<usize>, Failure> {
        let own = 1.0 / bench.record.sample_time;
        if self.rates.is_empty() {
            return Ok(vec![1]);
        }
        let mut list = Vec::new();
        for &rate in &self.rates {
            let n = (own / rate).round();
            let fits = rate.is_finite() && rate > 0.0 && n >= 1.0;
            if !fits || (own / n / rate - 1.0).abs() > 0.01 {
                return Err(Failure::new(format!(
                    "--rates: {rate} Hz is not the rate of the recording, {own:.6} Hz, over a whole number"
                ))
                .hint(if fits {
                    format!("the nearest are {:.6} Hz and {:.6} Hz", own / n, own / (n + 1.0))
                } else {
                    format!("give rates from {own:.6} Hz down")
                }));
            }
            if !list.contains(&(n as usize)) {
                list.push(n as usize);
            }
        }
        Ok(list)
    }
}

fn errors(result: &CompareResult) -> Result<Vec<u8>, Failure> {
    let mut table = Table::new([
        "rate_Hz",
        "method",
        "sensors",
        "rms_m/s",
        "max_m/s",
        "mean_m/s",
        "delay_s",
        "stated_delay_s",
        "noise_floor_m/s",
        "drift_m/s2",
    ]);
    for row in &result.rows {
        let a = &row.agreement;
        let family = serde_json::to_value(row.family).unwrap_or_default();
        table.push([
            Cell::from(row.rate),
            Cell::from(row.label.as_str()),
            Cell::from(family.as_str().unwrap_or_default()),
            Cell::from(a.rms),
            Cell::from(a.max),
            Cell::from(a.bias),
            Cell::from(a.delay),
            Cell::from(row.stated_delay),
            Cell::from(a.noise_floor),
            Cell::from(a.drift),
        ])?;
    }
    Ok(table.to_csv()?)
}

/// Every velocity at the highest rate, one column per method.
fn velocities(bench: &Bench, result: &CompareResult) -> Result<Vec<u8>, Failure> {
    let highest = result.rows.iter().fold(0.0f64, |m, r| m.max(r.rate));
    let rows: Vec<_> = result.rows.iter().filter(|r| r.rate == highest).collect();
    let stride = (1.0 / (highest * bench.record.sample_time))
        .round()
        .max(1.0) as usize;
    let mut names = vec!["time_s".to_owned(), "reference_m/s".to_owned()];
    names.extend(rows.iter().map(|r| format!("{} (m/s)", r.label)));
    let mut table = Table::new(names);
    for (k, reference) in result.reference.iter().step_by(stride).enumerate() {
        let time = bench.origin + bench.start + bench.record.sample_time * (k * stride) as f64;
        let velocities = rows.iter().map(|r| r.velocity[k]);
        table.push([time, *reference].into_iter().chain(velocities))?;
    }
    Ok(table.to_csv()?)
}
