//! The law of propagation of uncertainty: from a model and its inputs to an estimate with its budget.

mod second_order;

pub use second_order::{SecondOrder, propagate_second_order};

use crate::algebra::symmetric_eigen;
use crate::findings;
use crate::{
    BudgetInput, BudgetLine, Component, Covariance, DegreesOfFreedom, Dual, Effect, Estimate,
    Evaluation, Finding, Influence, JointInputs, Member, Number, Quantity,
};
use proofmass_core::Error;
use serde::{Deserialize, Serialize};

/// A measurement model y = f(x), written once over any [`Number`].
///
/// ```
/// use proofmass_uncertainty::{Model, Number};
/// struct Resistance;
/// impl Model for Resistance {
///     fn outputs(&self) -> Vec<(String, String)> { vec![("R".into(), "Ω".into())] }
///     fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) { y[0] = x[0] / x[1]; }
/// }
/// ```
pub trait Model {
    /// Names and units of the outputs.
    fn outputs(&self) -> Vec<(String, String)>;
    /// Computes the outputs: one input per draw, in the order of [`JointInputs::draws`].
    fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]);
    /// Computes the outputs of several trials: a column of equal length per draw and per output. One after the other,
    /// unless the model knows a faster way to the same numbers.
    fn evaluate_columns(&self, x: &[&[f64]], y: &mut [&mut [f64]]) {
        one_by_one(x, y, |x, y| self.evaluate(x, y));
    }
    /// Period of each output that lives on a circle: a phase has 2π. Trials of it are counted from the estimate, half a
    /// period to either side, so that no cut divides the distribution. None by default.
    fn periods(&self) -> Vec<Option<f64>> {
        Vec::new()
    }
}

/// Columns of trials, each trial by itself.
pub(crate) fn one_by_one(x: &[&[f64]], y: &mut [&mut [f64]], f: impl Fn(&[f64], &mut [f64])) {
    let lengths = x.iter().map(|column| column.len());
    let lengths = lengths.chain(y.iter().map(|column| column.len()));
    let mut row = vec![0.0; x.len()];
    let mut out = vec![0.0; y.len()];
    for trial in 0..lengths.min().unwrap_or(0) {
        for (value, column) in row.iter_mut().zip(x) {
            *value = column[trial];
        }
        f(&row, &mut out);
        for (column, value) in y.iter_mut().zip(&out) {
            column[trial] = *value;
        }
    }
}

/// How many derivatives travel together; one evaluation of the model per this many inputs.
const CHUNK: usize = 8;

/// Values and Jacobian (by rows, m × n) of a model by forward automatic differentiation.
///
/// # Errors
/// [`Error::NotFinite`] for a value or derivative that is not.
pub fn jacobian<M: Model>(model: &M, x: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let m = model.outputs().len();
    jacobian_of::<CHUNK>(x, m, |x, y| model.evaluate(x, y))
}

pub(crate) fn jacobian_of<const W: usize>(
    x: &[f64],
    m: usize,
    f: impl Fn(&[Dual<f64, W>], &mut [Dual<f64, W>]),
) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let (value, jacobian) = derivatives(x, m, f);
    finite(&value, &jacobian)?;
    Ok((value, jacobian))
}

pub(crate) fn derivatives<const W: usize>(
    x: &[f64],
    m: usize,
    f: impl Fn(&[Dual<f64, W>], &mut [Dual<f64, W>]),
) -> (Vec<f64>, Vec<f64>) {
    let n = x.len();
    let mut jacobian = vec![0.0; m * n];
    let mut value = vec![0.0; m];
    let mut y = vec![Dual::from(0.0); m];
    let mut start = 0;
    loop {
        let seeded: Vec<Dual<f64, W>> = x
            .iter()
            .enumerate()
            .map(|(i, &x)| Dual::variable(x, i.wrapping_sub(start)))
            .collect();
        f(&seeded, &mut y);
        for (k, y) in y.iter().enumerate() {
            value[k] = y.real;
            let width = W.min(n - start);
            jacobian[k * n + start..k * n + start + width].copy_from_slice(&y.partials[..width]);
        }
        start += W;
        if start >= n {
            break;
        }
    }
    (value, jacobian)
}

fn finite(value: &[f64], jacobian: &[f64]) -> Result<(), Error> {
    for (name, values) in [
        ("model output", value),
        ("derivative of the model", jacobian),
    ] {
        proofmass_core::check::finite(name, values)?;
    }
    Ok(())
}

/// Result of the law of propagation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Linear {
    estimate: Estimate,
    dof: Vec<DegreesOfFreedom>,
    budgets: Vec<Vec<BudgetLine>>,
    second_order: Vec<Option<SecondOrder>>,
    findings: Vec<Finding>,
}

impl Linear {
    /// The outputs with their joint covariance.
    pub fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    /// One output with effective degrees of freedom after Willink.
    pub fn get(&self, name: &str) -> Option<Quantity> {
        let i = self.estimate.index_of(name)?;
        self.estimate.get(name).map(|q| Quantity {
            dof: self.dof[i],
            ..q
        })
    }

    /// Budget of one output, a line per input, largest contribution first.
    ///
    /// The share of a correlated input is c_i Σ_j c_j u(x_i, x_j) / u², which may be negative; shares sum to 1.
    pub fn budget(&self, name: &str) -> Option<&[BudgetLine]> {
        self.estimate
            .index_of(name)
            .map(|i| self.budgets[i].as_slice())
    }

    /// Second-order terms, one per output; empty unless asked for, absent where the series does not hold (a variance
    /// below zero, a derivative that does not exist).
    pub fn second_order(&self) -> &[Option<SecondOrder>] {
        &self.second_order
    }

    /// What to doubt.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }
}

/// Propagates the inputs through a model, first order.
///
/// U_y = J U_x Jᵀ with the full joint covariance.
///
/// **Errors** [`Error::NotFinite`] when the model or a derivative is not finite at the estimates.
/// **Source** `[GUM] 5.1, 5.2`, `[S2] 6.2`.
pub fn propagate<M: Model>(model: &M, inputs: &JointInputs) -> Result<Linear, Error> {
    let x = inputs.estimates();
    let (y, mut j) = derivatives::<CHUNK>(x.as_slice(), model.outputs().len(), |x, y| {
        model.evaluate(x, y)
    });
    // What does not vary has no say, even where its derivative does not exist.
    for (place, derivative) in j.iter_mut().enumerate() {
        if inputs.draws[place % x.len()].standard_uncertainty == 0.0 && !derivative.is_finite() {
            *derivative = 0.0;
        }
    }
    finite(&y, &j)?;
    linear(model.outputs(), &y, &j, inputs)
}

/// Propagates with a Jacobian the caller knows (analytic, or from an implicit model): m rows of n derivatives.
///
/// # Errors
/// [`Error::Length`], [`Error::NotFinite`].
pub fn linear(
    outputs: Vec<(String, String)>,
    y: &[f64],
    jacobian: &[f64],
    inputs: &JointInputs,
) -> Result<Linear, Error> {
    let (m, n) = (outputs.len(), inputs.draws.len());
    for (name, expected, got) in [("outputs", m, y.len()), ("Jacobian", m * n, jacobian.len())] {
        if expected != got {
            return Err(Error::Length {
                name,
                expected,
                got,
            });
        }
    }
    let components: Vec<Component> = outputs
        .into_iter()
        .zip(y)
        .map(|((name, unit), &value)| Component { name, unit, value })
        .collect();
    let influences = inputs
        .clusters
        .iter()
        .map(|cluster| influence(inputs, cluster, jacobian, m))
        .collect::<Result<Vec<_>, Error>>()?;
    let estimate = Estimate::new(components, influences)?;
    let mut result = Linear {
        estimate,
        dof: Vec::with_capacity(m),
        budgets: Vec::with_capacity(m),
        second_order: Vec::new(),
        findings: Vec::new(),
    };
    result.findings.extend(separately_estimated(inputs));
    for k in 0..m {
        let shares = shares(inputs, &jacobian[k * n..(k + 1) * n]);
        let variance = result.estimate.covariance()[(k, k)];
        result.dof.push(effective_dof(inputs, &shares, variance));
        result.budgets.push(budget(
            inputs,
            &shares,
            &jacobian[k * n..(k + 1) * n],
            (result.estimate.components()[k].value, variance),
        ));
        let name = &result.estimate.components()[k].name;
        let nu = result.dof[k].get();
        if variance > 0.0 && nu < 3.0 {
            result.findings.push(findings::few_degrees_of_freedom(
                name,
                nu,
                "repeat the dominant type A observation, or use the Monte Carlo interval",
            ));
        }
        if variance > 0.0 {
            result
                .findings
                .extend(dominant_non_normal(inputs, &shares, variance, name));
        }
    }
    Ok(result)
}

/// Per input: own variance Σ_d Σ_d′ within the input, and variance with its correlations to others.
struct Share {
    own: f64,
    total: f64,
}

fn shares(inputs: &JointInputs, c: &[f64]) -> Vec<Share> {
    let mut shares: Vec<Share> = inputs
        .inputs
        .iter()
        .map(|_| Share {
            own: 0.0,
            total: 0.0,
        })
        .collect();
    for cluster in &inputs.clusters {
        for (a, &i) in cluster.draws.iter().enumerate() {
            let (d, ci) = (
                &inputs.draws[i],
                c[i] * inputs.draws[i].standard_uncertainty,
            );
            match &cluster.correlation {
                None => {
                    shares[d.input].own += ci * ci;
                    shares[d.input].total += ci * ci;
                }
                Some(r) => {
                    for (b, &j) in cluster.draws.iter().enumerate() {
                        let other = &inputs.draws[j];
                        let v = ci * r[(a, b)] * c[j] * other.standard_uncertainty;
                        shares[d.input].total += v;
                        if other.input == d.input {
                            shares[d.input].own += v;
                        }
                    }
                }
            }
        }
    }
    shares
}

/// Willink's formula. The draws of one input share one estimate of σ, and inputs observed together one
/// covariance, so the variance of each such set counts as one estimate with its degrees of freedom.
fn effective_dof(inputs: &JointInputs, shares: &[Share], variance: f64) -> DegreesOfFreedom {
    let mut spread = 0.0;
    for (i, input) in inputs.inputs.iter().enumerate() {
        let set = inputs.together.iter().find(|set| set.contains(&i));
        let v = match set {
            Some(set) if set[0] != i => continue,
            Some(set) => set.iter().map(|&j| shares[j].total).sum(),
            None => shares[i].total,
        };
        spread += (v / variance).powi(2) / input.dof.get();
    }
    DegreesOfFreedom::new(1.0 / spread).unwrap_or(DegreesOfFreedom::INFINITE)
}

/// The budget of an output with this value and variance.
fn budget(
    inputs: &JointInputs,
    shares: &[Share],
    c: &[f64],
    (value, variance): (f64, f64),
) -> Vec<BudgetLine> {
    let mut lines: Vec<BudgetLine> = inputs
        .inputs
        .iter()
        .enumerate()
        .map(|(i, input)| {
            let mut own = inputs
                .draws
                .iter()
                .enumerate()
                .filter(|(_, d)| d.input == i);
            let single = match (own.next(), own.next()) {
                (Some((d, draw)), None) => Some(BudgetInput {
                    value: draw.estimate,
                    unit: input.unit.clone(),
                    standard_uncertainty: draw.standard_uncertainty,
                    sensitivity: c[d],
                }),
                _ => None,
            };
            BudgetLine {
                key: input.name.clone(),
                description: input.description.clone(),
                evaluation: input.evaluation,
                distribution: input.distribution.name().into(),
                dof: input.dof,
                input: single,
                contribution: shares[i].own.max(0.0).sqrt(),
                share: if variance > 0.0 {
                    shares[i].total / variance
                } else {
                    0.0
                },
            }
        })
        .collect();
    lines
        .iter_mut()
        .for_each(|line| line.clear_rounding(value, variance.sqrt()));
    lines.sort_by(|a, b| b.contribution.total_cmp(&a.contribution));
    lines
}

/// Correlated inputs with finite degrees of freedom are either one estimate or several: say which was assumed.
fn separately_estimated(inputs: &JointInputs) -> Option<Finding> {
    let mut names: Vec<&str> = Vec::new();
    for cluster in inputs.clusters.iter().filter(|c| c.correlation.is_some()) {
        let few = |i: &&usize| !inputs.inputs[**i].dof.is_infinite();
        let single = |i: &&usize| !inputs.together.iter().any(|set| set.contains(i));
        let found = cluster.inputs.iter().filter(few).filter(single);
        names.extend(found.map(|&i| inputs.inputs[i].name.as_str()));
    }
    (names.len() > 1).then(|| findings::separately_estimated(&names.join(", ")))
}

/// The central limit theorem needs many comparable contributions; one broad flat one is not that.
fn dominant_non_normal(
    inputs: &JointInputs,
    shares: &[Share],
    variance: f64,
    name: &str,
) -> Option<Finding> {
    let (i, share) = shares
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total.total_cmp(&b.1.total))?;
    let word = inputs.inputs[i].distribution.name();
    let draws = inputs.draws.iter().filter(|d| d.input == i).count();
    let flat = !matches!(word, "normal" | "Student t" | "truncated normal");
    (flat && draws == 1 && share.total > 0.5 * variance).then(|| {
        findings::dominant_non_normal_input(
            word,
            name,
            &inputs.inputs[i].name,
            100.0 * share.total / variance,
        )
    })
}

fn influence(
    inputs: &JointInputs,
    cluster: &crate::input::Cluster,
    jacobian: &[f64],
    m: usize,
) -> Result<Influence, Error> {
    let n = inputs.draws.len();
    let of_inputs: Vec<_> = cluster.inputs.iter().map(|&i| &inputs.inputs[i]).collect();
    let members = &of_inputs;
    let join = |f: fn(&crate::Input) -> &str| {
        let mut words: Vec<&str> = members.iter().map(|i| f(i)).collect();
        words.dedup();
        words.join(", ")
    };
    let (dof, effect) = if let [d] = cluster.draws[..] {
        let draw = &inputs.draws[d];
        let effect = Effect::Scalar {
            value: draw.estimate,
            unit: members[0].unit.clone(),
            standard_uncertainty: draw.standard_uncertainty,
            sensitivity: (0..m).map(|k| jacobian[k * n + d]).collect(),
        };
        (members[0].dof, effect)
    } else if let (Some(correlation), true) = (
        &cluster.correlation,
        cluster.draws.len() <= MEMBERS && members.len() > 1,
    ) {
        let members = cluster.draws.iter().map(|&d| {
            let draw = &inputs.draws[d];
            let input = &inputs.inputs[draw.input];
            Member {
                key: draw.name.clone(),
                description: input.description.clone(),
                evaluation: input.evaluation,
                distribution: input.distribution.name().into(),
                dof: input.dof,
                estimate_of_scatter: inputs.estimated_with(d),
                value: draw.estimate,
                unit: input.unit.clone(),
                standard_uncertainty: draw.standard_uncertainty,
                sensitivity: (0..m).map(|k| jacobian[k * n + d]).collect(),
            }
        });
        let effect = Effect::Correlated {
            members: members.collect(),
            correlation: correlation.clone(),
        };
        (least_dof(&of_inputs), effect)
    } else {
        let u: Vec<f64> = cluster
            .draws
            .iter()
            .map(|&d| inputs.draws[d].standard_uncertainty)
            .collect();
        let c = match &cluster.correlation {
            None => Covariance::from_standard_uncertainties(&u)?,
            Some(r) => {
                let mut c = r.clone();
                for (a, ua) in u.iter().enumerate() {
                    for (b, ub) in u.iter().enumerate() {
                        c.set(a, b, r[(a, b)] * ua * ub);
                    }
                }
                c
            }
        };
        let rows: Vec<f64> = (0..m)
            .flat_map(|k| cluster.draws.iter().map(move |&d| jacobian[k * n + d]))
            .collect();
        let covariance = if cluster.draws.is_empty() {
            Covariance::zeros(m)
        } else {
            c.propagate(&rows)?
        };
        (least_dof(members), Effect::Joint { covariance })
    };
    let evaluation = if members.iter().all(|i| i.evaluation == Evaluation::A) {
        Evaluation::A
    } else {
        Evaluation::B
    };
    Ok(Influence {
        key: join(|i| &i.name),
        description: join(|i| &i.description),
        evaluation,
        distribution: join(|i| i.distribution.name()),
        dof,
        effect,
    })
}

/// Inputs of one correlated group that an estimate keeps one by one; a larger group keeps its joint covariance.
const MEMBERS: usize = 200;

/// A group has one number of degrees of freedom: the least of its members is on the safe side.
fn least_dof(members: &[&crate::Input]) -> DegreesOfFreedom {
    members
        .iter()
        .map(|i| i.dof)
        .fold(DegreesOfFreedom::INFINITE, |a, b| if b < a { b } else { a })
}

/// S with S Sᵀ = C for a semi-definite C, row-major: eigenvectors times root eigenvalues.
pub(crate) fn square_root(c: &Covariance) -> Result<Vec<f64>, Error> {
    let n = c.dimension();
    let u: Vec<f64> = (0..n).map(|i| c.standard_uncertainty(i)).collect();
    let diagonal = (0..n).all(|i| (0..i).all(|j| c[(i, j)] == 0.0));
    let mut root = vec![0.0; n * n];
    if diagonal {
        (0..n).for_each(|i| root[i * n + i] = u[i]);
        return Ok(root);
    }
    // Of the correlation matrix, so that units do not matter; rounding leaves tiny negatives at zero.
    let r = faer::Mat::from_fn(n, n, |i, j| {
        c.correlation(i, j)
            .unwrap_or(if i == j { 1.0 } else { 0.0 })
    });
    let eigen = symmetric_eigen(&r, "eigenvalues of the covariance")?;
    for i in 0..n {
        for k in 0..n {
            root[i * n + k] = u[i] * eigen.U()[(i, k)] * eigen.S()[k].max(0.0).sqrt();
        }
    }
    Ok(root)
}
