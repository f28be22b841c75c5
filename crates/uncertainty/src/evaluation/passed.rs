//! What another calculation may take of a result: what was stated.

use super::{Evaluate, Method, OutputResult, StatementMethod};
use crate::{
    Equations, Estimate, JointInputs, Linear, MonteCarlo, Refusal, TrialColumn, TrialTable,
    Validation,
};

/// Trials that are passed on.
const ROWS: usize = 20_000;
/// Trials that their values come from: each column is brought to the quantiles of these, so that mean and u are known to 0.2 %.
const TRIALS: usize = 10 * ROWS;
/// Numbers that a table holds at most; causes are left out where there are too many.
const CELLS: usize = 400_000;
/// Outputs that a table holds at most: results with more are not passed on but by the law of propagation.
const OUTPUTS: usize = 100;

/// The estimate of what is stated, and where an output is not stated by the law of propagation the trials of all. A factor that
/// was asked for gets the probability that it has in them.
pub(super) fn on(
    outputs: &mut [OutputResult],
    linear: Option<&Linear>,
    (equations, joint): (&Equations, &JointInputs),
    fewer: (&Equations, &JointInputs),
    options: &Evaluate,
) -> Result<(Option<Estimate>, Option<TrialTable>), Refusal> {
    let linear = linear.map(Linear::estimate);
    let by_law = |o: &OutputResult| o.stated.method == StatementMethod::LawOfPropagation;
    // A linear result that stands to its digit, but not so near to the trials that others may build on it.
    let loose = |o: &OutputResult| {
        let far = |v: &Validation| !v.passes_on();
        let free = options.method.unwrap_or_default() == Method::Auto;
        // Trials that lost some contradict nothing.
        let whole = o
            .monte_carlo
            .as_ref()
            .is_some_and(|s| s.invalid == 0 && s.standard_uncertainty.is_some_and(|u| u > 0.0));
        free && by_law(o) && whole && o.validation.as_ref().is_some_and(far)
    };
    let all_by_law = outputs.iter().all(by_law);
    if all_by_law && !outputs.iter().any(loose) {
        return Ok((linear.cloned(), None));
    }
    let stands = linear.filter(|_| all_by_law);
    if outputs.len() > OUTPUTS {
        return Ok((stands.cloned(), None));
    }
    let causes: Vec<usize> = (0..joint.draws().len())
        .filter(|&d| joint.draws()[d].standard_uncertainty > 0.0 && alone(joint, d))
        .collect();
    let with_causes = ROWS * (outputs.len() + causes.len()) <= CELLS;
    let seed = MonteCarlo::new(options.seed);
    let drawn = match with_causes {
        true => seed.drawn(equations, joint, TRIALS, &causes)?,
        false => seed.drawn(fewer.0, fewer.1, TRIALS, &[])?,
    };
    if drawn.outputs.first().is_none_or(|y| y.len() < ROWS) {
        // No road but the law of propagation has a distribution.
        return Ok((stands.cloned(), None));
    }
    let mut columns = Vec::new();
    for (output, values) in outputs.iter().zip(&drawn.outputs) {
        let stated = &output.stated;
        let u = stated.standard_uncertainty;
        let column = TrialColumn {
            name: stated.name.clone(),
            unit: stated.unit.clone(),
            value: stated.value,
            scale: u.unwrap_or(stated.reach()),
            cause: false,
            dof: None,
            by_trials: !by_law(output),
            loose: loose(output),
            trials: Vec::new(),
        };
        // A distribution that others draw keeps its ends, few degrees of freedom included; any other y ± U is brought to y and u.
        let as_they_are = stated.method == StatementMethod::MonteCarlo || loose(output);
        columns.push(column.of(by_rank(values), as_they_are));
    }
    if with_causes {
        for (d, values) in causes.into_iter().zip(&drawn.inputs) {
            let draw = &joint.draws()[d];
            let input = &joint.inputs[draw.input];
            let column = TrialColumn {
                name: draw.name.clone(),
                unit: input.unit.clone(),
                value: draw.estimate,
                scale: draw.standard_uncertainty,
                cause: true,
                dof: Some(input.dof),
                by_trials: false,
                loose: false,
                trials: Vec::new(),
            };
            // A Student t is wider than its u.
            columns.push(column.of(by_rank(values), !input.dof.is_infinite()));
        }
    }
    let table = TrialTable { columns };
    for output in outputs.iter_mut().filter(|o| !by_law(o)) {
        let stated = &mut output.stated;
        let trials = table.quantity(&stated.name).map(|c| &c.trials);
        if let (Some(_), StatementMethod::MonteCarlo, Some(trials)) =
            (stated.coverage_factor, stated.method, trials)
        {
            let inside = |y: &&f64| (stated.interval.lower..=stated.interval.upper).contains(*y);
            stated.probability = trials.iter().filter(inside).count() as f64 / trials.len() as f64;
        }
    }
    let settled = outputs
        .iter()
        .all(|o| o.stated.standard_uncertainty.is_some());
    let estimate = match stands {
        Some(linear) => Some(linear.clone()),
        None => settled.then(|| table.estimate(linear)).transpose()?,
    };
    Ok((estimate, Some(table)))
}

/// The first rows, each value replaced by the quantile of all at its rank among the first.
fn by_rank(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let first = &values[..ROWS.min(values.len())];
    let mut order: Vec<usize> = (0..first.len()).collect();
    order.sort_by(|&a, &b| first[a].total_cmp(&first[b]));
    let mut ranked = vec![0.0; first.len()];
    for (rank, &row) in order.iter().enumerate() {
        let place = (rank as f64 + 0.5) * sorted.len() as f64 / first.len() as f64;
        ranked[row] = sorted[(place as usize).min(sorted.len() - 1)];
    }
    ranked
}

/// Whether a draw is independent of all others.
fn alone(joint: &JointInputs, draw: usize) -> bool {
    joint.clusters.iter().any(|c| c.draws == [draw])
}
