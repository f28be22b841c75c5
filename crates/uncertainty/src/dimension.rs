//! Dimensions of units as people write them: `mV/(m/s²)`, `1/°C`, `kg·m^-3`.

/// Length, mass, time, current, temperature, amount, luminous intensity, plane angle in degrees or radians.
const BASES: usize = 7;

/// Powers of the base units, and the factor to coherent SI where it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dimension {
    powers: [i8; BASES],
    /// Factor to the coherent unit, where it is known.
    pub(crate) factor: Option<f64>,
    /// How its kelvins are meant.
    pub(crate) kelvins: Kelvins,
}

/// How the powers of the kelvin in a unit are meant: a temperature in °C counts from another zero than one in K. What is neither
/// is a difference of two temperatures, which is the same on both scales.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Kelvins {
    /// Powers written as degrees Celsius.
    pub(crate) celsius: i8,
    /// Powers written as K.
    pub(crate) absolute: i8,
}

const M: usize = 0;
const KG: usize = 1;
const S: usize = 2;
const A: usize = 3;
const K: usize = 4;

const fn of(m: i8, kg: i8, s: i8, a: i8, k: i8) -> [i8; BASES] {
    let mut powers = [0; BASES];
    powers[M] = m;
    powers[KG] = kg;
    powers[S] = s;
    powers[A] = a;
    powers[K] = k;
    powers
}

const MOL: [i8; BASES] = [0, 0, 0, 0, 0, 1, 0];
const CD: [i8; BASES] = [0, 0, 0, 0, 0, 0, 1];

/// Symbol, powers, factor, whether it takes prefixes.
const UNITS: [(&str, [i8; BASES], f64, bool); 58] = [
    ("m", of(1, 0, 0, 0, 0), 1.0, true),
    ("g", of(0, 1, 0, 0, 0), 1e-3, true),
    ("t", of(0, 1, 0, 0, 0), 1e3, false),
    ("s", of(0, 0, 1, 0, 0), 1.0, true),
    ("min", of(0, 0, 1, 0, 0), 60.0, false),
    ("h", of(0, 0, 1, 0, 0), 3600.0, false),
    ("d", of(0, 0, 1, 0, 0), 86400.0, false),
    ("A", of(0, 0, 0, 1, 0), 1.0, true),
    ("K", of(0, 0, 0, 0, 1), 1.0, true),
    ("°C", of(0, 0, 0, 0, 1), 1.0, false),
    ("℃", of(0, 0, 0, 0, 1), 1.0, false),
    ("degC", of(0, 0, 0, 0, 1), 1.0, false),
    ("mol", MOL, 1.0, true),
    ("cd", CD, 1.0, true),
    ("lm", CD, 1.0, true),
    ("rad", of(0, 0, 0, 0, 0), 1.0, true),
    ("sr", of(0, 0, 0, 0, 0), 1.0, true),
    ("°", of(0, 0, 0, 0, 0), std::f64::consts::PI / 180.0, false),
    (
        "deg",
        of(0, 0, 0, 0, 0),
        std::f64::consts::PI / 180.0,
        false,
    ),
    (
        "degree",
        of(0, 0, 0, 0, 0),
        std::f64::consts::PI / 180.0,
        false,
    ),
    (
        "degrees",
        of(0, 0, 0, 0, 0),
        std::f64::consts::PI / 180.0,
        false,
    ),
    (
        "gon",
        of(0, 0, 0, 0, 0),
        std::f64::consts::PI / 200.0,
        false,
    ),
    ("%", of(0, 0, 0, 0, 0), 1e-2, false),
    ("‰", of(0, 0, 0, 0, 0), 1e-3, false),
    ("ppm", of(0, 0, 0, 0, 0), 1e-6, false),
    ("ppb", of(0, 0, 0, 0, 0), 1e-9, false),
    ("dB", of(0, 0, 0, 0, 0), 1.0, false),
    ("Hz", of(0, 0, -1, 0, 0), 1.0, true),
    ("Bq", of(0, 0, -1, 0, 0), 1.0, true),
    ("N", of(1, 1, -2, 0, 0), 1.0, true),
    ("Pa", of(-1, 1, -2, 0, 0), 1.0, true),
    ("bar", of(-1, 1, -2, 0, 0), 1e5, true),
    ("J", of(2, 1, -2, 0, 0), 1.0, true),
    ("eV", of(2, 1, -2, 0, 0), 1.602_176_634e-19, true),
    ("W", of(2, 1, -3, 0, 0), 1.0, true),
    ("V", of(2, 1, -3, -1, 0), 1.0, true),
    ("Ω", of(2, 1, -3, -2, 0), 1.0, true),
    ("Ω", of(2, 1, -3, -2, 0), 1.0, true),
    ("ohm", of(2, 1, -3, -2, 0), 1.0, true),
    ("S", of(-2, -1, 3, 2, 0), 1.0, true),
    ("F", of(-2, -1, 4, 2, 0), 1.0, true),
    ("C", of(0, 0, 1, 1, 0), 1.0, true),
    ("H", of(2, 1, -2, -2, 0), 1.0, true),
    ("T", of(0, 1, -2, -1, 0), 1.0, true),
    ("Wb", of(2, 1, -2, -1, 0), 1.0, true),
    ("l", of(3, 0, 0, 0, 0), 1e-3, true),
    ("L", of(3, 0, 0, 0, 0), 1e-3, true),
    ("Gy", of(2, 0, -2, 0, 0), 1.0, true),
    ("Sv", of(2, 0, -2, 0, 0), 1.0, true),
    ("gn", of(1, 0, -2, 0, 0), 9.80665, true),
    ("gₙ", of(1, 0, -2, 0, 0), 9.80665, true),
    ("Gal", of(1, 0, -2, 0, 0), 1e-2, true),
    ("lx", [-2, 0, 0, 0, 0, 0, 1], 1.0, true),
    ("turn", of(0, 0, 0, 0, 0), std::f64::consts::TAU, false),
    ("rev", of(0, 0, 0, 0, 0), std::f64::consts::TAU, false),
    (
        "rpm",
        of(0, 0, -1, 0, 0),
        std::f64::consts::TAU / 60.0,
        false,
    ),
    ("count", of(0, 0, 0, 0, 0), 1.0, false),
    ("mi", of(1, 0, 0, 0, 0), 1609.344, false),
];

/// Units whose zero is not that of the kelvin.
pub(crate) const CELSIUS: [&str; 3] = ["°C", "℃", "degC"];

const PREFIXES: [(&str, f64); 20] = [
    ("da", 1e1),
    ("Y", 1e24),
    ("Z", 1e21),
    ("E", 1e18),
    ("P", 1e15),
    ("T", 1e12),
    ("G", 1e9),
    ("M", 1e6),
    ("k", 1e3),
    ("h", 1e2),
    ("d", 1e-1),
    ("c", 1e-2),
    ("m", 1e-3),
    ("µ", 1e-6),
    ("μ", 1e-6),
    ("u", 1e-6),
    ("n", 1e-9),
    ("p", 1e-12),
    ("f", 1e-15),
    ("a", 1e-18),
];

/// A symbol that a model understands as a unit.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct UnitSymbol {
    /// As it is written.
    pub symbol: &'static str,
    /// Its size in `coherent` units.
    pub factor: f64,
    /// The coherent SI unit of its kind in base units, `kg·m²·s⁻²`; `1` for a number or an angle.
    pub coherent: String,
    /// Whether it takes the prefixes of the SI.
    pub prefixes: bool,
}

/// Every symbol that a model understands as a unit, in the order in which they are looked up.
///
/// ```
/// let volt = proofmass_uncertainty::unit_symbols().find(|u| u.symbol == "V").unwrap();
/// assert_eq!((volt.factor, volt.coherent.as_str()), (1.0, "m²·kg·s⁻³·A⁻¹"));
/// ```
pub fn unit_symbols() -> impl Iterator<Item = UnitSymbol> {
    UNITS.iter().map(|&(symbol, powers, factor, prefixes)| {
        let bases = ["m", "kg", "s", "A", "K", "mol", "cd"].iter().zip(powers);
        let present = bases.filter(|(_, power)| *power != 0);
        let written: Vec<String> = present
            .map(|(base, p)| format!("{base}{}", raised(p)))
            .collect();
        UnitSymbol {
            symbol,
            factor,
            coherent: match written.is_empty() {
                true => "1".to_owned(),
                false => written.join("·"),
            },
            prefixes,
        }
    })
}

/// How many of one unit are one of another: the factor that a number is multiplied by. `None` where one is no unit, or where
/// they are of two kinds.
///
/// A temperature counts as a difference of temperatures.
///
/// ```
/// use proofmass_uncertainty::unit_ratio;
/// assert_eq!(unit_ratio("m/s²", "mgn"), Some(1.0 / 9.80665e-3));
/// assert_eq!(unit_ratio("rad", "%"), Some(100.0));
/// assert_eq!(unit_ratio("Hz", "m"), None);
/// ```
pub fn unit_ratio(from: &str, to: &str) -> Option<f64> {
    let (from, to) = (Dimension::parse(from)?, Dimension::parse(to)?);
    if !from.is_like(&to) {
        return None;
    }
    let ratio = from.factor? / to.factor?;
    (ratio.is_finite() && ratio > 0.0).then_some(ratio)
}

/// A power as it stands behind a unit.
fn raised(power: i8) -> String {
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    match power {
        1 => String::new(),
        power => power
            .to_string()
            .chars()
            .map(|c| c.to_digit(10).map_or('⁻', |d| digits[d as usize]))
            .collect(),
    }
}

impl Dimension {
    /// A pure number.
    pub fn one() -> Self {
        Self {
            powers: [0; BASES],
            factor: Some(1.0),
            kelvins: Kelvins::default(),
        }
    }

    /// Reads a unit; `None` for a label that is none.
    pub fn parse(text: &str) -> Option<Self> {
        let mut reader = Reader { rest: text.trim() };
        let mut dimension = reader.product()?;
        // 1/K alone is a relative change per step of either scale: the coefficient of a difference.
        let alone = dimension.powers == of(0, 0, 0, 0, dimension.powers[K]);
        if alone && dimension.powers[K] < 0 {
            dimension.kelvins.absolute = 0;
        }
        reader.rest.trim().is_empty().then_some(dimension)
    }

    /// The same unit with its kelvins meant so.
    pub fn meaning(self, kelvins: Kelvins) -> Self {
        Self { kelvins, ..self }
    }

    /// Power of the kelvin.
    pub fn of_temperature(&self) -> i8 {
        self.powers[K]
    }

    /// Whether it is that of a temperature and of nothing else.
    pub fn is_temperature(&self) -> bool {
        self.powers == of(0, 0, 0, 0, 1)
    }

    /// The coherent unit of its kind.
    pub fn coherent(self) -> Self {
        Self {
            factor: Some(1.0),
            ..self
        }
    }

    /// Whether both are of one kind, whatever their size.
    pub fn is_like(&self, other: &Self) -> bool {
        self.powers == other.powers
    }

    /// Whether it has no dimension.
    pub fn is_number(&self) -> bool {
        self.powers == [0; BASES]
    }

    /// This times the other to a power; `None` where the powers overflow.
    pub fn times(&self, other: &Self, power: i8) -> Option<Self> {
        let mut powers = self.powers;
        for (p, q) in powers.iter_mut().zip(other.powers) {
            *p = p.checked_add(q.checked_mul(power)?)?;
        }
        let sum = |a: i8, b: i8| a.checked_add(b.checked_mul(power)?);
        let (these, others) = (self.kelvins, other.kelvins);
        Some(Self {
            powers,
            kelvins: Kelvins {
                celsius: sum(these.celsius, others.celsius)?,
                absolute: sum(these.absolute, others.absolute)?,
            },
            factor: self
                .factor
                .zip(other.factor)
                .map(|(a, b)| a * b.powi(i32::from(power))),
        })
    }

    /// The root of every power, where all are even.
    pub fn root(&self) -> Option<Self> {
        let whole = self.powers.iter().all(|p| p % 2 == 0);
        whole.then(|| Self {
            powers: self.powers.map(|p| p / 2),
            kelvins: Kelvins {
                celsius: self.kelvins.celsius / 2,
                absolute: self.kelvins.absolute / 2,
            },
            factor: self.factor.map(f64::sqrt),
        })
    }
}

/// product := factor (('·' | '*' | ' ' | '/') factor)*; factor := ( '(' product ')' | '1' | symbol ) power?
struct Reader<'a> {
    rest: &'a str,
}

impl Reader<'_> {
    fn product(&mut self) -> Option<Dimension> {
        let mut result = Dimension::one();
        let mut power = 1;
        loop {
            let factor = self.factor()?;
            result = result.times(&factor, power)?;
            let next = self.rest.trim_start();
            let mut letters = next.chars();
            match letters.next() {
                Some('/') => power = -1,
                Some('·' | '*' | '⋅' | '×') => power = 1,
                None | Some(')') => {
                    self.rest = next;
                    return Some(result);
                }
                // A space between two units multiplies.
                Some(_) if next.len() < self.rest.len() => {
                    self.rest = next;
                    power = 1;
                    continue;
                }
                Some(_) => return None,
            }
            self.rest = letters.as_str().trim_start();
        }
    }

    fn factor(&mut self) -> Option<Dimension> {
        let base = if let Some(rest) = self.rest.strip_prefix('(') {
            self.rest = rest;
            let inner = self.product()?;
            self.rest = self.rest.strip_prefix(')')?;
            inner
        } else if let Some(rest) = self.rest.strip_prefix('1') {
            self.rest = rest;
            Dimension::one()
        } else {
            let stop = |c: char| {
                c.is_ascii_digit() || c.is_whitespace() || "/·*⋅×()^-−⁻⁺⁰¹²³⁴⁵⁶⁷⁸⁹".contains(c)
            };
            let end = self.rest.find(stop).unwrap_or(self.rest.len());
            let (symbol, rest) = self.rest.split_at(end);
            self.rest = rest;
            symbol_of(symbol)?
        };
        let power = self.power()?;
        Dimension::one().times(&base, power)
    }

    fn power(&mut self) -> Option<i8> {
        self.rest = self.rest.strip_prefix('^').unwrap_or(self.rest);
        let mut digits = String::new();
        let mut end = 0;
        for (place, c) in self.rest.char_indices() {
            let plain = match c {
                '⁻' | '−' | '-' => '-',
                '⁰' => '0',
                '¹' => '1',
                '²' => '2',
                '³' => '3',
                '⁴' => '4',
                '⁵' => '5',
                '⁶' => '6',
                '⁷' => '7',
                '⁸' => '8',
                '⁹' => '9',
                c if c.is_ascii_digit() => c,
                _ => break,
            };
            digits.push(plain);
            end = place + c.len_utf8();
        }
        self.rest = &self.rest[end..];
        if digits.is_empty() {
            Some(1)
        } else {
            digits.parse().ok()
        }
    }
}

fn symbol_of(symbol: &str) -> Option<Dimension> {
    let known = |name: &str| UNITS.iter().find(|u| u.0 == name);
    if let Some((_, powers, factor, _)) = known(symbol) {
        let celsius = i8::from(CELSIUS.contains(&symbol));
        return Some(Dimension {
            powers: *powers,
            factor: Some(*factor),
            kelvins: Kelvins {
                celsius,
                absolute: powers[K] - celsius,
            },
        });
    }
    PREFIXES.iter().find_map(|(prefix, size)| {
        let (_, powers, factor, _) = known(symbol.strip_prefix(prefix)?).filter(|u| u.3)?;
        Some(Dimension {
            powers: *powers,
            factor: Some(size * factor),
            kelvins: Kelvins {
                celsius: 0,
                absolute: powers[K],
            },
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_units_in_many_spellings() {
        let same = |a: &str, b: &str| {
            let (x, y) = (Dimension::parse(a).unwrap(), Dimension::parse(b).unwrap());
            assert!(x.is_like(&y), "{a} {b}");
            let (f, g) = (x.factor.unwrap(), y.factor.unwrap());
            assert!((f / g - 1.0).abs() < 1e-12, "{a} {b}: {f} {g}");
        };
        same("m/s²", "m s^-2");
        same("mV/(m/s²)", "mV·s²/m");
        same("kg/m³", "g/L");
        same("1/°C", "K^-1");
        same("µm", "um");
        same("W/(m²·K⁴)", "W m⁻² K⁻⁴");
        same("N*m", "J");
        same("V/A", "Ω");
        same("1", "rad");
        for label in ["not a unit", "mm$", "quux", "m//s", "(m", "m)"] {
            assert!(Dimension::parse(label).is_none(), "{label}");
        }
    }
}
