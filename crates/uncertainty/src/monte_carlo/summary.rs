//! From the trials to means, intervals and the region.

use super::order::{heavy_tails, mean_and_sd, middle, ranks, smallest};
use super::valid::Valid;
use super::{CHUNK, Interval, Sampled, SampledOutput};
use crate::findings;
use crate::region::region;
use crate::{Covariance, Histogram, Refusal};
use faer::Mat;

/// Trials whose departures from the mean are held at a time.
const CENTRED: usize = 4096;

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
    // Columns of unequal length exist only where no trial is valid in all of them.
    let equal = columns.iter().all(|c| c.len() == columns[0].len());
    let mut products = Mat::<f64>::zeros(m, m);
    if equal && m > 1 {
        for first in (0..columns[0].len()).step_by(CENTRED) {
            let count = CENTRED.min(columns[0].len() - first);
            let centred = Mat::from_fn(count, m, |i, j| columns[j][first + i] - moments[j].0);
            products += centred.transpose() * &centred;
        }
    }
    let mut rows = vec![0.0; m * m];
    for i in 0..m {
        let last = columns[i].len() as f64 - 1.0;
        for j in 0..i {
            // Nothing varies with what has no variance below.
            let held = moments[i].1.is_finite() && moments[j].1.is_finite();
            rows[i * m + j] = if held { products[(i, j)] / last } else { 0.0 };
            rows[j * m + i] = rows[i * m + j];
        }
        // One that no number can hold is stated as absent.
        rows[i * m + i] = moments[i].1.max(0.0).powi(2);
    }
    let covariance = Covariance::try_from_rows(m, &rows)?;
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
                findings.push(findings::no_standard_deviation(name));
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
