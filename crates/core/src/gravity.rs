//! Local gravity: what every static calibration measures against.

use crate::Error;

/// Standard acceleration of gravity, exact, in m/s². **Source** `[CGPM1901]`.
pub const STANDARD_GRAVITY: f64 = 9.806_65;

/// Local acceleration of gravity with its standard uncertainty, both in m/s².
#[doc(alias("g", "local gravity", "Somigliana"))]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "Form")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Gravity {
    /// Magnitude, m/s².
    value: f64,
    /// Its standard uncertainty, m/s².
    standard_uncertainty: f64,
}

/// The form in a file, before it is checked.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Form {
    /// Magnitude, m/s².
    value: f64,
    /// Its standard uncertainty, m/s².
    standard_uncertainty: f64,
}

#[cfg(feature = "serde")]
impl TryFrom<Form> for Gravity {
    type Error = Error;

    fn try_from(form: Form) -> Result<Self, Error> {
        Self::given(form.value, form.standard_uncertainty)
    }
}

/// GRS80: equatorial normal gravity, m/s². **Source** `[Moritz2000]`.
const EQUATOR: f64 = 9.780_326_771_5;
/// GRS80: constant k of Somigliana's closed formula.
const SOMIGLIANA: f64 = 0.001_931_851_353;
/// GRS80: first eccentricity squared.
const ECCENTRICITY_2: f64 = 0.006_694_380_022_90;
/// GRS80: semi-major axis, m.
const SEMI_MAJOR: f64 = 6_378_137.0;
/// GRS80: flattening.
const FLATTENING: f64 = 0.003_352_810_681_18;
/// GRS80: geodetic parameter m = ω²a²b/GM.
const GEODETIC_M: f64 = 0.003_449_786_003_08;

/// Standard deviation of real gravity about the normal field, m/s²: free-air anomalies are some 30 mGal in
/// root mean square over land, single mountains and trenches reach 200 mGal.
const ANOMALY: f64 = 3.0e-4;

impl Gravity {
    /// A value given by a measurement or a gravity service.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] outside 9.7 … 9.9 m/s², which no place on land leaves
    /// (9.7639 to 9.8337), and for a negative uncertainty.
    pub fn given(value: f64, standard_uncertainty: f64) -> Result<Self, Error> {
        check("gravity", value, 9.7, 9.9)?;
        check("uncertainty of gravity", standard_uncertainty, 0.0, 0.1)?;
        Ok(Self {
            value,
            standard_uncertainty,
        })
    }

    /// Normal gravity of the GRS80 ellipsoid at a geodetic latitude (degrees) and height (metres).
    ///
    /// γ₀ = γ_e (1 + k sin²φ)/√(1 − e² sin²φ), then γ_h = γ₀ [1 − 2(1 + f + m − 2f sin²φ) h/a + 3h²/a²].
    ///
    /// The standard uncertainty is that of gravity about the normal field (300 µm/s², 30 mGal), with the share
    /// of the two coordinates' own standard uncertainties (degrees, metres) added.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] outside ±90° and −500 … 9000 m; [`Error::NotFinite`].
    ///
    /// **Source** `[Moritz2000]` (Somigliana's formula; second-order free-air term `[HeiskanenMoritz]` 2-123).
    ///
    /// ```
    /// use proofmass_core::Gravity;
    /// let equator = Gravity::normal(0.0, 0.0, 0.0, 0.0)?;
    /// assert!((equator.value() - 9.780_326_8).abs() < 1e-7);
    /// # Ok::<(), proofmass_core::Error>(())
    /// ```
    pub fn normal(
        latitude_deg: f64,
        height: f64,
        latitude_uncertainty_deg: f64,
        height_uncertainty: f64,
    ) -> Result<Self, Error> {
        check("latitude", latitude_deg, -90.0, 90.0)?;
        check("height", height, -500.0, 9000.0)?;
        check(
            "uncertainty of the latitude",
            latitude_uncertainty_deg,
            0.0,
            90.0,
        )?;
        check("uncertainty of the height", height_uncertainty, 0.0, 9000.0)?;
        let value = normal_gravity(latitude_deg, height);
        // Differences over one uncertainty: the sensitivity to latitude vanishes at the equator and the poles,
        // where a derivative would claim perfect knowledge.
        let spread = |lat: f64, h: f64| {
            let latitude = lat.clamp(-90.0, 90.0);
            normal_gravity(latitude, h) - value
        };
        let by_latitude = spread(latitude_deg + latitude_uncertainty_deg, height)
            .abs()
            .max(spread(latitude_deg - latitude_uncertainty_deg, height).abs());
        let by_height = spread(latitude_deg, height + height_uncertainty);
        let variance = ANOMALY * ANOMALY + by_latitude * by_latitude + by_height * by_height;
        Ok(Self {
            value,
            standard_uncertainty: libm::sqrt(variance),
        })
    }

    /// Local gravity, m/s².
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Its standard uncertainty, m/s².
    pub fn standard_uncertainty(&self) -> f64 {
        self.standard_uncertainty
    }
}

fn normal_gravity(latitude_deg: f64, height: f64) -> f64 {
    let s = libm::sin(latitude_deg.to_radians());
    let s2 = s * s;
    let surface = EQUATOR * (1.0 + SOMIGLIANA * s2) / libm::sqrt(1.0 - ECCENTRICITY_2 * s2);
    let h = height / SEMI_MAJOR;
    let gradient = 1.0 + FLATTENING + GEODETIC_M - 2.0 * FLATTENING * s2;
    surface * (1.0 - 2.0 * gradient * h + 3.0 * h * h)
}

fn check(name: &'static str, value: f64, min: f64, max: f64) -> Result<(), Error> {
    if !value.is_finite() {
        return Err(Error::NotFinite { name, index: 0 });
    }
    if value < min || value > max {
        return Err(Error::OutOfRange {
            name,
            value,
            min,
            max,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_grs80_normal_gravity() {
        // `[Moritz2000]`: γ_e = 9.780 326 7715, γ_p = 9.832 186 3685, γ(45°) = 9.806 199 203 m/s².
        for (latitude, expected) in [
            (0.0, 9.780_326_771_5),
            (45.0, 9.806_199_203),
            (90.0, 9.832_186_368_5),
        ] {
            let g = Gravity::normal(latitude, 0.0, 0.0, 0.0).unwrap().value();
            assert!((g - expected).abs() < 6e-10, "{latitude}: {g}");
        }
    }

    #[test]
    fn known_free_air_gradient() {
        // −0.3086 mGal/m, the free-air gradient of every textbook (four digits).
        let low = Gravity::normal(45.0, 0.0, 0.0, 0.0).unwrap().value();
        let high = Gravity::normal(45.0, 1.0, 0.0, 0.0).unwrap().value();
        assert!(((high - low) - -3.086e-6).abs() < 5e-10);
    }

    #[test]
    fn law_uncertainty_of_height_enters() {
        let rough = Gravity::normal(45.0, 240.0, 0.0, 1000.0).unwrap();
        let expected = f64::hypot(3.0e-4, 3.086e-3);
        assert!((rough.standard_uncertainty() / expected - 1.0).abs() < 2e-3);
    }

    #[test]
    fn refuses_other_planets() {
        assert!(Gravity::given(3.71, 0.01).unwrap_err().is_input());
        assert!(Gravity::given(f64::NAN, 0.01).unwrap_err().is_data());
        assert!(Gravity::given(9.81, -0.01).unwrap_err().is_input());
        assert!(Gravity::normal(91.0, 0.0, 0.0, 0.0).is_err());
    }
}
