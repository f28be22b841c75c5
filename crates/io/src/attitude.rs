//! Attitudes as tables and campaigns give them: a word, a vector, two angles, or the true acceleration itself.

use crate::sheet::{ACCELERATION, ANGLE, Endings, Place, Sheet, SheetRow};
use crate::{Error, ErrorKind, Result};
use proofmass_core::Matrix3;

/// What is said of the specific force in one standstill, in the axes of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct GivenAttitude {
    /// Its direction, a unit vector: at rest the one that points up.
    pub direction: [f64; 3],
    /// The true acceleration, where it was given itself.
    pub acceleration: Option<TrueAcceleration>,
}

/// A true acceleration that somebody states.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TrueAcceleration {
    /// Components in the axes of the sensor, m/s².
    pub value: [f64; 3],
    /// Standard uncertainty of each component, m/s², where it stands beside them.
    pub standard_uncertainty: Option<f64>,
}

/// Angle beyond which two statements of one attitude contradict each other: a word names a face of a fixture, which lies
/// some degrees off, and the nearest other word is 35° away.
const CONTRADICTION: f64 = 5.0;
/// Lengths of typed directions that count as one: three digits leave less than a hundredth.
const TYPED: f64 = 0.01;

impl GivenAttitude {
    /// A word: `+x`, `-z`, and between axes `+x+y` or `-x+y-z`, halfway.
    ///
    /// # Errors
    /// A word that is no attitude.
    ///
    /// ```
    /// let up = proofmass_io::GivenAttitude::word("-x+z")?;
    /// assert!((up.direction[2] - 0.5f64.sqrt()).abs() < 1e-15 && up.direction[0] == -up.direction[2]);
    /// # Ok::<(), proofmass_io::Error>(())
    /// ```
    pub fn word(word: &str) -> Result<Self> {
        let text = word.trim().to_ascii_lowercase().replace('−', "-");
        let mut direction = [0.0f64; 3];
        let mut sign = None;
        let mut axes = 0;
        for letter in text.chars() {
            let axis = match letter {
                '+' | '-' if sign.is_none() => {
                    sign = Some(if letter == '+' { 1.0 } else { -1.0 });
                    continue;
                }
                'x' => 0,
                'y' => 1,
                'z' => 2,
                _ => return Err(no_word(word)),
            };
            // The first axis alone may stand without its sign.
            let Some(sign) = sign.take().or((axes == 0).then_some(1.0)) else {
                return Err(no_word(word));
            };
            if direction[axis] != 0.0 {
                let what = format!("\"{word}\" is not an attitude: it names {letter} twice");
                return Err(Error::new(ErrorKind::Field, what).with_hint(WORDS));
            }
            direction[axis] = sign;
            axes += 1;
        }
        if axes == 0 || sign.is_some() {
            return Err(no_word(word));
        }
        let length = f64::from(axes).sqrt();
        Ok(Self::from(direction.map(|c| c / length)))
    }

    /// A unit vector, as many digits as were typed.
    ///
    /// # Errors
    /// A length that is not one.
    pub fn vector(v: [f64; 3]) -> Result<Self> {
        let length = norm(v);
        // Directions are often typed with three digits; a length far from one is a mistake.
        if !((length - 1.0).abs() <= TYPED) {
            return Err(Error::new(
                ErrorKind::Row,
                format!("the direction ({}, {}, {}) has the length {length:.4}", v[0], v[1], v[2]),
            )
            .with_hint("give a unit vector: the direction of the true specific force in the sensor's frame"));
        }
        Ok(Self::from(v.map(|c| c / length)))
    }

    /// Roll and pitch, rad, as [`TaitBryan`](proofmass_core::TaitBryan) has them: from z up the sensor is rolled about its x axis,
    /// then pitched about the level y axis, so that up is (−sin pitch, cos pitch sin roll, cos pitch cos roll).
    ///
    /// # Errors
    /// Angles beyond a turn, which are likely in another unit.
    pub fn angles(roll: f64, pitch: f64) -> Result<Self> {
        for (name, angle) in [("roll", roll), ("pitch", pitch)] {
            if !(angle.abs() <= std::f64::consts::TAU) {
                return Err(Error::new(
                    ErrorKind::Row,
                    format!("a {name} of {:.6}° is more than a turn", angle.to_degrees()),
                )
                .with_hint("give the angles in degrees as roll_deg and pitch_deg, or in radians as roll_rad and pitch_rad"));
            }
        }
        let turned = proofmass_core::TaitBryan::new(roll, pitch, 0.0)
            .map_err(|e| Error::new(ErrorKind::Row, e.to_string()))?;
        // The last row of R is the vertical of the machine in the axes of the sensor.
        let Matrix3([_, _, up]) = turned.matrix::<f64>();
        Ok(Self::from(up))
    }

    /// The true acceleration, m/s², in the axes of the sensor, with the standard uncertainty of each component where it is stated.
    ///
    /// # Errors
    /// A length of zero; an uncertainty that is negative or no number.
    pub fn acceleration(value: [f64; 3], standard_uncertainty: Option<f64>) -> Result<Self> {
        let length = norm(value);
        if !(length > 0.0 && length.is_finite()) {
            return Err(
                Error::new(ErrorKind::Row, "the true acceleration has the length zero").with_hint(
                    "give a_true_x, a_true_y and a_true_z of a sensor at rest: their length is gravity; a sensor in free fall has no attitude",
                ),
            );
        }
        if let Some(u) = standard_uncertainty
            && !(u >= 0.0 && u.is_finite())
        {
            return Err(Error::new(
                ErrorKind::Row,
                format!("a standard uncertainty of {u} is out of range: it must not be negative"),
            )
            .with_hint("give a number from zero up"));
        }
        Ok(Self {
            direction: value.map(|c| c / length),
            acceleration: Some(TrueAcceleration {
                value,
                standard_uncertainty,
            }),
        })
    }

    /// Angle between two attitudes, degrees.
    pub fn angle_to_deg(&self, other: &Self) -> f64 {
        let (a, b) = (self.direction, other.direction);
        let difference: [f64; 3] = std::array::from_fn(|i| a[i] - b[i]);
        let sum: [f64; 3] = std::array::from_fn(|i| a[i] + b[i]);
        (2.0 * norm(difference).atan2(norm(sum))).to_degrees()
    }
}

impl From<[f64; 3]> for GivenAttitude {
    /// A direction of length one.
    fn from(direction: [f64; 3]) -> Self {
        Self {
            direction,
            acceleration: None,
        }
    }
}

const WORDS: &str = "write +x, -x, +y, -y, +z or -z, the axis of the sensor that points up, or several where it points between them: +x+y, -x+z, +x-y+z";

fn no_word(word: &str) -> Error {
    Error::new(ErrorKind::Field, format!("\"{word}\" is not a direction")).with_hint(WORDS)
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// The columns of a table that give attitudes, under the names that every table has for them: `direction`; `up_x`, `up_y`, `up_z`;
/// `roll_deg`, `pitch_deg`; `a_true_x_m/s2`, … with `u_a_true_m/s2`.
#[derive(Clone, Copy, Debug)]
pub struct AttitudeColumns {
    form: Option<Form>,
    truth: Option<([Place; 3], Option<Place>)>,
}

#[derive(Clone, Copy, Debug)]
enum Form {
    Word(Place),
    Vector([Place; 3]),
    Angles([Place; 2]),
}

const VECTOR: [&str; 3] = ["up_x", "up_y", "up_z"];
const ANGLES: [&str; 2] = ["roll", "pitch"];
const TRUE: [&str; 3] = ["a_true_x", "a_true_y", "a_true_z"];
const TRUE_U: &str = "u_a_true";

impl AttitudeColumns {
    /// Whether any heading of a table is one of them.
    pub fn are_in(header: &[String]) -> bool {
        let begins = |heading: &str, name: &str| {
            heading
                .strip_prefix(name)
                .is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        };
        header.iter().map(|h| h.trim()).any(|heading| {
            heading == "direction"
                || VECTOR.contains(&heading)
                || ["a_true", TRUE_U].iter().any(|name| begins(heading, name))
                || ANGLES.iter().any(|name| {
                    // "roll" alone may be anything; with its unit it is an angle.
                    ANGLE
                        .iter()
                        .any(|(unit, _)| heading == format!("{name}_{unit}"))
                })
        })
    }

    /// Claims them; `None` where there is none.
    ///
    /// # Errors
    /// A part of the columns of one form; two forms at once; a unit that is no acceleration.
    pub fn claim(sheet: &mut Sheet) -> Result<Option<Self>> {
        let word = sheet.text("direction").map(Form::Word);
        let vector = {
            let found = VECTOR.map(|name| sheet.text(name));
            whole(sheet, found, &VECTOR, "")?.map(Form::Vector)
        };
        let angles = whole_of(sheet, &ANGLES, ANGLE)?.map(Form::Angles);
        let truth = whole_of(sheet, &TRUE, ACCELERATION)?;
        let u = sheet.quantity(TRUE_U, ACCELERATION)?;
        let foreign = sheet.header().iter().find(|heading| {
            let own = heading.trim();
            (own.starts_with("a_true") || own.starts_with(TRUE_U)) && !sheet.is_claimed(heading)
        });
        if let Some(heading) = foreign {
            return Err(sheet
                .header_error(heading, "this is no column of a true acceleration")
                .with_hint(format!(
                    "write a_true_x_m/s2, a_true_y_m/s2, a_true_z_m/s2 and {TRUE_U}_m/s2, or with _g or _mg in place of _m/s2"
                )));
        }
        if truth.is_none() && u.is_some() {
            return Err(Error::new(
                ErrorKind::Column,
                format!("{TRUE_U} stands without a_true_x, a_true_y, a_true_z"),
            )
            .line(sheet.header_line())
            .with_hint("give the three components beside it"));
        }
        let mut forms = [word, vector, angles].into_iter().flatten();
        let form = forms.next();
        if forms.next().is_some() {
            return Err(Error::new(
                ErrorKind::Column,
                "`direction`, `up_x` … and `roll_deg` … exclude each other",
            )
            .line(sheet.header_line())
            .with_hint("keep one of the forms; their fields may stay empty in a row"));
        }
        let truth = truth.map(|places| (places, u));
        Ok((form.is_some() || truth.is_some()).then_some(Self { form, truth }))
    }

    /// What a row says; `None` where its fields are empty.
    ///
    /// # Errors
    /// A field that says nothing; an attitude and a true acceleration that contradict each other.
    pub fn of(&self, row: &SheetRow<'_>) -> Result<Option<GivenAttitude>> {
        let says = |places: &[Place]| places.iter().any(|p| !row.text(*p).trim().is_empty());
        let at = |place: Place| move |e: Error| row.in_field(place, e);
        let named = match &self.form {
            Some(Form::Word(place)) if says(&[*place]) => {
                Some(GivenAttitude::word(row.text(*place)).map_err(at(*place))?)
            }
            Some(Form::Vector(places)) if says(places) => {
                Some(GivenAttitude::vector(numbers(row, *places)?).map_err(at(places[0]))?)
            }
            Some(Form::Angles(places)) if says(places) => {
                let [roll, pitch] = numbers(row, *places)?;
                Some(GivenAttitude::angles(roll, pitch).map_err(at(places[0]))?)
            }
            _ => None,
        };
        let Some((places, u)) = self.truth.filter(|(places, _)| says(places)) else {
            return Ok(named);
        };
        let u = match u {
            Some(place) => row.optional(Some(place))?,
            None => None,
        };
        let truth = GivenAttitude::acceleration(numbers(row, places)?, u).map_err(at(places[0]))?;
        if let Some(named) = named {
            check_agreement(&named, &truth).map_err(at(places[0]))?;
        }
        Ok(Some(truth))
    }
}

/// Refuses two statements of one attitude that are no statement of one.
///
/// # Errors
/// They are more than five degrees apart.
pub fn check_agreement(named: &GivenAttitude, truth: &GivenAttitude) -> Result<()> {
    let apart = named.angle_to_deg(truth);
    if apart <= CONTRADICTION {
        return Ok(());
    }
    Err(Error::new(
        ErrorKind::Row,
        format!("the attitude and the true acceleration contradict each other: they are {apart:.1}° apart"),
    )
    .with_hint("both are the specific force in the axes of the sensor, which at rest points up: +x is (+g, 0, 0); correct one, or leave one empty"))
}

fn numbers<const N: usize>(row: &SheetRow<'_>, places: [Place; N]) -> Result<[f64; N]> {
    let mut all = [0.0; N];
    for (value, place) in all.iter_mut().zip(places) {
        *value = row.number(place)?;
    }
    Ok(all)
}

fn whole_of<const N: usize>(
    sheet: &mut Sheet,
    names: &[&str; N],
    endings: Endings,
) -> Result<Option<[Place; N]>> {
    let mut found = [None; N];
    for (place, name) in found.iter_mut().zip(names) {
        *place = sheet.quantity(name, endings)?;
    }
    whole(sheet, found, names, "with their unit, ")
}

fn whole<const N: usize>(
    sheet: &Sheet,
    found: [Option<Place>; N],
    names: &[&str; N],
    how: &str,
) -> Result<Option<[Place; N]>> {
    let places: Vec<Place> = found.iter().flatten().copied().collect();
    if places.is_empty() {
        return Ok(None);
    }
    <[Place; N]>::try_from(places).map(Some).map_err(|_| {
        Error::new(
            ErrorKind::Column,
            format!("of {} some are missing", names.join(", ")),
        )
        .line(sheet.header_line())
        .with_hint(format!("give all of them, {how}or none"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_words_between_axes() -> Result<()> {
        let (two, three) = (0.5f64.sqrt(), (1.0f64 / 3.0).sqrt());
        for (word, direction) in [
            ("+x", [1.0, 0.0, 0.0]),
            ("y", [0.0, 1.0, 0.0]),
            (" −Z ", [0.0, 0.0, -1.0]),
            ("+x+y", [two, two, 0.0]),
            ("-x+z", [-two, 0.0, two]),
            ("x-y+z", [three, -three, three]),
        ] {
            let read = GivenAttitude::word(word)?.direction;
            // A division by a rounded root.
            let off = (0..3).map(|i| (read[i] - direction[i]).abs());
            assert!(off.fold(0.0, f64::max) <= f64::EPSILON, "{word}: {read:?}");
        }
        for word in [
            "", "up", "+", "+x+", "xy", "+x+x", "++x", "+x-x", "+w", "+x +y z",
        ] {
            assert!(GivenAttitude::word(word).is_err(), "{word}");
        }
        Ok(())
    }

    #[test]
    fn law_forms_of_one_attitude_are_one() -> Result<()> {
        let word = GivenAttitude::word("-x+z")?;
        let vector = GivenAttitude::vector([-0.70705, 0.0, 0.70705])?;
        let angles = GivenAttitude::angles(0.0, std::f64::consts::FRAC_PI_4)?;
        let truth = GivenAttitude::acceleration([-6.9, 0.0, 6.9], None)?;
        for other in [vector, angles, truth] {
            // Rounding of a sine and of a root, no more.
            assert!(word.angle_to_deg(&other) < 1e-13, "{other:?}");
        }
        assert_eq!(GivenAttitude::angles(0.0, 0.0)?.direction[2], 1.0);
        assert!((GivenAttitude::word("+x")?.angle_to_deg(&word) - 135.0).abs() < 1e-12);
        Ok(())
    }
}
