//! The linear model of a triaxial accelerometer, and the compensation that undoes it.

use crate::{Error, Float, Matrix3, check};

/// ã = K a + b: output ã of a triaxial accelerometer under the specific force a.
///
/// K holds scale factors on its diagonal and misalignment (cross-axis) terms beside it, b the bias in output
/// units. The same [`apply`](Self::apply) runs on the desk and in firmware, without allocation.
///
/// **Units** K: output unit per m/s²; b: output unit; acceleration: m/s².
///
/// ```
/// use proofmass_core::{Matrix3, SensorModel};
///
/// let k = Matrix3([[415.0, 1.2, 0.0], [0.0, 413.0, -0.8], [0.0, 0.0, 415.0]]);
/// let model = SensorModel::<f64>::new(k, [33123.0, 33276.0, 32360.0])?;
/// let output = model.invert([0.0, 0.0, 9.81744]);
/// let a = model.apply(output);
/// assert!((a[2] - 9.81744).abs() < 1e-11);
/// # Ok::<(), proofmass_core::Error>(())
/// ```
#[doc(alias(
    "calibration matrix",
    "compensation",
    "bias",
    "scale factor",
    "misalignment"
))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(
        into = "Coefficients<F>",
        try_from = "Coefficients<F>",
        bound(
            serialize = "F: Float + serde::Serialize",
            deserialize = "F: Float + serde::Deserialize<'de>"
        )
    )
)]
pub struct SensorModel<F> {
    k: Matrix3<F>,
    k_inverse: Matrix3<F>,
    bias: [F; 3],
}

impl<F: Float> SensorModel<F> {
    /// From the sensitivity matrix K and the bias b.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for an element that is not a number, [`Error::Singular`] when K has no inverse.
    pub fn new(k: Matrix3<F>, bias: [F; 3]) -> Result<Self, Error> {
        if let Some(index) = bias.iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite {
                name: "bias",
                index,
            });
        }
        Ok(Self {
            k,
            k_inverse: k.inverse()?,
            bias,
        })
    }

    /// From K, its inverse and the bias, as a constant of firmware: nothing is computed and nothing is checked.
    ///
    /// An export writes all three; a test beside it that compares with [`SensorModel::new`] is a good habit.
    pub const fn constant(k: Matrix3<F>, k_inverse: Matrix3<F>, bias: [F; 3]) -> Self {
        Self { k, k_inverse, bias }
    }

    /// Compensation, a = K⁻¹ (ã − b): acceleration from the sensor's output.
    ///
    /// **Accuracy** in `f32` the error stays below 4 ε (‖ã‖ + ‖b‖) ‖K⁻¹‖: for a 16-bit sensor of ±2 g with an
    /// offset at mid-scale this is 0.08 mm/s² (`law_single_precision_stays_within_its_bound`).
    ///
    /// A NaN or infinite output gives a NaN or infinite acceleration: on a chip nobody could be told. Readers
    /// on the desk refuse such outputs before they come here.
    #[inline]
    pub fn apply(&self, output: [F; 3]) -> [F; 3] {
        let b = &self.bias;
        self.k_inverse
            .times([output[0] - b[0], output[1] - b[1], output[2] - b[2]])
    }

    /// Compensation of whole columns, to the bit what [`apply`](Self::apply) gives sample by sample.
    ///
    /// # Errors
    /// [`Error::Length`] unless all six columns are equally long.
    pub fn apply_columns(
        &self,
        outputs: [&[F]; 3],
        accelerations: [&mut [F]; 3],
    ) -> Result<(), Error> {
        let [x, y, z] = outputs;
        let [ax, ay, az] = accelerations;
        let n = x.len();
        check::columns(n, [y.len(), z.len()], [ax.len(), ay.len(), az.len()])?;
        // Slices of one length in lock step: the compiler makes vector instructions of it.
        let inputs = x.iter().zip(y).zip(z);
        let results = ax.iter_mut().zip(ay).zip(az);
        for (((x, y), z), ((ax, ay), az)) in inputs.zip(results) {
            [*ax, *ay, *az] = self.apply([*x, *y, *z]);
        }
        Ok(())
    }

    /// The sensor itself, ã = K a + b: output from acceleration.
    #[inline]
    pub fn invert(&self, acceleration: [F; 3]) -> [F; 3] {
        let o = self.k.times(acceleration);
        let b = &self.bias;
        [o[0] + b[0], o[1] + b[1], o[2] + b[2]]
    }

    /// Sensitivity matrix K, output unit per m/s².
    pub fn k(&self) -> &Matrix3<F> {
        &self.k
    }

    /// Inverse of K, m/s² per output unit.
    pub fn k_inverse(&self) -> &Matrix3<F> {
        &self.k_inverse
    }

    /// Bias b in output units.
    pub fn bias(&self) -> [F; 3] {
        self.bias
    }

    /// The same model in the other precision.
    ///
    /// K⁻¹ is converted, not computed anew, so that single precision carries only the rounding of its elements.
    pub fn cast<G: Float>(&self) -> SensorModel<G> {
        SensorModel {
            k: self.k.cast(),
            k_inverse: self.k_inverse.cast(),
            bias: self.bias.map(|v| G::from_f64(v.to_f64())),
        }
    }
}

/// The form in a file: what cannot be derived from the rest.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
struct Coefficients<F> {
    k: Matrix3<F>,
    bias: [F; 3],
}

#[cfg(feature = "serde")]
impl<F: Float> From<SensorModel<F>> for Coefficients<F> {
    fn from(model: SensorModel<F>) -> Self {
        Self {
            k: model.k,
            bias: model.bias,
        }
    }
}

#[cfg(feature = "serde")]
impl<F: Float> TryFrom<Coefficients<F>> for SensorModel<F> {
    type Error = Error;

    fn try_from(c: Coefficients<F>) -> Result<Self, Error> {
        Self::new(c.k, c.bias)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn xsens() -> SensorModel<f64> {
        let k = Matrix3([[414.4, 1.3, -0.9], [0.0, 412.0, 2.1], [0.0, 0.0, 414.6]]);
        SensorModel::new(k, [33123.9, 33275.2, 32364.5]).unwrap()
    }

    #[test]
    fn law_apply_undoes_invert() {
        let model = xsens();
        for i in 0..1000 {
            let t = f64::from(i) * 0.37;
            let a = [9.8 * t.sin(), 9.8 * t.cos(), 20.0 * (0.1 * t).sin()];
            let back = model.apply(model.invert(a));
            for axis in 0..3 {
                // Outputs near 4e4 counts round to 4e-12; divided by 414 counts/(m/s²).
                assert!((back[axis] - a[axis]).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn law_single_precision_stays_within_its_bound() {
        let model = xsens();
        let single = model.cast::<f32>();
        let inverse_norm = model.k_inverse().norm();
        let mut largest: f64 = 0.0;
        for i in 0..4000 {
            let t = f64::from(i) * 0.011;
            let counts = [
                (33123.0 + 4000.0 * t.sin()).round(),
                (33275.0 + 4000.0 * t.cos()).round(),
                (32364.0 + 4000.0 * (0.7 * t).sin()).round(),
            ];
            let exact = model.apply(counts);
            let got = single.apply(counts.map(|v| v as f32));
            let size = counts.iter().map(|v| v * v).sum::<f64>().sqrt()
                + model.bias().iter().map(|v| v * v).sum::<f64>().sqrt();
            for axis in 0..3 {
                let error = (f64::from(got[axis]) - exact[axis]).abs();
                assert!(error < 4.0 * f64::from(f32::EPSILON) * size * inverse_norm);
                largest = largest.max(error);
            }
        }
        assert!(largest < 0.08e-3, "{largest}");
    }

    #[test]
    fn law_columns_are_compensated_as_samples_are() {
        let model = xsens().cast::<f32>();
        let column = |axis: usize| -> [f32; 37] {
            core::array::from_fn(|i| 32_000.0 + (axis * 7919 + i * 104_729) as f32 % 2000.0)
        };
        let [x, y, z] = [column(0), column(1), column(2)];
        let mut out = [[0.0f32; 37]; 3];
        let [ax, ay, az] = &mut out;
        model.apply_columns([&x, &y, &z], [ax, ay, az]).unwrap();
        for i in 0..37 {
            let a = model.apply([x[i], y[i], z[i]]);
            assert_eq!(a, [out[0][i], out[1][i], out[2][i]]);
        }
        let [ax, ay, _] = &mut out;
        let short = model.apply_columns([&x, &y, &z], [ax, ay, &mut [0.0; 3]]);
        assert!(short.unwrap_err().is_input());
    }

    #[test]
    fn refuses_a_matrix_without_inverse() {
        let k = Matrix3([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0f64]]);
        assert!(SensorModel::new(k, [0.0; 3]).unwrap_err().is_numerical());
        assert!(
            SensorModel::new(Matrix3::identity(), [0.0, f64::INFINITY, 0.0])
                .unwrap_err()
                .is_data()
        );
    }
}
