//! Compensation beyond the linear model: temperature and non-linearity, one function on the desk and on the chip.

use crate::{Error, Float, Matrix3, SensorModel, check};

/// Largest power of the temperature difference in a [`ThermalTerms`].
pub const THERMAL_ORDER: usize = 3;

/// The correction of a channel by its own curvature must stay below this share of the signal.
///
/// Three steps of Newton's method then leave less than 10⁻¹⁵ of it in double precision.
pub const LARGEST_NONLINEARITY: f64 = 0.05;

/// How bias and scale of each axis follow the temperature T, d = T − T₀.
///
/// b_i(T) = b_i + Σ_k β_ik dᵏ and K(T) = diag(1 + Σ_k γ_ik dᵏ) K, k = 1 … 3. The angles between the axes are taken
/// as those at T₀. Outside the temperatures at which they were measured the polynomials are held at their value at the nearer end: a
/// cubic of a narrow range runs away beyond it.
///
/// **Units** temperatures in °C (differences in K), β_ik in output units per Kᵏ, γ_ik in 1/Kᵏ.
///
/// **Shapes** N axes: three, or one.
#[doc(alias("TCB", "TCS", "temperature coefficient"))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound(
        serialize = "F: serde::Serialize, [[F; THERMAL_ORDER]; N]: serde::Serialize",
        deserialize = "F: serde::Deserialize<'de>, [[F; THERMAL_ORDER]; N]: serde::Deserialize<'de>"
    ))
)]
pub struct ThermalTerms<F, const N: usize = 3> {
    /// T₀, °C: the temperature at which K and b of the linear model hold.
    pub reference: F,
    /// Lowest and highest temperature at which the coefficients were measured, °C.
    pub range: [F; 2],
    /// β: per axis the coefficients of d, d², d³.
    pub bias: [[F; THERMAL_ORDER]; N],
    /// γ: per axis the coefficients of d, d², d³.
    pub scale: [[F; THERMAL_ORDER]; N],
}

impl<F: Float, const N: usize> ThermalTerms<F, N> {
    /// Whether the coefficients were measured at this temperature, °C.
    pub fn covers(&self, temperature: F) -> bool {
        self.range[0] <= temperature && temperature <= self.range[1]
    }

    /// T − T₀ with T held in the range; NaN stays NaN.
    #[inline]
    fn difference(&self, temperature: F) -> F {
        let [low, high] = self.range;
        let held = if temperature < low {
            low
        } else if temperature > high {
            high
        } else {
            temperature
        };
        held - self.reference
    }

    /// (v_i − Σ β_ik dᵏ) / (1 + Σ γ_ik dᵏ): what the sensor would have given at T₀.
    #[inline]
    fn at_reference(&self, mut v: [F; N], temperature: F) -> [F; N] {
        let d = self.difference(temperature);
        for axis in 0..N {
            v[axis] = (v[axis] - power_sum(&self.bias[axis], d))
                / (F::ONE + power_sum(&self.scale[axis], d));
        }
        v
    }

    /// What undoes [`at_reference`](Self::at_reference).
    #[inline]
    fn at_temperature(&self, mut v: [F; N], temperature: F) -> [F; N] {
        let d = self.difference(temperature);
        for axis in 0..N {
            v[axis] = v[axis] * (F::ONE + power_sum(&self.scale[axis], d))
                + power_sum(&self.bias[axis], d);
        }
        v
    }

    fn check(&self) -> Result<(), Error> {
        let all = self.bias.iter().chain(&self.scale).flatten();
        if let Some(index) = core::iter::once(&self.reference)
            .chain(all)
            .position(|v| !v.is_finite())
        {
            return Err(Error::NotFinite {
                name: "temperature coefficient",
                index,
            });
        }
        let [low, high] = self.range;
        if !(low <= high) {
            return Err(Error::OutOfRange {
                name: "lowest temperature of the coefficients",
                value: low.to_f64(),
                min: f64::MIN,
                max: high.to_f64(),
            });
        }
        Ok(())
    }

    fn cast<G: Float>(&self) -> ThermalTerms<G, N> {
        let to = |v: F| G::from_f64(v.to_f64());
        ThermalTerms {
            reference: to(self.reference),
            range: self.range.map(to),
            bias: self.bias.map(|row| row.map(to)),
            scale: self.scale.map(|row| row.map(to)),
        }
    }
}

/// Curvature of each channel along its own sensitive axis.
///
/// With x_i = (K a)_i / K_ii, the channel gives b_i + K_ii (x_i + k₂ x_i² + k₃ x_i³).
///
/// **Units** k₂ in 1/(m/s²), k₃ in 1/(m/s²)².
///
/// **Shapes** N axes: three, or one.
#[doc(alias("second-order nonlinearity", "K2", "vibration rectification"))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound(
        serialize = "[F; N]: serde::Serialize",
        deserialize = "[F; N]: serde::Deserialize<'de>"
    ))
)]
pub struct Curvature<F, const N: usize = 3> {
    /// k₂ per axis.
    pub quadratic: [F; N],
    /// k₃ per axis.
    pub cubic: [F; N],
}

impl<F: Float, const N: usize> Curvature<F, N> {
    /// |k₂ x| + |k₃ x²| of the worst axis at a reach of x, m/s²: what curvature does to a reading, relative.
    pub fn share(&self, reach: F) -> F {
        let mut largest = F::ZERO;
        for axis in 0..N {
            let share =
                (self.quadratic[axis] * reach).abs() + (self.cubic[axis] * reach * reach).abs();
            if !(share <= largest) {
                largest = share;
            }
        }
        largest
    }

    fn check(&self, reach: F) -> Result<(), Error> {
        let mut all = self.quadratic.iter().chain(&self.cubic);
        if let Some(index) = all.position(|v| !v.is_finite()) {
            return Err(Error::NotFinite {
                name: "non-linear coefficient",
                index,
            });
        }
        let share = self.share(reach).to_f64();
        if !(share <= LARGEST_NONLINEARITY) {
            return Err(Error::OutOfRange {
                name: "share of curvature in a reading",
                value: share,
                min: 0.0,
                max: LARGEST_NONLINEARITY,
            });
        }
        Ok(())
    }

    /// x_i with x_i (1 + k₂ x_i + k₃ x_i²) = y_i, axis by axis.
    #[inline]
    fn straightened(&self, axis: usize, y: F) -> F {
        straighten(y, self.quadratic[axis], self.cubic[axis])
    }

    /// 1 + k₂ x + k₃ x².
    #[inline]
    fn factor(&self, axis: usize, x: F) -> F {
        F::ONE + x * (self.quadratic[axis] + x * self.cubic[axis])
    }

    fn cast<G: Float>(&self) -> Curvature<G, N> {
        let to = |v: F| G::from_f64(v.to_f64());
        Curvature {
            quadratic: self.quadratic.map(to),
            cubic: self.cubic.map(to),
        }
    }
}

/// Linear model, temperature and curvature of a triaxial accelerometer.
///
/// ```text
/// v_i = (ã_i − b_i(T)) / (1 + Σ γ_ik dᵏ)          temperature, d = T − T₀
/// w_i = K_ii x_i,  x_i (1 + k₂ x_i + k₃ x_i²) = v_i / K_ii    curvature
/// a   = K⁻¹ w
/// ```
///
/// Without allocation, inversion or checks at run time; what it was made from is in
/// [`Compensation::new`] checked once, or exported as a constant.
///
/// ```
/// use proofmass_core::*;
///
/// let sensor = SensorModel::<f64>::new(Matrix3::diagonal([100.0; 3]), [5.0; 3])?;
/// let warm = ThermalTerms { reference: 25.0, range: [-40.0, 85.0], bias: [[0.2, 0.0, 0.0]; 3], scale: [[1e-4, 0.0, 0.0]; 3] };
/// let model = Compensation::new(sensor, Some(warm), None, 20.0)?;
/// let output = model.invert([0.0, 0.0, 9.8], 45.0);
/// assert!((output[0] - 9.0).abs() < 1e-12);               // 5 + 0.2 · 20
/// assert!((output[2] - (9.0 + 980.0 * 1.002)).abs() < 1e-12);
/// assert!((model.apply(output, 45.0)[2] - 9.8).abs() < 1e-13);
/// # Ok::<(), Error>(())
/// ```
#[doc(alias("temperature compensation", "error model"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensation<F> {
    sensor: SensorModel<F>,
    thermal: Option<ThermalTerms<F>>,
    curvature: Option<Curvature<F>>,
}

impl<F: Float> Compensation<F> {
    /// A linear model with what is known beyond it; `reach` is the largest acceleration it is used at, m/s².
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] where curvature makes more than [`LARGEST_NONLINEARITY`] of a
    /// reading at `reach`.
    pub fn new(
        sensor: SensorModel<F>,
        thermal: Option<ThermalTerms<F>>,
        curvature: Option<Curvature<F>>,
        reach: F,
    ) -> Result<Self, Error> {
        if let Some(terms) = &thermal {
            terms.check()?;
        }
        if let Some(curvature) = &curvature {
            curvature.check(reach)?;
        }
        Ok(Self {
            sensor,
            thermal,
            curvature,
        })
    }

    /// As a constant of firmware: nothing is computed and nothing is checked.
    pub const fn constant(
        sensor: SensorModel<F>,
        thermal: Option<ThermalTerms<F>>,
        curvature: Option<Curvature<F>>,
    ) -> Self {
        Self {
            sensor,
            thermal,
            curvature,
        }
    }

    /// The linear part.
    pub fn sensor(&self) -> &SensorModel<F> {
        &self.sensor
    }

    /// What depends on temperature.
    pub fn thermal(&self) -> Option<&ThermalTerms<F>> {
        self.thermal.as_ref()
    }

    /// What is not linear.
    pub fn curvature(&self) -> Option<&Curvature<F>> {
        self.curvature.as_ref()
    }

    /// Acceleration, m/s², from the sensor's output and its temperature in °C, which does not matter to a model without
    /// [`ThermalTerms`].
    ///
    /// Beyond the range of the [`ThermalTerms`] it is the compensation at the nearer end; [`ThermalTerms::covers`] tells. A NaN of
    /// either gives a NaN: on a chip nobody could be told.
    ///
    /// **Accuracy** inverts [`Compensation::invert`] to rounding (`law_apply_undoes_invert_at_every_temperature`).
    #[inline]
    pub fn apply(&self, output: [F; 3], temperature: F) -> [F; 3] {
        let bias = self.sensor.bias();
        let mut v = [
            output[0] - bias[0],
            output[1] - bias[1],
            output[2] - bias[2],
        ];
        if let Some(terms) = &self.thermal {
            v = terms.at_reference(v, temperature);
        }
        if let Some(curvature) = &self.curvature {
            let k = self.sensor.k();
            for axis in 0..3 {
                let size = k.0[axis][axis];
                v[axis] = size * curvature.straightened(axis, v[axis] / size);
            }
        }
        self.sensor.k_inverse().times(v)
    }

    /// Compensation of whole columns, to the bit what [`apply`](Self::apply) gives sample by sample.
    ///
    /// # Errors
    /// [`Error::Length`] unless all columns are equally long.
    pub fn apply_columns(
        &self,
        outputs: [&[F]; 3],
        temperature: &[F],
        accelerations: [&mut [F]; 3],
    ) -> Result<(), Error> {
        let [x, y, z] = outputs;
        let [ax, ay, az] = accelerations;
        let n = x.len();
        check::columns(n, [y.len(), z.len()], [ax.len(), ay.len(), az.len()])?;
        check::lengths(n, [("temperature", temperature.len())])?;
        let inputs = x.iter().zip(y).zip(z).zip(temperature);
        let results = ax.iter_mut().zip(ay).zip(az);
        for ((((x, y), z), t), ((ax, ay), az)) in inputs.zip(results) {
            [*ax, *ay, *az] = self.apply([*x, *y, *z], *t);
        }
        Ok(())
    }

    /// The sensor itself: output from acceleration and temperature.
    #[inline]
    pub fn invert(&self, acceleration: [F; 3], temperature: F) -> [F; 3] {
        let k = self.sensor.k();
        let bias = self.sensor.bias();
        let mut v = k.times(acceleration);
        if let Some(curvature) = &self.curvature {
            for axis in 0..3 {
                let x = v[axis] / k.0[axis][axis];
                v[axis] *= curvature.factor(axis, x);
            }
        }
        if let Some(terms) = &self.thermal {
            v = terms.at_temperature(v, temperature);
        }
        [v[0] + bias[0], v[1] + bias[1], v[2] + bias[2]]
    }

    /// The linear model at one temperature: K(T) and b(T).
    ///
    /// # Errors
    /// [`Error::Singular`] where a scale factor vanishes.
    pub fn at(&self, temperature: F) -> Result<SensorModel<F>, Error> {
        let Some(terms) = &self.thermal else {
            return Ok(self.sensor);
        };
        let d = terms.difference(temperature);
        let mut k = self.sensor.k().0;
        let mut bias = self.sensor.bias();
        for axis in 0..3 {
            let factor = F::ONE + power_sum(&terms.scale[axis], d);
            for element in &mut k[axis] {
                *element *= factor;
            }
            bias[axis] += power_sum(&terms.bias[axis], d);
        }
        SensorModel::new(Matrix3(k), bias)
    }

    /// The same in the other precision.
    pub fn cast<G: Float>(&self) -> Compensation<G> {
        Compensation {
            sensor: self.sensor.cast(),
            thermal: self.thermal.as_ref().map(ThermalTerms::cast),
            curvature: self.curvature.as_ref().map(Curvature::cast),
        }
    }
}

impl<F: Float> From<SensorModel<F>> for Compensation<F> {
    fn from(sensor: SensorModel<F>) -> Self {
        Self::constant(sensor, None, None)
    }
}

/// Scale, bias, temperature and curvature of an accelerometer with one sensitive axis.
///
/// ```text
/// v = (ã − b(T)) / (1 + Σ γ_k dᵏ)                temperature, d = T − T₀
/// a (1 + k₂ a + k₃ a²) = v / k                    curvature
/// ```
///
/// What [`Compensation`] is for three axes, without the matrix: the terms are the same functions.
///
/// ```
/// use proofmass_core::*;
///
/// // A servo accelerometer: 0.13 V/(m/s²), 2 mV, K2 of 1e-5 1/(m/s²).
/// let curvature = Curvature { quadratic: [1e-5], cubic: [0.0] };
/// let model = AxisCompensation::<f64>::new(0.13, 2e-3, None, Some(curvature), 50.0)?;
/// let output = model.invert(40.0, 25.0);
/// assert!((output - (2e-3 + 0.13 * 40.0 * 1.0004)).abs() < 1e-15);
/// assert!((model.apply(output, 25.0) - 40.0).abs() < 1e-13);
/// # Ok::<(), Error>(())
/// ```
#[doc(alias("single-axis accelerometer", "K0", "K1"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisCompensation<F> {
    scale: F,
    bias: F,
    thermal: Option<ThermalTerms<F, 1>>,
    curvature: Option<Curvature<F, 1>>,
}

impl<F: Float> AxisCompensation<F> {
    /// From the scale factor k (output per m/s²) and the bias b (output); `reach` is the largest acceleration it is used at, m/s².
    ///
    /// # Errors
    /// As [`Compensation::new`]; [`Error::Singular`] for a scale factor of zero.
    pub fn new(
        scale: F,
        bias: F,
        thermal: Option<ThermalTerms<F, 1>>,
        curvature: Option<Curvature<F, 1>>,
        reach: F,
    ) -> Result<Self, Error> {
        if let Some(index) = [scale, bias].iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite {
                name: "scale factor or bias",
                index,
            });
        }
        if !(scale.abs() > F::ZERO) {
            return Err(Error::Singular {
                name: "scale factor",
                condition: f64::INFINITY,
            });
        }
        if let Some(terms) = &thermal {
            terms.check()?;
        }
        if let Some(curvature) = &curvature {
            curvature.check(reach)?;
        }
        Ok(Self::constant(scale, bias, thermal, curvature))
    }

    /// As a constant of firmware: nothing is computed and nothing is checked.
    pub const fn constant(
        scale: F,
        bias: F,
        thermal: Option<ThermalTerms<F, 1>>,
        curvature: Option<Curvature<F, 1>>,
    ) -> Self {
        Self {
            scale,
            bias,
            thermal,
            curvature,
        }
    }

    /// Scale factor k, output unit per m/s².
    pub fn scale(&self) -> F {
        self.scale
    }

    /// Bias b in output units.
    pub fn bias(&self) -> F {
        self.bias
    }

    /// What depends on temperature.
    pub fn thermal(&self) -> Option<&ThermalTerms<F, 1>> {
        self.thermal.as_ref()
    }

    /// What is not linear.
    pub fn curvature(&self) -> Option<&Curvature<F, 1>> {
        self.curvature.as_ref()
    }

    /// Acceleration, m/s², from the sensor's output and its temperature in °C, as [`Compensation::apply`].
    #[inline]
    pub fn apply(&self, output: F, temperature: F) -> F {
        let mut v = output - self.bias;
        if let Some(terms) = &self.thermal {
            [v] = terms.at_reference([v], temperature);
        }
        let a = v / self.scale;
        match &self.curvature {
            Some(curvature) => curvature.straightened(0, a),
            None => a,
        }
    }

    /// The sensor itself: output from acceleration and temperature.
    #[inline]
    pub fn invert(&self, acceleration: F, temperature: F) -> F {
        let mut v = self.scale * acceleration;
        if let Some(curvature) = &self.curvature {
            v *= curvature.factor(0, acceleration);
        }
        if let Some(terms) = &self.thermal {
            [v] = terms.at_temperature([v], temperature);
        }
        v + self.bias
    }

    /// The same in the other precision.
    pub fn cast<G: Float>(&self) -> AxisCompensation<G> {
        let to = |v: F| G::from_f64(v.to_f64());
        AxisCompensation {
            scale: to(self.scale),
            bias: to(self.bias),
            thermal: self.thermal.as_ref().map(ThermalTerms::cast),
            curvature: self.curvature.as_ref().map(Curvature::cast),
        }
    }
}

/// c₁ d + c₂ d² + c₃ d³.
#[inline]
fn power_sum<F: Float>(c: &[F; THERMAL_ORDER], d: F) -> F {
    d * (c[0] + d * (c[1] + d * c[2]))
}

/// x with x (1 + k₂ x + k₃ x²) = y, by three Newton steps from x = y: the relative error ε shrinks as ε², ε from 0.05.
#[inline]
fn straighten<F: Float>(y: F, k2: F, k3: F) -> F {
    let two = F::ONE + F::ONE;
    let three = two + F::ONE;
    let mut x = y;
    for _ in 0..3 {
        let value = x * (F::ONE + x * (k2 + x * k3)) - y;
        let slope = F::ONE + x * (two * k2 + three * k3 * x);
        x -= value / slope;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> Compensation<f64> {
        let k = Matrix3([[414.4, 1.3, -0.9], [0.5, 412.0, 2.1], [0.2, -0.7, 414.6]]);
        let sensor = SensorModel::new(k, [33123.9, 33275.2, 32364.5]).unwrap();
        let thermal = ThermalTerms {
            reference: 25.0,
            range: [-40.0, 85.0],
            bias: [[0.4, -1e-3, 2e-6], [-0.2, 3e-4, 0.0], [0.1, 0.0, -1e-6]],
            scale: [[2e-4, 1e-7, 0.0], [-1e-4, 0.0, 1e-9], [3e-4, -2e-7, 0.0]],
        };
        let curvature = Curvature {
            quadratic: [5e-4, -3e-4, 2e-4],
            cubic: [1e-5, 0.0, -2e-6],
        };
        Compensation::new(sensor, Some(thermal), Some(curvature), 40.0).unwrap()
    }

    #[test]
    fn law_polynomials_are_held_at_the_ends_of_their_range() {
        let model = model();
        let output = [33_500.0, 33_000.0, 36_000.0];
        for (beyond, end) in [(-60.0, -40.0), (85.1, 85.0), (300.0, 85.0)] {
            assert_eq!(model.apply(output, beyond), model.apply(output, end));
            assert_eq!(model.at(beyond), model.at(end));
            assert!(
                !model.thermal().unwrap().covers(beyond) && model.thermal().unwrap().covers(end)
            );
        }
        assert!(model.apply(output, f64::NAN)[0].is_nan());
    }

    #[test]
    fn law_apply_undoes_invert_at_every_temperature() {
        let model = model();
        for i in 0..4000 {
            let t = f64::from(i) * 0.37;
            let a = [
                38.0 * t.sin(),
                38.0 * (1.3 * t).cos(),
                38.0 * (0.1 * t).sin(),
            ];
            let temperature = 22.5 + 62.5 * (0.07 * t).cos();
            let back = model.apply(model.invert(a, temperature), temperature);
            for axis in 0..3 {
                // Outputs near 5e4 counts round to 7e-12, divided by 414 counts/(m/s²); Newton's rest is below it.
                assert!((back[axis] - a[axis]).abs() < 2e-13, "{back:?} {a:?}");
            }
        }
    }

    #[test]
    fn law_at_is_the_linear_model_of_that_temperature() {
        let model = model();
        let plain = Compensation::constant(*model.sensor(), model.thermal().copied(), None);
        let frozen = plain.at(-20.0).unwrap();
        let a = [3.0, -4.0, 9.0];
        let (x, y) = (plain.invert(a, -20.0), frozen.invert(a));
        for axis in 0..3 {
            assert!((x[axis] - y[axis]).abs() < 1e-10);
        }
    }

    /// Without the extra terms the result is that of the linear model, to the last bit.
    #[test]
    fn law_a_linear_model_is_applied_alike() {
        let sensor = *model().sensor();
        let compensation = Compensation::from(sensor);
        let output = [33000.0, 33800.0, 36000.0];
        assert_eq!(compensation.apply(output, f64::NAN), sensor.apply(output));
        assert_eq!(compensation.at(80.0).unwrap(), sensor);
    }

    /// Relative rounding ε of each of a dozen operations on outputs of 5e4 counts over 414 counts/(m/s²).
    #[test]
    fn law_single_precision_stays_within_its_bound() {
        let model = model();
        let single = model.cast::<f32>();
        let mut largest = 0.0f64;
        for i in 0..4000 {
            let t = f64::from(i) * 0.11;
            let a = [30.0 * t.sin(), 30.0 * t.cos(), 30.0 * (0.3 * t).sin()];
            let output = model.invert(a, 60.0).map(f64::round);
            let exact = model.apply(output, 60.0);
            let got = single.apply(output.map(|v| v as f32), 60.0);
            for axis in 0..3 {
                largest = largest.max((f64::from(got[axis]) - exact[axis]).abs());
            }
        }
        let bound = 12.0 * f64::from(f32::EPSILON) * 5e4 / 412.0;
        assert!(
            largest < bound && largest > 1e-3 * bound,
            "{largest} {bound}"
        );
    }

    /// An axis alone is an axis of three whose matrix is diagonal.
    #[test]
    fn law_one_axis_is_an_axis_of_three() {
        let three = model();
        let (thermal, curvature) = (three.thermal().unwrap(), three.curvature().unwrap());
        for i in 0..3 {
            let k = three.sensor().k().0[i][i];
            let b = three.sensor().bias()[i];
            let diagonal = Compensation::new(
                SensorModel::new(Matrix3::diagonal([k; 3]), [b; 3]).unwrap(),
                Some(*thermal),
                Some(*curvature),
                40.0,
            )
            .unwrap();
            let axis = AxisCompensation::new(
                k,
                b,
                Some(ThermalTerms {
                    reference: thermal.reference,
                    range: thermal.range,
                    bias: [thermal.bias[i]],
                    scale: [thermal.scale[i]],
                }),
                Some(Curvature {
                    quadratic: [curvature.quadratic[i]],
                    cubic: [curvature.cubic[i]],
                }),
                40.0,
            )
            .unwrap();
            for step in -40..=40 {
                let (a, t) = (f64::from(step), 1.7 * f64::from(step));
                let output = axis.invert(a, t);
                // Outputs near 5e4 counts round to 7e-12.
                assert!((output - diagonal.invert([a; 3], t)[i]).abs() < 2e-11);
                let (one, of_three) = (axis.apply(output, t), diagonal.apply([output; 3], t)[i]);
                assert!((one - of_three).abs() < 2e-13 && (one - a).abs() < 2e-13);
            }
        }
        assert!(matches!(
            AxisCompensation::new(0.0, 1.0, None, None, 10.0),
            Err(Error::Singular { .. })
        ));
    }

    #[test]
    fn refuses_curvature_that_is_no_correction() {
        let sensor = *model().sensor();
        let curvature = Curvature {
            quadratic: [0.0, 2e-3, 0.0],
            cubic: [0.0; 3],
        };
        assert!(Compensation::new(sensor, None, Some(curvature), 20.0).is_ok());
        let refused = Compensation::new(sensor, None, Some(curvature), 30.0);
        assert!(matches!(refused, Err(Error::OutOfRange { .. })));
        let lost = ThermalTerms {
            reference: f64::NAN,
            range: [-40.0, 85.0],
            bias: [[0.0; 3]; 3],
            scale: [[0.0; 3]; 3],
        };
        let refused = Compensation::new(sensor, Some(lost), None, 20.0);
        assert!(matches!(refused, Err(Error::NotFinite { index: 0, .. })));
    }
}
