//! Coverage of the primary calibration: simulated campaigns as raw files, through the job, against their truth.
//!
//! `primary_coverage [CAMPAIGNS PER CASE]` writes the table of docs/primary.md. Wavelength and voltage are without error here: their
//! inputs are declared, and everything else that makes U comes from the samples.

use proofmass_jobs::campaign::Campaign;
use proofmass_jobs::simulate::{SimulateJob, SimulatedPrimary};
use proofmass_jobs::{Gathered, Job, Sink, Unwatched};
use proofmass_uncertainty::Severity;
use rayon::prelude::*;
use std::error::Error;
use std::sync::Arc;

const FREQUENCIES: [f64; 7] = [10.0, 40.0, 160.0, 500.0, 1000.0, 3150.0, 10_000.0];

/// Error and U of modulus (relative) and phase (degrees) at one frequency, and whether anything warned of the campaign.
type Row = [[f64; 2]; 2];

fn campaign(job: SimulatedPrimary) -> Result<(Vec<Row>, bool), String> {
    let said = |e: &dyn std::fmt::Display| e.to_string();
    let files = Gathered::default();
    let outcome = SimulateJob::Primary(job).evaluate(&(&files as &dyn Sink), &Unwatched);
    let outcome = outcome.map_err(|e| said(&e))?;
    let campaign = Campaign::read(Arc::new(files.into_memory()), "campaign.toml");
    let result = campaign
        .map_err(|e| said(&e))?
        .evaluate(None, &Unwatched)
        .map_err(|e| said(&e))?;
    let quantities = result.quantities();
    let points = outcome.truth()["S_V/(m/s2)"].as_array().ok_or("no truth")?;
    let row = |point: &serde_json::Value| {
        let of = |key: &str| point[key].as_f64().unwrap_or(f64::NAN);
        let f = of("frequency_Hz");
        let stated = |name: &str| {
            let name = format!("S.{name}[frequency={f}]");
            quantities.iter().find(|q| q.name == name)
        };
        let (m, p) = (stated("modulus")?, stated("phase")?);
        let truth = of("modulus");
        Some([
            [m.value / truth - 1.0, m.expanded / truth],
            [
                p.value.to_degrees() - of("phase_deg"),
                p.expanded.to_degrees(),
            ],
        ])
    };
    let rows: Option<Vec<Row>> = points.iter().map(row).collect();
    let warned = result
        .findings()
        .iter()
        .any(|f| f.severity() > Severity::Note);
    rows.map(|rows| (rows, warned))
        .ok_or_else(|| "a frequency is missing".to_owned())
}

fn main() -> Result<(), Box<dyn Error>> {
    let count = std::env::args()
        .nth(1)
        .map_or(Ok(150), |n| n.parse::<u64>())?;
    println!(
        "| noise | runs | f in Hz | bias of the modulus | bias of the phase | U | U of the phase | modulus | phase |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let (mut pooled, mut all, mut warned, mut refused, mut healthy) =
        ([0usize; 2], 0usize, 0usize, 0usize, 0u64);
    for noise in [1e-3, 5e-3, 2e-2] {
        for repeats in [1, 2, 4] {
            let each = (0..count).into_par_iter().map(|k| {
                let mut job = SimulatedPrimary::default();
                job.seed = 1 + k + 10_000 * u64::from(repeats) + 100_000 * (1e4 * noise) as u64;
                job.frequencies = FREQUENCIES.to_vec();
                (job.repeats, job.noise, job.duration) = (repeats, noise, 0.05);
                (job.rate, job.velocity) = (100e3, 0.006);
                (job.u_wavelength, job.u_voltage) = (0.0, 0.0);
                campaign(job)
            });
            let each: Vec<_> = each.collect();
            healthy += count;
            refused += each.iter().filter(|e| e.is_err()).count();
            if let Some(Err(why)) = each.iter().find(|e| e.is_err()) {
                eprintln!("refused: {why}");
            }
            let each: Vec<(Vec<Row>, bool)> = each.into_iter().flatten().collect();
            warned += each.iter().filter(|e| e.1).count();
            for (i, f) in FREQUENCIES.iter().enumerate() {
                let n = each.len() as f64;
                let mean = |part: usize, what: usize| {
                    each.iter().map(|e| e.0[i][part][what]).sum::<f64>() / n
                };
                let held = [0, 1].map(|part| {
                    let inside = |e: &&(Vec<Row>, bool)| {
                        let [error, u] = e.0[i][part];
                        error.abs() <= u
                    };
                    each.iter().filter(inside).count()
                });
                pooled = [pooled[0] + held[0], pooled[1] + held[1]];
                all += each.len();
                println!(
                    "| {:.1} % | {repeats} | {f} | {:+.1e} | {:+.1e}° | {:.1e} | {:.1e}° | {:.1} | {:.1} |",
                    100.0 * noise,
                    mean(0, 0),
                    mean(1, 0),
                    mean(0, 1),
                    mean(1, 1),
                    100.0 * held[0] as f64 / n,
                    100.0 * held[1] as f64 / n,
                );
            }
        }
    }
    println!(
        "\npooled over {all} intervals each: modulus {:.2} %, phase {:.2} %; refused {refused} of {healthy} campaigns, {warned} with a warning or a decision",
        100.0 * pooled[0] as f64 / all as f64,
        100.0 * pooled[1] as f64 / all as f64,
    );
    Ok(())
}
