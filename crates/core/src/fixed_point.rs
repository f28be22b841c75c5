//! Compensation in integers, for a chip without a floating-point unit, with a bound on what the integers cost.

use crate::{Compensation, Error, THERMAL_ORDER};

/// Fraction bits of a temperature: 1/256 °C.
pub const TEMPERATURE_BITS: u32 = 8;
/// Fraction bits of the normalised temperature difference and of the relative scale.
const UNIT_BITS: u32 = 30;

/// What the integers must hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedRange {
    /// Smallest and largest output of the converter per axis.
    pub outputs: [[i32; 2]; 3],
    /// Lowest and highest temperature, °C; without meaning for a model without temperature.
    pub temperature: [f64; 2],
}

/// Temperature polynomials in integers, in powers of z = (T − T₀)/2ᵏ, |z| ≤ 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct FixedThermal {
    /// T₀ in 1/256 °C.
    pub reference: i32,
    /// Lowest and highest temperature in 1/256 °C.
    pub range: [i32; 2],
    /// z = (T − T₀) · 2^shift with 30 fraction bits.
    pub shift: u32,
    /// Per axis the coefficients of z, z², z³ of the bias, with the fraction bits of the signal.
    pub bias: [[i32; THERMAL_ORDER]; 3],
    /// Per axis the coefficients of z, z², z³ of the relative scale, 30 fraction bits.
    pub scale: [[i32; THERMAL_ORDER]; 3],
}

/// Curvature in integers: ξ (1 + A ξ + B ξ²) = ξ_v with ξ of 29 fraction bits, |ξ| < 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct FixedCurvature {
    /// A per axis, 30 fraction bits.
    pub quadratic: [i32; 3],
    /// B per axis, 30 fraction bits.
    pub cubic: [i32; 3],
}

/// Fraction bits of ξ: the signal over the power of two above its largest value.
const SHARE_BITS: u32 = 29;
/// Curvature may make this share of a signal at the ends of the converter.
const LARGEST_SHARE: f64 = 0.1;

/// A [`Compensation`] in integers: outputs as counts, temperature in 1/256 °C, acceleration with
/// [`FixedPoint::result_bits`] fraction bits.
///
/// All products are of 32 by 32 bits summed in 64: none can overflow for outputs and temperatures within the range.
///
/// **Accuracy** each component differs from the compensation in exact arithmetic by at most
/// [`FixedPoint::bound`]: rounding of bias and polynomials, of K⁻¹ (half a unit of its last bit at the largest
/// signal), of division and result, summed in absolute value; with curvature what rounding and three steps of Newton's
/// method leave of ξ, and the slope 1 − 3 S by which curvature of share S may enlarge the errors before it.
///
/// ```
/// use proofmass_core::*;
/// let sensor = SensorModel::new(Matrix3::diagonal([1670.13; 3]), [12.0, -40.5, 3.0])?;
/// let range = FixedRange { outputs: [[-32768, 32767]; 3], temperature: [0.0, 0.0] };
/// let fixed = FixedPoint::new(&Compensation::from(sensor), range)?;
/// let a = fixed.apply([12, -40, 16384], 0).unwrap();
/// let exact = sensor.apply([12.0, -40.0, 16384.0]);
/// assert!((fixed.to_si(a)[2] - exact[2]).abs() <= fixed.bound[2]);
/// assert!(fixed.bound[2] < 5e-7);
/// assert_eq!(fixed.apply([0, 0, 40000], 0), None);
/// # Ok::<(), Error>(())
/// ```
#[doc(alias("Q format", "fixed-point arithmetic"))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FixedPoint {
    /// Smallest and largest output per axis.
    pub outputs: [[i32; 2]; 3],
    /// Fraction bits of the signal before K⁻¹.
    pub signal_bits: u32,
    /// Bias with the fraction bits of the signal.
    pub bias: [i64; 3],
    /// Temperature polynomials.
    pub thermal: Option<FixedThermal>,
    /// Curvature.
    pub curvature: Option<FixedCurvature>,
    /// Fraction bits of K⁻¹.
    pub matrix_bits: u32,
    /// K⁻¹ by rows.
    pub matrix: [[i32; 3]; 3],
    /// Fraction bits of the acceleration in m/s².
    pub result_bits: u32,
    /// Largest error of each component against exact arithmetic, m/s².
    pub bound: [f64; 3],
}

impl FixedPoint {
    /// Chooses the formats for a model and its range, and bounds their error.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a reversed range, outputs beyond 2²⁹ above the bias, a scale that temperature changes
    /// by half, curvature that makes more than a tenth of a signal at the ends of the converter.
    pub fn new(model: &Compensation<f64>, range: FixedRange) -> Result<Self, Error> {
        for [low, high] in range.outputs {
            if low >= high {
                return Err(out_of_range(
                    "lower end of the outputs",
                    f64::from(low),
                    f64::from(i32::MIN),
                    f64::from(high),
                ));
            }
        }
        let k_inverse = model.sensor().k_inverse().0;
        let bias = model.sensor().bias();
        let (span, thermal) = match model.thermal() {
            Some(terms) => {
                let [low, high] = range.temperature;
                let widest = libm::fmax(
                    libm::fabs(low - terms.reference),
                    libm::fabs(high - terms.reference),
                );
                if !(low < high && widest < 1000.0) {
                    return Err(out_of_range(
                        "lowest temperature",
                        low,
                        terms.reference - 1000.0,
                        high,
                    ));
                }
                // At least 1 °C; the reference is rounded to 1/256 °C, so half a step more is held.
                let exponent = libm::fmax(0.0, libm::ceil(libm::log2(widest + 0.01)));
                (libm::exp2(exponent), Some(terms))
            }
            None => (1.0, None),
        };
        // T₀ in steps of 1/256 °C: the polynomials are moved to the rounded one.
        let moved = thermal.map(|terms| {
            let rounded = libm::round(terms.reference * 256.0) / 256.0;
            let d = rounded - terms.reference;
            (
                rounded,
                d,
                terms.bias.map(|c| shifted(c, d)),
                terms.scale.map(|c| shifted(c, d)),
            )
        });
        let mut offset = bias;
        let mut gain = [1.0; 3];
        let mut polynomial = [[[0.0; THERMAL_ORDER]; 3]; 2];
        if let Some((_, _, b, s)) = &moved {
            for axis in 0..3 {
                offset[axis] += b[axis].0;
                gain[axis] += s[axis].0;
                for k in 0..THERMAL_ORDER {
                    let unit = libm::pow(span, (k + 1) as f64);
                    polynomial[0][axis][k] = b[axis].1[k] * unit;
                    // Relative to the scale at the rounded T₀, which goes into K⁻¹.
                    polynomial[1][axis][k] = s[axis].1[k] * unit / gain[axis];
                }
            }
        }
        let size = |c: &[f64; THERMAL_ORDER]| c.iter().map(|v| libm::fabs(*v)).sum::<f64>();
        let mut largest = [0.0; 3];
        for axis in 0..3 {
            let change = size(&polynomial[1][axis]);
            if !(change < 0.5) {
                return Err(out_of_range(
                    "relative change of scale with temperature",
                    change,
                    0.0,
                    0.5,
                ));
            }
            let [low, high] = range.outputs[axis].map(f64::from);
            let reach = libm::fmax(
                libm::fabs(low - offset[axis]),
                libm::fabs(high - offset[axis]),
            );
            largest[axis] = (reach + size(&polynomial[0][axis])) / (1.0 - change);
        }
        // Curvature of the signal w before K⁻¹: w (1 + a w + b w²) = v. Its share at the largest w, and that.
        let mut shares = [0.0; 3];
        let mut curved = [[0.0; 2]; 3];
        if let Some(terms) = model.curvature() {
            for axis in 0..3 {
                let unit = gain[axis] * model.sensor().k().0[axis][axis];
                curved[axis] = [
                    terms.quadratic[axis] / unit,
                    terms.cubic[axis] / (unit * unit),
                ];
                let most = largest[axis] / (1.0 - LARGEST_SHARE);
                let share =
                    libm::fabs(curved[axis][0]) * most + libm::fabs(curved[axis][1]) * most * most;
                if !(share <= LARGEST_SHARE) {
                    return Err(out_of_range(
                        "share of curvature at the ends of the converter",
                        share,
                        0.0,
                        LARGEST_SHARE,
                    ));
                }
                shares[axis] = share;
                largest[axis] /= 1.0 - share;
            }
        }
        let most = largest.iter().fold(0.0, |a, b| libm::fmax(a, *b));
        let signal = 29.0 - libm::floor(libm::log2(most)) - 1.0;
        if !(signal >= 0.0) {
            return Err(out_of_range(
                "largest output above the bias",
                most,
                0.0,
                536_870_912.0,
            ));
        }
        let signal_bits = libm::fmin(signal, 20.0) as u32;
        let matrix: [[f64; 3]; 3] =
            core::array::from_fn(|i| core::array::from_fn(|j| k_inverse[i][j] / gain[j]));
        let element = matrix
            .iter()
            .flatten()
            .fold(0.0, |a, b| libm::fmax(a, libm::fabs(*b)));
        let matrix_bits = 29.0 - libm::floor(libm::log2(element));
        let accelerations: [f64; 3] =
            core::array::from_fn(|i| (0..3).map(|j| libm::fabs(matrix[i][j]) * largest[j]).sum());
        let fastest = accelerations.iter().fold(0.0, |a, b| libm::fmax(a, *b));
        let result = libm::fmin(
            29.0 - libm::floor(libm::log2(fastest)),
            f64::from(signal_bits) + matrix_bits - 1.0,
        );
        if !((0.0..=60.0).contains(&matrix_bits) && (0.0..=30.0).contains(&result)) {
            return Err(out_of_range(
                "scale of the accelerations, m/s²",
                fastest,
                9.4e-10,
                1.07e9,
            ));
        }
        let (matrix_bits, result_bits) = (matrix_bits as u32, result as u32);
        let unit = libm::exp2(f64::from(signal_bits));
        let scaled = |v: f64, bits: u32| libm::round(v * libm::exp2(f64::from(bits)));
        let fixed_thermal = moved.map(|(reference, ..)| FixedThermal {
            reference: (reference * 256.0) as i32,
            range: [
                libm::ceil(range.temperature[0] * 256.0) as i32,
                libm::floor(range.temperature[1] * 256.0) as i32,
            ],
            shift: UNIT_BITS - TEMPERATURE_BITS - libm::log2(span) as u32,
            bias: polynomial[0].map(|c| c.map(|v| scaled(v, signal_bits) as i32)),
            scale: polynomial[1].map(|c| c.map(|v| scaled(v, UNIT_BITS) as i32)),
        });
        // In units of the last place of the signal: half for the bias; coefficients and products of the two
        // polynomials half each, three of both; less than one for the division, which is cut off.
        let before: [f64; 3] = core::array::from_fn(|axis| {
            if fixed_thermal.is_none() {
                return 0.5 / unit;
            }
            let rest = 1.0 - size(&polynomial[1][axis]);
            let scale = 3.0 * libm::exp2(-f64::from(UNIT_BITS));
            (3.5 / rest + 1.0) / unit + largest[axis] * scale / (rest - scale)
        });
        let fixed_curvature = match model.curvature() {
            None => None,
            Some(_) => {
                let most = libm::exp2(f64::from(SHARE_BITS) - f64::from(signal_bits));
                let mut fixed = FixedCurvature {
                    quadratic: [0; 3],
                    cubic: [0; 3],
                };
                for axis in 0..3 {
                    let [a, b] = curved[axis];
                    for (v, to) in [
                        (a * most, &mut fixed.quadratic[axis]),
                        (b * most * most, &mut fixed.cubic[axis]),
                    ] {
                        if !(libm::fabs(v) < 1.999) {
                            return Err(out_of_range(
                                "curvature over the range of the widest axis",
                                v,
                                -1.999,
                                1.999,
                            ));
                        }
                        *to = scaled(v, UNIT_BITS) as i32;
                    }
                }
                Some(fixed)
            }
        };
        // ξ in units of 2⁻²⁹, which are those of the signal: a quarter each for the two coefficients and for the two
        // inner products, half for the outer one, over the least slope; one for the division, which is cut off. What
        // Newton leaves of a relative error S/(1 − S), three times squared and multiplied by 3 S/(1 − 3 S).
        let signal_error: [f64; 3] = core::array::from_fn(|axis| {
            let share = shares[axis];
            if fixed_curvature.is_none() {
                return before[axis];
            }
            let slope = 1.0 - 3.0 * share;
            let mut left = share / (1.0 - share);
            for _ in 0..3 {
                left = 3.0 * share / slope * left * left;
            }
            before[axis] / slope + (1.5 / slope + 1.0) / unit + largest[axis] * left
        });
        let half = |bits: u32| libm::exp2(-f64::from(bits) - 1.0);
        let bound = core::array::from_fn(|i| {
            let sum: f64 = (0..3)
                .map(|j| {
                    libm::fabs(matrix[i][j]) * signal_error[j]
                        + half(matrix_bits) * (largest[j] + signal_error[j])
                })
                .sum();
            // Double precision of this calculation itself is far below a thousandth of it.
            1.001 * (sum + half(result_bits))
        });
        Ok(Self {
            outputs: range.outputs,
            signal_bits,
            bias: offset.map(|v| scaled(v, signal_bits) as i64),
            thermal: fixed_thermal,
            curvature: fixed_curvature,
            matrix_bits,
            matrix: matrix.map(|row| row.map(|v| scaled(v, matrix_bits) as i32)),
            result_bits,
            bound,
        })
    }

    /// Acceleration with [`FixedPoint::result_bits`] fraction bits; `None` where output or temperature (1/256 °C) lies
    /// outside the range the formats were chosen for.
    #[inline]
    pub fn apply(&self, output: [i32; 3], temperature: i32) -> Option<[i32; 3]> {
        let mut v = [0i64; 3];
        for axis in 0..3 {
            let [low, high] = self.outputs[axis];
            if output[axis] < low || output[axis] > high {
                return None;
            }
            v[axis] = (i64::from(output[axis]) << self.signal_bits) - self.bias[axis];
        }
        if let Some(thermal) = &self.thermal {
            if temperature < thermal.range[0] || temperature > thermal.range[1] {
                return None;
            }
            let z = (i64::from(temperature) - i64::from(thermal.reference)) << thermal.shift;
            for axis in 0..3 {
                v[axis] -= power_sum(&thermal.bias[axis], z);
                let scale = (1i64 << UNIT_BITS) + power_sum(&thermal.scale[axis], z);
                v[axis] = (v[axis] << UNIT_BITS) / scale;
            }
        }
        if let Some(curvature) = &self.curvature {
            for axis in 0..3 {
                v[axis] = straightened(v[axis], curvature.quadratic[axis], curvature.cubic[axis]);
            }
        }
        let shift = self.signal_bits + self.matrix_bits - self.result_bits;
        Some(core::array::from_fn(|i| {
            let row = &self.matrix[i];
            let sum =
                i64::from(row[0]) * v[0] + i64::from(row[1]) * v[1] + i64::from(row[2]) * v[2];
            rounded(sum, shift) as i32
        }))
    }

    /// A result of [`FixedPoint::apply`] in m/s².
    pub fn to_si(&self, acceleration: [i32; 3]) -> [f64; 3] {
        acceleration.map(|v| f64::from(v) * libm::exp2(-f64::from(self.result_bits)))
    }
}

fn out_of_range(name: &'static str, value: f64, min: f64, max: f64) -> Error {
    Error::OutOfRange {
        name,
        value,
        min,
        max,
    }
}

/// c₁ x + c₂ x² + c₃ x³ about x = d: its value there and the coefficients of x − d.
fn shifted(c: [f64; THERMAL_ORDER], d: f64) -> (f64, [f64; THERMAL_ORDER]) {
    let [c1, c2, c3] = c;
    (
        d * (c1 + d * (c2 + d * c3)),
        [c1 + d * (2.0 * c2 + 3.0 * d * c3), c2 + 3.0 * c3 * d, c3],
    )
}

/// Value / 2^shift, to the nearest, halves away from zero.
#[inline]
fn rounded(value: i64, shift: u32) -> i64 {
    let half = (1i64 << shift) >> 1;
    if value >= 0 {
        (value + half) >> shift
    } else {
        -((half - value) >> shift)
    }
}

/// c₁ z + c₂ z² + c₃ z³ with z of 30 fraction bits.
#[inline]
fn power_sum(c: &[i32; THERMAL_ORDER], z: i64) -> i64 {
    let inner = i64::from(c[1]) + rounded(i64::from(c[2]) * z, UNIT_BITS);
    rounded(
        (i64::from(c[0]) + rounded(inner * z, UNIT_BITS)) * z,
        UNIT_BITS,
    )
}

/// ξ with ξ (1 + A ξ + B ξ²) = y: three steps of Newton's method from y. A and B of 30, ξ and y of 29 fraction bits.
#[inline]
fn straightened(y: i64, a: i32, b: i32) -> i64 {
    let (a, b) = (i64::from(a), i64::from(b));
    let mut x = y;
    for _ in 0..3 {
        let bend = rounded((a + rounded(b * x, SHARE_BITS)) * x, SHARE_BITS);
        let slope =
            (1i64 << UNIT_BITS) + rounded((2 * a + rounded(3 * b * x, SHARE_BITS)) * x, SHARE_BITS);
        x -= ((x + rounded(x * bend, UNIT_BITS) - y) << UNIT_BITS) / slope;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Matrix3, SensorModel, ThermalTerms};

    fn uniform(state: &mut u64) -> f64 {
        *state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 53) as f64
    }

    fn largest_against_bound(model: &Compensation<f64>, range: FixedRange) -> f64 {
        let fixed = FixedPoint::new(model, range).unwrap();
        let (mut worst, mut state) = (0.0f64, 7);
        for _ in 0..100_000 {
            let output = range.outputs.map(|[low, high]| {
                let span = f64::from(high) - f64::from(low);
                (f64::from(low) + span * uniform(&mut state)).round() as i32
            });
            let [cold, warm] = range.temperature;
            let t = ((cold + (warm - cold) * uniform(&mut state)) * 256.0).trunc() as i32;
            let got = fixed.to_si(fixed.apply(output, t).unwrap());
            let exact = model.apply(output.map(f64::from), f64::from(t) / 256.0);
            for axis in 0..3 {
                worst = worst.max((got[axis] - exact[axis]).abs() / fixed.bound[axis]);
            }
        }
        worst
    }

    fn thermal() -> ThermalTerms<f64> {
        ThermalTerms {
            reference: 23.777,
            range: [-40.0, 85.0],
            bias: [[0.4, -1e-2, 2e-5], [-2.0, 3e-3, 0.0], [1.0, 0.0, -1e-5]],
            scale: [[2e-4, 1e-7, 0.0], [-1e-4, 0.0, 1e-9], [3e-4, -2e-7, 0.0]],
        }
    }

    /// 16-bit offset-binary, 20-bit and 24-bit sensors, with and without temperature: 10⁵ random samples each.
    #[test]
    fn law_integers_stay_within_their_bound() {
        for (scale, bias, outputs) in [
            (415.0, 33000.0, [0, 65535]),
            (26_105.0, -700.0, [-524_288, 524_287]),
            (85_000.0, 1e5, [-8_388_608, 8_388_607]),
        ] {
            let k = Matrix3([
                [scale, 0.003 * scale, -0.02 * scale],
                [0.001 * scale, 1.01 * scale, 0.004 * scale],
                [0.0, -0.007 * scale, 0.99 * scale],
            ]);
            let sensor = SensorModel::new(k, [bias, 0.98 * bias, 1.01 * bias]).unwrap();
            let range = FixedRange {
                outputs: [outputs; 3],
                temperature: [-40.0, 85.0],
            };
            // Up to three in a hundred at the ends, of both signs.
            let reach = f64::from(outputs[1]).max(-f64::from(outputs[0])) / scale;
            let curved = crate::Curvature {
                quadratic: [0.02 / reach, -0.01 / reach, 0.0],
                cubic: [
                    -0.01 / (reach * reach),
                    0.02 / (reach * reach),
                    0.03 / (reach * reach),
                ],
            };
            for terms in [None, Some(thermal())] {
                for curvature in [None, Some(curved)] {
                    let model = Compensation::new(sensor, terms, curvature, reach).unwrap();
                    let worst = largest_against_bound(&model, range);
                    // Never beyond; a bound ten times too large would be none.
                    assert!((0.1..=1.0).contains(&worst), "{worst}");
                }
            }
        }
    }

    #[test]
    fn refuses_what_integers_cannot_hold() {
        let sensor = SensorModel::new(Matrix3::diagonal([100.0; 3]), [0.0; 3]).unwrap();
        let range = FixedRange {
            outputs: [[-2000, 2000]; 3],
            temperature: [-40.0, 85.0],
        };
        let mut model = Compensation::new(sensor, Some(thermal()), None, 0.0).unwrap();
        let fixed = FixedPoint::new(&model, range).unwrap();
        assert_eq!(fixed.apply([0, 0, 2001], 20 * 256), None);
        assert_eq!(fixed.apply([0, 0, 980], 86 * 256), None);
        assert!(fixed.apply([0, 0, 980], -40 * 256).is_some());
        let reversed = FixedRange {
            outputs: [[5, 5]; 3],
            ..range
        };
        assert!(FixedPoint::new(&model, reversed).is_err());
        let mut steep = thermal();
        steep.scale[1][0] = 0.01;
        model = Compensation::new(sensor, Some(steep), None, 0.0).unwrap();
        assert!(FixedPoint::new(&model, range).is_err());
        let curved = crate::Curvature {
            quadratic: [1e-4; 3],
            cubic: [0.0; 3],
        };
        model = Compensation::new(sensor, None, Some(curved), 20.0).unwrap();
        assert!(FixedPoint::new(&model, range).is_ok());
        // At ±20 m/s² four in a hundred, at the ends of a wider converter a quarter.
        let strong = crate::Curvature {
            quadratic: [2e-3; 3],
            cubic: [0.0; 3],
        };
        model = Compensation::new(sensor, None, Some(strong), 20.0).unwrap();
        assert!(FixedPoint::new(&model, range).is_ok());
        let wider = FixedRange {
            outputs: [[-12_000, 12_000]; 3],
            ..range
        };
        assert!(FixedPoint::new(&model, wider).is_err());
    }
}
