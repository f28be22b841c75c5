//! Least squares of a model file through a curve: a formula of parameters and abscissa.

use super::fit::{inverse_root, whitened};
use crate::adjustment::ScaledRoot;
use crate::expression::Program;
use crate::propagation::jacobian_of;
use crate::{Covariance, Dual, LeastSquares, Model, NormalEquations, Number, Solved};

/// A curve y = f(x, parameters).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve {
    /// Results that are the abscissae and the ordinates.
    pub x: Vec<u32>,
    pub y: Vec<u32>,
    /// Variables: the parameters, the abscissa, then what else the formula speaks of.
    pub program: Program,
    /// The result of the program that is the curve.
    pub result: u32,
    /// Results of the formulas before that the formula speaks of.
    pub captured: Vec<Captured>,
    /// Where the search begins; the solution at the estimates once that is found.
    pub start: Vec<f64>,
    pub weighing: CurveWeighing,
    /// Residuals at the estimates, where these tell the scatter: its draws are about the curve, not about the points.
    pub scattered: Vec<f64>,
}

/// A result that the formula of a curve speaks of.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Captured {
    /// The same for all points.
    One(u32),
    /// One per point.
    Each(Vec<u32>),
}

/// How residuals are made comparable.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum CurveWeighing {
    Equal,
    /// As the ordinates of a polynomial.
    Ordinates(Vec<f64>),
    /// u of abscissa and ordinate of each point.
    Both(Vec<[f64; 2]>),
}

/// Steps of the search at most.
const STEPS: usize = 5000;
/// A step of the search that is small against the parameters, or against what the points leave of them.
const SETTLED: f64 = 1e-8;
/// Steps to the point of the curve that is nearest to a measured one, each of which settles one order of derivatives.
const ORDERS: usize = 5;

impl Curve {
    /// The parameters; not numbers where the search does not settle. It goes down first, so that no other place where the
    /// normal equations hold is taken for the least squares. Where the points carry no derivatives that is all.
    pub fn evaluate<T: Number>(&self, before: &[T], parameters: &mut [T]) {
        let points = self.points(before);
        let plain: Vec<f64> = points.iter().map(|p| p.value()).collect();
        match self.search(&plain) {
            Ok((found, true)) => {
                Solved::at(NormalEquations(self), found).evaluate(&points, parameters)
            }
            Ok((near, false)) => {
                Solved::new(NormalEquations(self), near).evaluate(&points, parameters)
            }
            Err(_) => parameters.fill(T::from(f64::NAN)),
        }
    }

    /// How the points are weighed, and the solution at the estimates: `covariance` is that of the abscissae, then the
    /// ordinates.
    ///
    /// What is wrong with the points or the start, in words.
    pub fn prepare(
        &mut self,
        before: &[f64],
        covariance: Option<&Covariance>,
        both: bool,
        scatter: bool,
    ) -> Result<(), String> {
        let n = self.x.len();
        let points = self.points(before);
        if points.iter().any(|p| !p.is_finite()) {
            return Err("the points are not finite numbers at the estimates".to_owned());
        }
        let needed = "the covariance of the points is not positive definite: each point needs an uncertainty of its own, or \
                      weights = \"equal\"";
        if let Some(covariance) = covariance {
            self.weighing = if both {
                // The curve through the plain points is near enough to start from.
                if let Ok((plain, true)) = self.search(&points) {
                    self.start = plain;
                }
                self.separate(covariance)?
            } else {
                let yy: Vec<f64> = (0..n * n)
                    .map(|k| covariance[(n + k / n, n + k % n)])
                    .collect();
                CurveWeighing::Ordinates(inverse_root(&yy, n).ok_or(needed)?)
            };
        }
        (self.start, _) = self.search(&points)?;
        let mut found = vec![0.0; self.start.len()];
        Solved::new(NormalEquations(&*self), self.start.clone()).evaluate(&points, &mut found);
        if found.iter().any(|p| !p.is_finite()) || !self.determined(&found, &points) {
            return Err(format!(
                "the points do not determine every parameter: the search ended near {:?}; state fewer parameters, or begin \
                 nearer in `start`",
                self.start
            ));
        }
        self.start = found;
        if scatter {
            self.scattered = self.residuals_of(before, &self.start);
        }
        Ok(())
    }

    /// u of points that are independent of each other.
    fn separate(&self, covariance: &Covariance) -> Result<CurveWeighing, String> {
        let n = self.x.len();
        let alone = (0..2 * n).all(|i| (0..i).all(|k| covariance[(i, k)] == 0.0));
        if !alone {
            return Err("weights = \"both\" of a curve is for points whose coordinates are independent of each other; \
                        weights = \"y\" takes the covariance of the ordinates"
                .to_owned());
        }
        let u: Vec<[f64; 2]> = (0..n)
            .map(|i| [i, n + i].map(|k| covariance.standard_uncertainty(k)))
            .collect();
        if u.iter().any(|[_, uy]| !(1.0 / uy).is_finite()) {
            return Err("each ordinate needs an uncertainty of its own".to_owned());
        }
        Ok(CurveWeighing::Both(u))
    }

    /// Weighted sum of the squared residuals.
    pub fn sum_of_squares(&self, before: &[f64], parameters: &[f64]) -> f64 {
        let mut r = self.residuals_of(before, parameters);
        for (r, scattered) in r.iter_mut().zip(&self.scattered) {
            *r += scattered;
        }
        r.iter().map(|r| r * r).sum()
    }

    /// Residuals at some points, weighed as the fit is.
    pub fn residuals_of(&self, before: &[f64], parameters: &[f64]) -> Vec<f64> {
        let mut r = vec![0.0; self.residuals()];
        self.residual(parameters, &self.points(before), &mut r);
        r
    }

    /// Operations of one trial, roughly.
    pub fn cost(&self) -> f64 {
        let each = match self.weighing {
            CurveWeighing::Equal => 1.0,
            CurveWeighing::Ordinates(_) => 2.0,
            CurveWeighing::Both(_) => 4.0,
        };
        let p = self.start.len() as f64;
        120.0 * p * each * (self.x.len() * (5 + self.program.ops.len())) as f64
    }

    /// Abscissae, ordinates, then what else the formula speaks of.
    fn points<T: Number>(&self, before: &[T]) -> Vec<T> {
        let more = self.captured.iter().flat_map(|captured| match captured {
            Captured::One(k) => std::slice::from_ref(k),
            Captured::Each(each) => each.as_slice(),
        });
        let places = self.x.iter().chain(&self.y).chain(more);
        places.map(|&k| before[k as usize]).collect()
    }

    /// Variables of the program, of which the parameters are known.
    fn variables<T: Number>(&self, parameters: &[T]) -> Vec<T> {
        let mut variables = parameters.to_vec();
        variables.resize(parameters.len() + 1 + self.captured.len(), T::from(0.0));
        variables
    }

    /// Puts in the variables of the program at point `i`, beside the parameters.
    fn fill<T: Number>(&self, variables: &mut [T], points: &[T], i: usize) {
        let n = self.x.len();
        let (m, mut next) = (self.start.len(), 2 * n);
        variables[m] = points[i];
        for (variable, captured) in variables[m + 1..].iter_mut().zip(&self.captured) {
            let (place, width) = match captured {
                Captured::One(_) => (next, 1),
                Captured::Each(_) => (next + i, n),
            };
            *variable = points[place];
            next += width;
        }
    }

    /// The curve at an abscissa.
    fn at<T: Number>(&self, variables: &mut [T], x: T, results: &mut Vec<T>) -> T {
        variables[self.start.len()] = x;
        results.resize(self.program.ops.len(), T::from(0.0));
        self.program
            .run(variables, results, |_, angle| angle, |_, _, _| ());
        results[self.result as usize]
    }

    /// The curve and its slope at an abscissa.
    fn slope_at<T: Number>(&self, variables: &[T], x: T, results: &mut Vec<Dual<T, 1>>) -> [T; 2] {
        let mut seeded: Vec<Dual<T, 1>> = variables
            .iter()
            .map(|&v| Dual::variable(v, usize::MAX))
            .collect();
        let f = self.at(&mut seeded, Dual::variable(x, 0), results);
        [f.real, f.partials[0]]
    }

    /// The point of the curve that is nearest to (x, y) in units of their uncertainties, in plain numbers: its abscissa, the slope of the
    /// curve, and half the second derivative of the squared distance there, in units of 1/ux².
    fn foot(&self, variables: &[f64], x: f64, y: f64, [ux, uy]: [f64; 2]) -> [f64; 3] {
        let constants: Vec<Dual<f64, 1>> = variables
            .iter()
            .map(|&v| Dual::variable(v, usize::MAX))
            .collect();
        let ratio = (ux / uy).powi(2);
        let mut results = Vec::new();
        let mut derivatives = |at: f64| {
            let [f, df] = self.slope_at(&constants, Dual::variable(at, 0), &mut results);
            let (f, df, ddf) = (f.real, df.real, df.partials[0]);
            let gradient = (x - at) + ratio * df * (y - f);
            let plain = 1.0 + ratio * df * df;
            let full = plain - ratio * ddf * (y - f);
            // Far from the curve only the first part is sure to lead towards it.
            (gradient, df, if full > 0.1 * plain { full } else { plain })
        };
        let mut near = x;
        for _ in 0..60 {
            let (gradient, _, curvature) = derivatives(near);
            let step = gradient / curvature;
            near += step;
            // The distance feels the square of what is left.
            if !(step.abs() > 1e-15 * near.abs() + 1e-9 * ux) {
                break;
            }
        }
        let (_, slope, curvature) = derivatives(near);
        [near, slope, curvature]
    }

    /// The abscissa of the nearest point of the curve and the slope there, exactly as differentiable as the points are.
    fn nearest<T: Number>(&self, variables: &[T], x: T, y: T, u: [f64; 2]) -> [T; 2] {
        let plain: Vec<f64> = variables.iter().map(|v| v.value()).collect();
        let [near, _, curvature] = self.foot(&plain, x.value(), y.value(), u);
        let ratio = T::from((u[0] / u[1]).powi(2));
        let mut results = Vec::new();
        let mut point = T::from(near);
        for _ in 0..ORDERS {
            let [f, df] = self.slope_at(variables, point, &mut results);
            point = point + ((x - point) + ratio * df * (y - f)) / T::from(curvature);
        }
        let [_, slope] = self.slope_at(variables, point, &mut results);
        [point, slope]
    }

    /// The distance of a point to the tangent that touches the curve at an abscissa, in units of its uncertainty. It is the distance to
    /// the curve where the tangent touches at the nearest point.
    fn distance<T: Number>(
        &self,
        variables: &mut [T],
        [x, y]: [T; 2],
        [near, slope]: [T; 2],
        [ux, uy]: [f64; 2],
        results: &mut Vec<T>,
    ) -> T {
        let across = T::from(uy * uy) + slope * slope * T::from(ux * ux);
        (y - self.at(variables, near, results) - slope * (x - near)) / across.sqrt()
    }

    /// Residuals and their derivatives by the parameters; `None` where these are not finite.
    ///
    /// With errors in both variables the tangents hold still: the derivatives of the distances to them are those of the distances to
    /// the curve, for the sum of squares, and those of the nearest points are not needed.
    fn equations(&self, at: &[f64], points: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let n = self.x.len();
        let constants: Vec<Dual<f64, 8>> = points.iter().map(|&p| Dual::from(p)).collect();
        let CurveWeighing::Both(u) = &self.weighing else {
            return jacobian_of::<8>(at, n, |p, r| self.residual(p, &constants, r)).ok();
        };
        let mut variables = self.variables(at);
        let tangents: Vec<[f64; 2]> = (0..n)
            .map(|i| {
                self.fill(&mut variables, points, i);
                let [near, slope, _] = self.foot(&variables, points[i], points[n + i], u[i]);
                [near, slope]
            })
            .collect();
        let distances = |p: &[Dual<f64, 8>], r: &mut [Dual<f64, 8>]| {
            let (mut variables, mut results) = (self.variables(p), Vec::new());
            for (i, tangent) in tangents.iter().enumerate() {
                self.fill(&mut variables, &constants, i);
                let point = [constants[i], constants[n + i]];
                r[i] = self.distance(
                    &mut variables,
                    point,
                    tangent.map(Dual::from),
                    u[i],
                    &mut results,
                );
            }
        };
        jacobian_of::<8>(at, n, distances).ok()
    }

    /// Whether the points tell every parameter from the others.
    fn determined(&self, at: &[f64], points: &[f64]) -> bool {
        let m = at.len();
        let Some((_, jacobian)) = self.equations(at, points) else {
            return false;
        };
        let normal = |i: usize, j: usize| -> f64 {
            let rows = jacobian.chunks_exact(m);
            rows.map(|row| row[i] * row[j]).sum()
        };
        ScaledRoot::new(m, normal).is_some()
    }

    /// Levenberg and Marquardt's descent from the start; whether its last step was small.
    fn search(&self, points: &[f64]) -> Result<(Vec<f64>, bool), String> {
        let m = self.start.len();
        let equations = |at: &[f64]| self.equations(at, points);
        let sum_of_squares = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
        let mut here = self.start.clone();
        let Some((mut residual, mut jacobian)) = equations(&here) else {
            return Err(format!(
                "the curve has no finite value or slope at `start` = {here:?}; begin elsewhere"
            ));
        };
        let mut cost = sum_of_squares(&residual);
        let mut damping = 1e-3;
        for _ in 0..STEPS {
            let normal = |i: usize, j: usize| -> f64 {
                let rows = jacobian.chunks_exact(m);
                let sum: f64 = rows.map(|row| row[i] * row[j]).sum();
                if i == j { sum * (1.0 + damping) } else { sum }
            };
            let gradient: Vec<f64> = (0..m)
                .map(|i| {
                    let rows = jacobian.chunks_exact(m);
                    rows.zip(&residual).map(|(row, r)| row[i] * r).sum()
                })
                .collect();
            let step = ScaledRoot::new(m, normal).map(|root| root.solve(&gradient));
            let small = damping < 1e-2
                && step.as_ref().is_some_and(|step| {
                    let gain: f64 = step.iter().zip(&gradient).map(|(s, g)| s * g).sum();
                    gain <= SETTLED * SETTLED * cost
                        || step
                            .iter()
                            .zip(&here)
                            .all(|(s, p)| s.abs() <= SETTLED * p.abs())
                });
            let there: Option<Vec<f64>> =
                step.map(|step| here.iter().zip(step).map(|(p, s)| p - s).collect());
            let better = there.and_then(|there| {
                let (r, j) = equations(&there)?;
                let lower = sum_of_squares(&r);
                (lower < cost).then_some((there, r, j, lower))
            });
            if let Some((there, r, j, lower)) = better {
                let gained = 1.0 - lower / cost;
                (here, residual, jacobian, cost) = (there, r, j, lower);
                damping = (0.1 * damping).max(1e-15);
                if small || (gained < 1e-14 && damping < 1e-6) {
                    return Ok((here, small));
                }
            } else if small {
                return Ok((here, true));
            } else {
                damping = (10.0 * damping).max(1e-9);
                // No direction leads down any more.
                if damping > 1e12 {
                    break;
                }
            }
        }
        Ok((here, false))
    }
}

impl LeastSquares for Curve {
    fn outputs(&self) -> Vec<(String, String)> {
        vec![Default::default(); self.start.len()]
    }

    fn residuals(&self) -> usize {
        self.x.len()
    }

    fn residual<T: Number>(&self, parameters: &[T], points: &[T], r: &mut [T]) {
        let n = self.x.len();
        let (mut variables, mut results) = (self.variables(parameters), Vec::new());
        for i in 0..n {
            let [x, y] = [points[i], points[n + i]];
            self.fill(&mut variables, points, i);
            r[i] = if let CurveWeighing::Both(u) = &self.weighing {
                let tangent = self.nearest(&variables, x, y, u[i]);
                self.distance(&mut variables, [x, y], tangent, u[i], &mut results)
            } else {
                y - self.at(&mut variables, x, &mut results)
            };
        }
        for (r, &scattered) in r.iter_mut().zip(&self.scattered) {
            *r = *r - T::from(scattered);
        }
        if let CurveWeighing::Ordinates(rows) = &self.weighing {
            let white = whitened(Some(rows), r.to_vec());
            r.copy_from_slice(&white);
        }
    }
}
