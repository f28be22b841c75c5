//! An implicit model as an ordinary one, so that Monte Carlo and everything else can run it.

use crate::implicit::{Branch, Root};
use crate::{Dual, Implicit, LeastSquares, Model, Number};
use proofmass_core::Error;

/// A model h(y, x) = 0 that is solved for y at every evaluation.
///
/// y₀ comes from Newton's iteration on plain numbers. Two steps y ← y − (∂h/∂y)⁻¹ h(y, x) over numbers that carry
/// derivatives then give first and second derivatives exactly, for each step settles one order more.
///
/// A fit becomes such a model through [`NormalEquations`]. Where the iteration does not settle the outputs are not
/// numbers, which every user of a [`Model`] refuses.
///
/// ```
/// use proofmass_uncertainty::*;
/// /// y³ + y = x
/// struct Cubic;
/// impl Implicit for Cubic {
///     fn outputs(&self) -> Vec<(String, String)> { vec![("y".into(), "1".into())] }
///     fn residual<T: Number>(&self, y: &[T], x: &[T], h: &mut [T]) { h[0] = y[0].powi(3) + y[0] - x[0]; }
/// }
/// let x = Input::new("x", "1", Distribution::Normal { mean: 10.0, u: 0.13 });
/// let inputs = Inputs::new().add(x).single()?;
/// let sampled = MonteCarlo::new(1).trials(Trials::Fixed(100_000)).run(&Solved::new(Cubic, vec![2.0]), &inputs)?;
/// let y = sampled.get("y").unwrap();
/// assert!((y.mean - 2.0).abs() < 5e-4);
/// assert!((y.standard_uncertainty.unwrap() - 0.13 / 13.0).abs() < 1e-4);
/// # Ok::<(), Refusal>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Solved<M> {
    model: M,
    start: Vec<f64>,
    branch: Option<Branch>,
    /// The start is the solution at the inputs that come.
    found: bool,
}

impl<M: Implicit> Solved<M> {
    /// A model and the y its solution starts from, best the solution at the estimates.
    pub fn new(model: M, start: Vec<f64>) -> Self {
        Self {
            model,
            start,
            branch: None,
            found: false,
        }
    }

    /// As [`Solved::new`], where `solution` was found for the very inputs that come: without derivatives it is the result.
    #[cfg(feature = "model")]
    pub(crate) fn at(model: M, solution: Vec<f64>) -> Self {
        Self {
            found: true,
            ..Self::new(model, solution)
        }
    }

    /// The same equations, with the solution followed from the one at these inputs along a straight line: it stays on its branch,
    /// and where the branch ends before the inputs are reached the outputs are not numbers. `scale` holds sizes of the unknowns,
    /// which matter where a solution is zero.
    ///
    /// # Errors
    /// [`Error::NotFinite`] where the equations have no derivative there.
    pub fn continued(mut self, inputs: &[f64], scale: &[f64]) -> Result<Self, Error> {
        self.branch = Some(Branch::of(&self.model, &self.start, inputs, scale)?);
        Ok(self)
    }

    /// As [`Solved::continued`], by a branch that is known.
    #[cfg(feature = "model")]
    pub(crate) fn on(model: M, start: Vec<f64>, branch: Option<Branch>) -> Self {
        Self {
            model,
            start,
            branch,
            found: false,
        }
    }
}

impl<M: Implicit> Model for Solved<M> {
    fn outputs(&self) -> Vec<(String, String)> {
        self.model.outputs()
    }

    fn evaluate<T: Number>(&self, x: &[T], y: &mut [T]) {
        y.fill(T::from(f64::NAN));
        let plain: Vec<f64> = x.iter().map(|x| x.value()).collect();
        if plain.iter().any(|x| !x.is_finite()) {
            return;
        }
        let alone = |(x, plain): (&T, &f64)| (*x - T::from(*plain)).vanishes();
        if self.found && x.iter().zip(&plain).all(alone) {
            for (y, &found) in y.iter_mut().zip(&self.start) {
                *y = T::from(found);
            }
            return;
        }
        let root = match &self.branch {
            Some(branch) => Root::follow(&self.model, branch, &plain),
            None => Root::find(&self.model, &self.start, &plain),
        };
        let Ok(root) = root else {
            return;
        };
        let m = self.start.len();
        if !root.settled() || y.len() != m {
            return;
        }
        let mut inverse = Vec::with_capacity(m);
        for k in 0..m {
            let unit: Vec<f64> = (0..m).map(|i| f64::from(u8::from(i == k))).collect();
            match root.slope.solve(&unit) {
                Ok(column) => inverse.push(column),
                Err(_) => return,
            }
        }
        let mut solution: Vec<T> = root.y.iter().map(|&y| T::from(y)).collect();
        let mut h = vec![T::from(0.0); m];
        for _ in 0..2 {
            self.model.residual(&solution, x, &mut h);
            for (k, y) in solution.iter_mut().enumerate() {
                for (column, h) in inverse.iter().zip(&h) {
                    *y = *y - T::from(column[k]) * *h;
                }
            }
        }
        y.copy_from_slice(&solution);
    }
}

/// A fit as the equations its solution obeys: Σ r_i ∂r_i/∂y_k = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalEquations<M>(pub M);

impl<M: LeastSquares> Implicit for NormalEquations<M> {
    fn outputs(&self) -> Vec<(String, String)> {
        self.0.outputs()
    }

    fn residual<T: Number>(&self, y: &[T], x: &[T], h: &mut [T]) {
        let constant: Vec<Dual<T, 1>> = x.iter().map(|&x| Dual::variable(x, usize::MAX)).collect();
        let mut r = vec![Dual::<T, 1>::from(0.0); self.0.residuals()];
        for k in 0..y.len() {
            let seeded: Vec<Dual<T, 1>> = y
                .iter()
                .enumerate()
                .map(|(i, &y)| Dual::variable(y, if i == k { 0 } else { usize::MAX }))
                .collect();
            self.0.residual(&seeded, &constant, &mut r);
            h[k] = r
                .iter()
                .fold(T::from(0.0), |sum, r| sum + r.real * r.partials[0]);
        }
    }
}

impl<M: LeastSquares> LeastSquares for &M {
    fn outputs(&self) -> Vec<(String, String)> {
        M::outputs(self)
    }
    fn residuals(&self) -> usize {
        M::residuals(self)
    }
    fn residual<T: Number>(&self, y: &[T], x: &[T], r: &mut [T]) {
        M::residual(self, y, x, r);
    }
}
