//! The equations of a fit with terms beyond the matrix: through the compensation itself.

use super::problem::Problem;
use crate::Triple;
use proofmass_core::{Compensation, Error, Matrix3, SensorModel, dot, norm};
use proofmass_uncertainty::adjustment::Equations;

impl Problem<'_> {
    /// The compensation in natural units, temperatures as z.
    pub(crate) fn compensation(&self, parameters: &[f64]) -> Result<Compensation<f64>, Error> {
        let p = self.model.parameters();
        let sensor = SensorModel::new(
            Matrix3(self.model.matrix(parameters)),
            [parameters[0], parameters[1], parameters[2]],
        )?;
        let (thermal, curvature) = self.terms.coefficients(&parameters[p..]);
        // A step of the fit may pass through a curvature that nobody would state: the limit is that of the result.
        Ok(Compensation::constant(
            sensor,
            (!self.terms.list.is_empty()).then_some(thermal),
            self.terms.curvature.then_some(curvature),
        ))
    }

    /// Compensated acceleration of every standstill, in units of g.
    pub(crate) fn accelerations(&self, parameters: &[f64]) -> Result<Vec<Triple>, Error> {
        let compensation = self.compensation(parameters)?;
        (0..self.poses.len())
            .map(|index| {
                let a = compensation.apply(self.point(index), self.terms.z[index]);
                if a.iter().all(|v| v.is_finite()) {
                    Ok(a)
                } else {
                    Err(Error::NotFinite {
                        name: "acceleration of a standstill",
                        index,
                    })
                }
            })
            .collect()
    }

    /// Residuals alone, as [`Problem::equations`] has them, of every term.
    fn residuals_of_terms(
        &self,
        parameters: &[f64],
        rotations: &[[Triple; 3]],
    ) -> Result<Vec<f64>, Error> {
        let Some(attitudes) = &self.attitudes else {
            let all = self.accelerations(parameters)?;
            return Ok(all.into_iter().map(|a| norm(a) - 1.0).collect());
        };
        let compensation = self.compensation(parameters)?;
        let mut residuals = Vec::with_capacity(self.rows());
        for (index, (u, rotation)) in attitudes.iter().zip(rotations).enumerate() {
            let expected = compensation.invert(*u, self.terms.z[index]);
            let y = self.point(index);
            let off = std::array::from_fn(|i| y[i] - expected[i]);
            residuals.extend(rotation.map(|axis| dot(axis, off)));
        }
        Ok(residuals)
    }

    /// Residuals and their derivatives, these by differences: exact to ten digits, which a step of the fit corrects.
    pub(crate) fn equations_of_terms(
        &self,
        parameters: &[f64],
        rotations: &[[Triple; 3]],
    ) -> Result<Equations, Error> {
        const STEP: f64 = 1e-6;
        let residual = self.residuals_of_terms(parameters, rotations)?;
        let p = parameters.len();
        let mut jacobian = vec![0.0; residual.len() * p];
        let mut beside = parameters.to_vec();
        for c in 0..p {
            beside[c] = parameters[c] + STEP;
            let above = self.residuals_of_terms(&beside, rotations)?;
            beside[c] = parameters[c] - STEP;
            let below = self.residuals_of_terms(&beside, rotations)?;
            beside[c] = parameters[c];
            for (row, (a, b)) in above.iter().zip(&below).enumerate() {
                jacobian[row * p + c] = (a - b) / (2.0 * STEP);
            }
        }
        Ok(Equations { residual, jacobian })
    }
}
