//! From the trials to means, intervals and the region.

use super::order::{heavy_tails, mean_and_sd, middle, ranks, smallest};
use super::valid::Valid;
use super::{CHUNK, Interval, Sampled, SampledOutput};
use crate::region::region;
use crate::{Covariance, Finding, Histogram, Refusal, Severity};
use rayon::prelude::*;

pub(super) fn summarise(
    outputs: Vec<(String, String)>,
    columns: Vec<Vec<f64>>,
    p: f64,
    heavy: bool,
) -> Result<Sampled, Refusal> {
    let trials = columns[0].len();
    let valid = Valid::of(outputs, columns, p)?;
    let mut findings = valid.findings;
    let joint = valid.joint.as_ref().filter(|joint| joint[0].len() > 1);
    let own: Vec<&Vec<f64>> = valid.columns.iter().map(|(column, _)| column).collect();
    let columns: Vec<&Vec<f64>> = joint.map_or_else(|| own.clone(), |joint| joint.iter().collect());
    let m = columns.len();
    let moments: Vec<(f64, f64)> = columns.iter().map(|c| mean_and_sd(c)).collect();
    let element = |i: usize, j: usize| {
        let last = columns[i].len() as f64 - 1.0;
        // Columns of unequal length exist only where no trial is valid in all of them.
        let sum: f64 = if i == j {
            // One that no number can hold is stated as absent.
            moments[i].1.max(0.0).powi(2) * last
        } else if columns[i].len() != columns[j].len() {
            0.0
        } else {
            let chunks = columns[i].chunks(4096).zip(columns[j].chunks(4096));
            let products = chunks.map(|(a, b)| {
                let pairs = a.iter().zip(b);
                pairs
                    .map(|(a, b)| (a - moments[i].0) * (b - moments[j].0))
                    .sum::<f64>()
            });
            products.sum()
        };
        sum / last
    };
    let triangle: Vec<Vec<f64>> = (0..m)
        .into_par_iter()
        .map(|i| (0..=i).map(|j| element(i, j)).collect())
        .collect();
    let mut rows = vec![0.0; m * m];
    for (i, elements) in triangle.iter().enumerate() {
        for (j, element) in elements.iter().enumerate() {
            rows[i * m + j] = *element;
            rows[j * m + i] = *element;
        }
    }
    let covariance = Covariance::try_from_rows(m, &rows)?;
    let equal = columns.iter().all(|c| c.len() == columns[0].len());
    let region = (m > 1 && equal)
        .then(|| region(&columns, &moments, &covariance, p))
        .flatten();
    let outputs: Vec<SampledOutput> = valid
        .outputs
        .iter()
        .zip(&valid.columns)
        .map(|((name, unit), (column, invalid))| {
            let output = output(name.clone(), unit.clone(), column, *invalid, p, heavy);
            if output.standard_uncertainty.is_none() {
                findings.push(no_standard_deviation(name));
            }
            output
        })
        .collect();
    Ok(Sampled {
        trials,
        probability: p,
        outputs,
        covariance,
        region,
        findings,
    })
}

fn no_standard_deviation(name: &str) -> Finding {
    Finding::new(
        Severity::Warning,
        "no-standard-deviation",
        format!("the trials of {name} have tails so heavy that their standard deviation does not settle"),
    )
    .advice(
        "state the Monte Carlo interval with the median; look for a division by something that reaches zero, and for \
         inputs from three observations or fewer",
    )
}

fn output(
    name: String,
    unit: String,
    column: &[f64],
    invalid: usize,
    p: f64,
    heavy: bool,
) -> SampledOutput {
    let trials = column.len();
    let (r, q) = ranks(trials, p);
    let (mean, u) = mean_and_sd(column);
    // Only the two tails decide the intervals: ranks 0 to trials − q can be lower ends, q and more upper ends.
    let count = trials - q + 1;
    let ((low, high), median) = rayon::join(
        || {
            rayon::join(
                || smallest(column, count, |v| v),
                || smallest(column, count, |v| -v),
            )
        },
        || middle(column, trials / 2),
    );
    let (lower, upper) = (
        |rank: usize| low[rank],
        |rank: usize| -high[trials - 1 - rank],
    );
    let shortest = (0..trials - q)
        .min_by(|&a, &b| (upper(a + q) - lower(a)).total_cmp(&(upper(b + q) - lower(b))))
        .unwrap_or(r);
    let symmetric = Interval {
        lower: lower(r),
        upper: upper(r + q),
    };
    let (least, most) = (lower(0), upper(trials - 1));
    // One trial that holds half of the variance: the next run has another, or none.
    let farthest = (mean - least).max(most - mean);
    let one_trial = farthest > u * (0.5 * (trials as f64 - 1.0)).sqrt();
    let settles = u.is_finite() && !one_trial && !heavy_tails(&low, &high, median, trials, heavy);
    // Bins about the middle that exists.
    let (centre, spread) = if settles {
        (mean, u)
    } else {
        (median, 0.25 * symmetric.width())
    };
    SampledOutput {
        name,
        unit,
        invalid,
        mean: if mean.is_finite() { mean } else { median },
        median,
        standard_uncertainty: settles.then_some(u),
        symmetric,
        symmetric_scatter: {
            // The rank of a quantile is binomial: one standard deviation of it to either side.
            let share = (r + 1) as f64 / trials as f64;
            let step = (trials as f64 * share * (1.0 - share)).sqrt().ceil() as usize;
            let (below, above) = (r.saturating_sub(step), (r + step).min(count - 1));
            0.5 * (low[above] - low[below]).max(high[above] - high[below])
        },
        shortest: Interval {
            lower: lower(shortest),
            upper: upper(shortest + q),
        },
        histogram: Histogram::count(column, centre, spread, CHUNK),
    }
}
