//! Fits of many points by Monte Carlo: what many normal draws do to a few parameters is drawn as the parameters.

use super::equations::{Block, Equations};
use super::fit::Weighing;
use crate::expression::Op;
use crate::input::{Cluster, Doubt, Draw};
use crate::propagation::derivatives;
use crate::{Covariance, DegreesOfFreedom, Distribution, Dual, Input, JointInputs, Refusal};

/// Points from which it pays.
const MANY: usize = 32;

impl Op {
    /// The results it takes.
    pub(super) fn operands(&self) -> [Option<u32>; 3] {
        match *self {
            Self::Constant(_) | Self::Input(_) | Self::Block(_) | Self::Further => [None; 3],
            Self::Negate(a) | Self::IntegerPower(a, _) | Self::Call(_, a) => [Some(a), None, None],
            Self::Add(a, b)
            | Self::Subtract(a, b)
            | Self::Multiply(a, b)
            | Self::Divide(a, b)
            | Self::Power(a, b)
            | Self::Atan2(a, b, _)
            | Self::Minimum(a, b)
            | Self::Maximum(a, b)
            | Self::Hypotenuse(a, b)
            | Self::Compare(_, a, b) => [Some(a), Some(b), None],
            Self::Select(a, b, c) => [Some(a), Some(b), Some(c)],
        }
    }

    /// The same with other numbers of its operands.
    fn renumbered(self, to: impl Fn(u32) -> u32) -> Self {
        match self {
            Self::Negate(a) => Self::Negate(to(a)),
            Self::Add(a, b) => Self::Add(to(a), to(b)),
            Self::Subtract(a, b) => Self::Subtract(to(a), to(b)),
            Self::Multiply(a, b) => Self::Multiply(to(a), to(b)),
            Self::Divide(a, b) => Self::Divide(to(a), to(b)),
            Self::Power(a, b) => Self::Power(to(a), to(b)),
            Self::IntegerPower(a, n) => Self::IntegerPower(to(a), n),
            Self::Call(function, a) => Self::Call(function, to(a)),
            Self::Atan2(a, b, number) => Self::Atan2(to(a), to(b), number),
            Self::Minimum(a, b) => Self::Minimum(to(a), to(b)),
            Self::Maximum(a, b) => Self::Maximum(to(a), to(b)),
            Self::Hypotenuse(a, b) => Self::Hypotenuse(to(a), to(b)),
            Self::Compare(relation, a, b) => Self::Compare(relation, to(a), to(b)),
            Self::Select(a, b, c) => Self::Select(to(a), to(b), to(c)),
            Self::Constant(_) | Self::Input(_) | Self::Block(_) | Self::Further => self,
        }
    }
}

/// Draws that are one multivariate normal or t as a whole.
#[derive(Clone, Copy, PartialEq)]
enum Family {
    Normal,
    /// Draws of one input, which share the estimate of their σ.
    StudentT(usize, f64),
}

/// A fit whose parameters are drawn: the place of its first, their values, and their covariance by family.
struct Drawn {
    place: usize,
    values: Vec<f64>,
    covariances: Vec<(Family, Covariance)>,
}

impl Equations {
    /// Equations and inputs of the same joint distribution of the outputs, with fewer draws: a polynomial with fixed weights
    /// through points of fixed abscissae is linear in its ordinates, and where these are draws that nothing else uses, normal
    /// or of one Student t, its parameters are normal or t as well. `None` where no fit is such.
    ///
    /// # Errors
    /// A covariance that is none.
    pub(crate) fn reduced(
        &self,
        joint: &JointInputs,
    ) -> Result<Option<(Self, JointInputs)>, Refusal> {
        let (uses, varies) = (self.uses(), self.varies(joint));
        let mut fits = Vec::new();
        let mut gone = vec![false; joint.draws.len()];
        for (number, block) in self.blocks().iter().enumerate() {
            let Block::Fit(fit) = block else { continue };
            let fixed = !matches!(fit.weighing, Weighing::Both(..));
            if fit.y.len() < MANY || !fixed || fit.x.iter().any(|&k| varies[k as usize]) {
                continue;
            }
            let mut draws: Vec<Vec<usize>> = Vec::new();
            let whole = fit.y.iter().all(|&y| {
                let mut found = Vec::new();
                let alone = self.sum_of_draws(y, &uses, &varies, &mut found);
                draws.push(found);
                alone
            });
            let taken: Vec<usize> = draws.iter().flatten().copied().collect();
            let Some(families) = families(joint, &taken).filter(|_| whole) else {
                continue;
            };
            let x = joint.estimates();
            let place = self.place_of(number);
            let mut before = vec![0.0; place];
            self.run(&x, &mut before);
            let y: Vec<f64> = fit.y.iter().map(|&k| before[k as usize]).collect();
            let (values, slopes) = derivatives::<8>(&y, fit.degree + 1, |y, parameters| {
                let mut results: Vec<Dual<f64, 8>> =
                    before.iter().map(|b| Dual::from(*b)).collect();
                for (&place, y) in fit.y.iter().zip(y) {
                    results[place as usize] = *y;
                }
                fit.evaluate(&results, parameters);
            });
            if values.iter().chain(&slopes).any(|v| !v.is_finite()) {
                continue;
            }
            let covariances = families
                .into_iter()
                .map(|(family, members)| {
                    let c = parameters_covariance(joint, &draws, &members, &slopes, values.len())?;
                    Ok((family, c))
                })
                .collect::<Result<Vec<_>, Refusal>>()?;
            taken.iter().for_each(|&d| gone[d] = true);
            fits.push(Drawn {
                place,
                values,
                covariances,
            });
        }
        if fits.is_empty() {
            return Ok(None);
        }
        Ok(Some(self.with_drawn(joint, &fits, &gone)?))
    }

    /// How often each result is taken.
    fn uses(&self) -> Vec<usize> {
        let mut uses = vec![0; self.program().ops.len()];
        let operands = self.program().ops.iter().flat_map(Op::operands).flatten();
        let blocks = self.blocks().iter().flat_map(Block::takes);
        for k in operands.chain(blocks).chain(self.places().iter().copied()) {
            uses[k as usize] += 1;
        }
        uses
    }

    /// Whether each result varies with an input.
    fn varies(&self, joint: &JointInputs) -> Vec<bool> {
        let mut varies: Vec<bool> = Vec::with_capacity(self.program().ops.len());
        for op in &self.program().ops {
            varies.push(match op {
                Op::Input(i) => joint
                    .draws
                    .get(*i)
                    .is_none_or(|d| d.standard_uncertainty > 0.0),
                Op::Block(number) => self.blocks()[*number].takes().any(|k| varies[k as usize]),
                Op::Further => varies.last().copied().unwrap_or(true),
                other => other
                    .operands()
                    .into_iter()
                    .flatten()
                    .any(|k| varies[k as usize]),
            });
        }
        varies
    }

    /// The draws whose plain sum, with what does not vary, a result is; `false` where it is something else, or another takes
    /// a part of it.
    fn sum_of_draws(
        &self,
        k: u32,
        uses: &[usize],
        varies: &[bool],
        found: &mut Vec<usize>,
    ) -> bool {
        if !varies[k as usize] {
            return true;
        }
        if uses[k as usize] != 1 {
            return false;
        }
        match self.program().ops[k as usize] {
            Op::Input(draw) => {
                found.push(draw);
                true
            }
            Op::Add(a, b) => {
                self.sum_of_draws(a, uses, varies, found)
                    && self.sum_of_draws(b, uses, varies, found)
            }
            _ => false,
        }
    }

    /// The equations with drawn parameters in place of the fits, without what is no longer needed.
    fn with_drawn(
        &self,
        joint: &JointInputs,
        fits: &[Drawn],
        gone: &[bool],
    ) -> Result<(Self, JointInputs), Refusal> {
        // Draws that stay, then those of the parameters.
        let mut inputs = joint.clone();
        let mut number = vec![usize::MAX; gone.len()];
        inputs.draws = Vec::new();
        for (d, draw) in joint.draws.iter().enumerate().filter(|(d, _)| !gone[*d]) {
            number[d] = inputs.draws.len();
            inputs.draws.push(draw.clone());
        }
        inputs
            .clusters
            .retain(|c| c.draws.iter().all(|d| !gone[*d]));
        for draw in inputs.clusters.iter_mut().flat_map(|c| &mut c.draws) {
            *draw = number[*draw];
        }
        let drawn: Vec<Vec<Vec<usize>>> = fits
            .iter()
            .map(|fit| inputs.drawn(fit))
            .collect::<Result<_, _>>()?;
        // Results that are needed, from the last back.
        let ops = &self.program().ops;
        let fit_at = |place: usize| {
            fits.iter()
                .position(|f| (f.place..f.place + f.values.len()).contains(&place))
        };
        let mut needed = vec![false; ops.len()];
        self.places()
            .iter()
            .for_each(|&k| needed[k as usize] = true);
        for k in (0..ops.len()).rev() {
            // The first of several results stands for all.
            if matches!(ops[k], Op::Further) && needed[k] {
                needed[k - 1] = true;
            }
            if !needed[k] || fit_at(k).is_some() {
                continue;
            }
            match ops[k] {
                Op::Block(number) => self.blocks()[number]
                    .takes()
                    .for_each(|k| needed[k as usize] = true),
                op => op
                    .operands()
                    .into_iter()
                    .flatten()
                    .for_each(|k| needed[k as usize] = true),
            }
        }
        for k in 1..ops.len() {
            needed[k] |= matches!(ops[k], Op::Further) && needed[k - 1];
        }
        let mut place = vec![0u32; ops.len()];
        let mut program = crate::expression::Program {
            ops: Vec::new(),
            angles: self.program().angles,
            labels: Vec::new(),
        };
        for (k, op) in ops.iter().enumerate().filter(|(k, _)| needed[*k]) {
            let mut push = |op| {
                program.ops.push(op);
                (program.ops.len() - 1) as u32
            };
            place[k] = match (fit_at(k), *op) {
                (Some(f), _) => {
                    let which = k - fits[f].place;
                    let mut sum = push(Op::Constant(fits[f].values[which]));
                    for family in &drawn[f] {
                        let draw = push(Op::Input(family[which]));
                        sum = push(Op::Add(sum, draw));
                    }
                    sum
                }
                (None, Op::Input(i)) => push(Op::Input(number.get(i).copied().unwrap_or(i))),
                (None, op) => push(op.renumbered(|k| place[k as usize])),
            };
        }
        let blocks = self.blocks().iter().map(|b| b.renumbered(&place)).collect();
        let places = self.places().iter().map(|&k| place[k as usize]).collect();
        Ok((self.rewritten(places, program, blocks), inputs))
    }
}

impl JointInputs {
    /// Adds the draws of the parameters of a fit: by family, one for each.
    fn drawn(&mut self, fit: &Drawn) -> Result<Vec<Vec<usize>>, Refusal> {
        let mut all = Vec::new();
        for (family, covariance) in &fit.covariances {
            let n = covariance.dimension();
            let mut correlation = Covariance::zeros(n);
            let (mut draws, mut members) = (Vec::new(), Vec::new());
            for i in 0..n {
                for j in 0..n {
                    let unit = f64::from(u8::from(i == j));
                    correlation.set(i, j, covariance.correlation(i, j).unwrap_or(unit));
                }
                let u = covariance.standard_uncertainty(i);
                let name = format!("parameter {} of the fit at {}", i + 1, fit.place);
                let (distribution, dof) = match family {
                    Family::Normal => (Distribution::Normal { mean: 0.0, u }, f64::INFINITY),
                    Family::StudentT(_, dof) => {
                        let t = Distribution::StudentT {
                            location: 0.0,
                            scale: u,
                            dof: *dof,
                        };
                        (t, *dof)
                    }
                };
                let dof = DegreesOfFreedom::new(dof).unwrap_or(DegreesOfFreedom::INFINITE);
                self.draws.push(Draw {
                    name: name.clone(),
                    input: self.inputs.len(),
                    labels: Vec::new(),
                    estimate: 0.0,
                    standard_uncertainty: u,
                });
                draws.push(self.draws.len() - 1);
                members.push(self.inputs.len());
                self.inputs
                    .push(Input::new(name, "1", distribution).dof(dof));
            }
            self.together.push(members.clone());
            self.clusters.push(Cluster {
                draws: draws.clone(),
                inputs: members,
                correlation: Some(correlation),
            });
            all.push(draws);
        }
        Ok(all)
    }
}

/// The draws by family, where all belong to one and bring everything along that they are correlated with.
fn families(joint: &JointInputs, draws: &[usize]) -> Option<Vec<(Family, Vec<usize>)>> {
    let mut taken = vec![false; joint.draws.len()];
    draws.iter().for_each(|&d| taken[d] = true);
    let mut families: Vec<(Family, Vec<usize>)> = Vec::new();
    for cluster in &joint.clusters {
        let inside = cluster.draws.iter().filter(|d| taken[**d]).count();
        if inside == 0 {
            continue;
        }
        if inside < cluster.draws.len() {
            return None;
        }
        for &d in &cluster.draws {
            let input = joint.draws[d].input;
            if joint.rows.iter().any(|row| row.contains(&input)) {
                return None;
            }
            let family = match joint.inputs[input].drawn_from() {
                (Distribution::Normal { .. }, Doubt::None) => Family::Normal,
                (Distribution::StudentT { dof, .. }, _) if cluster.inputs.len() == 1 => {
                    Family::StudentT(input, dof)
                }
                _ => return None,
            };
            match families.iter_mut().find(|(f, _)| *f == family) {
                Some((_, members)) => members.push(d),
                None => families.push((family, vec![d])),
            }
        }
    }
    // Each family becomes some draws: that pays for few of them.
    (families.len() <= 4).then_some(families)
}

/// Covariance of the parameters from some of the draws.
fn parameters_covariance(
    joint: &JointInputs,
    of_points: &[Vec<usize>],
    members: &[usize],
    slopes: &[f64],
    p: usize,
) -> Result<Covariance, Refusal> {
    let n = of_points.len();
    let mut point = vec![usize::MAX; joint.draws.len()];
    for (k, draws) in of_points.iter().enumerate() {
        draws.iter().for_each(|&d| point[d] = k);
    }
    let mut mine = vec![false; joint.draws.len()];
    members.iter().for_each(|&d| mine[d] = true);
    // What a draw does to each parameter, in its standard uncertainty.
    let effect =
        |i: usize, d: usize| slopes[i * n + point[d]] * joint.draws[d].standard_uncertainty;
    let mut sum = vec![0.0; p * p];
    for cluster in joint
        .clusters
        .iter()
        .filter(|c| c.draws.iter().any(|d| mine[*d]))
    {
        for i in 0..p {
            for j in 0..=i {
                let mut v = 0.0;
                for (a, &d) in cluster.draws.iter().enumerate() {
                    v += match &cluster.correlation {
                        None => effect(i, d) * effect(j, d),
                        Some(r) => {
                            let others = cluster.draws.iter().enumerate();
                            effect(i, d)
                                * others.map(|(b, &e)| r[(a, b)] * effect(j, e)).sum::<f64>()
                        }
                    };
                }
                sum[i * p + j] += v;
            }
        }
    }
    for i in 0..p {
        for j in 0..i {
            sum[j * p + i] = sum[i * p + j];
        }
    }
    Ok(Covariance::try_from_rows(p, &sum)?)
}
