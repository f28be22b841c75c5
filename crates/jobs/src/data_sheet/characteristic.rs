//! What a data sheet promises, by the terms of the field, and which quantities of results show it.

use proofmass_documents::at_frequency;
use proofmass_noise::Term;

/// A characteristic of a device.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Characteristic {
    /// A coefficient of the noise.
    Noise(Term),
    /// Anything else.
    Of(&'static Known),
}

/// What is measured to show a characteristic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Measurement {
    /// A recording at rest.
    Noise,
    /// Rests in many attitudes.
    Positions,
    /// Rests at several temperatures.
    Temperature,
    /// Accelerations of many sizes.
    Levels,
    /// Sinusoidal vibration beside a reference.
    Shaker,
    /// Vibration across the axis, from all sides.
    Transverse,
    /// A frequency response.
    Response,
    /// Calibrations over months.
    Calibrations,
}

impl Measurement {
    /// The command that evaluates it.
    pub fn command(self) -> &'static str {
        match self {
            Self::Noise => "proofmass noise",
            Self::Positions => "proofmass calibrate",
            Self::Temperature => "proofmass test temperature",
            Self::Levels => "proofmass test linearity",
            Self::Shaker => "proofmass calibrate (shaker)",
            Self::Transverse => "proofmass calibrate (transverse)",
            Self::Response => "proofmass test random, then model",
            Self::Calibrations => "proofmass test stability",
        }
    }
}

/// A characteristic that results state as quantities.
#[derive(Debug, PartialEq)]
#[non_exhaustive]
pub struct Known {
    /// Its name in a sheet.
    pub name: &'static str,
    /// Other words for it.
    pub also: &'static [&'static str],
    /// What it is.
    pub what: &'static str,
    /// A unit of its kind, where it has one; none where outputs of every unit have it.
    pub unit: Option<&'static str>,
    /// Whether it may have either sign.
    pub signed: bool,
    /// What is measured to show it; a scale over frequency is shown on a shaker.
    pub shown_by: Measurement,
}

const fn known(
    name: &'static str,
    also: &'static [&'static str],
    what: &'static str,
    unit: Option<&'static str>,
    shown_by: Measurement,
) -> Known {
    Known {
        name,
        also,
        what,
        unit,
        signed: true,
        shown_by,
    }
}

/// One that has no sign.
const fn size(
    name: &'static str,
    also: &'static [&'static str],
    what: &'static str,
    unit: Option<&'static str>,
    shown_by: Measurement,
) -> Known {
    Known {
        signed: false,
        ..known(name, also, what, unit, shown_by)
    }
}

static KNOWN: [Known; 15] = [
    known(
        "bias",
        &["zero-g-offset", "zero-g", "offset"],
        "output at no acceleration; in an acceleration divided by the scale",
        None,
        Measurement::Positions,
    ),
    known(
        "scale",
        &["sensitivity", "scale-factor"],
        "output per acceleration, also over frequency",
        None,
        Measurement::Positions,
    ),
    known(
        "misalignment",
        &["cross-axis", "cross-axis-sensitivity"],
        "response of one axis to another, by pairs (xy)",
        Some("rad"),
        Measurement::Positions,
    ),
    known(
        "non-orthogonality",
        &["orthogonality"],
        "departure of two axes from a right angle, by pairs (xy)",
        Some("rad"),
        Measurement::Positions,
    ),
    size(
        "transverse-sensitivity",
        &["transverse"],
        "largest response across the axis over that along it",
        Some("1"),
        Measurement::Transverse,
    ),
    known(
        "second-order",
        &["K2", "second-order-nonlinearity"],
        "second-order non-linearity",
        Some("1/(m/s²)"),
        Measurement::Levels,
    ),
    known(
        "third-order",
        &["K3", "third-order-nonlinearity"],
        "third-order non-linearity",
        Some("1/(m/s²)²"),
        Measurement::Levels,
    ),
    known(
        "bias-temperature",
        &["bias-temperature-coefficient", "offset-temperature"],
        "change of the bias per kelvin",
        None,
        Measurement::Temperature,
    ),
    known(
        "scale-temperature",
        &["scale-temperature-coefficient", "sensitivity-temperature"],
        "relative change of the scale per kelvin",
        Some("1/K"),
        Measurement::Temperature,
    ),
    known(
        "bias-drift",
        &["drift"],
        "change of the bias per month",
        None,
        Measurement::Calibrations,
    ),
    size(
        "resonance",
        &["resonance-frequency", "natural-frequency"],
        "frequency of the first resonance",
        Some("Hz"),
        Measurement::Response,
    ),
    size(
        "damping",
        &["damping-ratio"],
        "damping ratio of the first resonance",
        Some("1"),
        Measurement::Response,
    ),
    size(
        "bandwidth",
        &["corner"],
        "corner of the low-pass of a fitted model",
        Some("Hz"),
        Measurement::Response,
    ),
    size(
        "low-corner",
        &["high-pass-corner"],
        "corner of the high-pass of a fitted model",
        Some("Hz"),
        Measurement::Response,
    ),
    size(
        "delay",
        &["latency"],
        "delay of the output",
        Some("s"),
        Measurement::Response,
    ),
];

/// Every characteristic beside the coefficients of the noise.
pub fn characteristics() -> &'static [Known] {
    &KNOWN
}

/// Letters of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Kinds of results whose quantities are those of a device.
const KINDS: [&str; 12] = [
    "multi-position",
    "free-living",
    "temperature",
    "static-test",
    "shaker-single",
    "shaker-primary",
    "shaker-triaxial",
    "transverse-sensitivity",
    "frequency-response-test",
    "level-linearity",
    "step",
    "noise",
];

/// Whether results of a kind state quantities of a device.
pub(crate) fn is_of_a_device(kind: &str) -> bool {
    KINDS.contains(&kind)
}

impl Characteristic {
    /// By its name or another word for it; else the nearest name.
    pub(crate) fn named(text: &str) -> Result<Self, Option<&'static str>> {
        let word = text.trim();
        if let Ok(term) = word.parse::<Term>()
            && word == term.symbol()
        {
            return Ok(Self::Noise(term));
        }
        let same = |name: &str| name.eq_ignore_ascii_case(&word.replace(['_', ' '], "-"));
        let found = KNOWN
            .iter()
            .find(|k| same(k.name) || k.also.iter().any(|a| same(a)));
        match found {
            Some(known) => Ok(Self::Of(known)),
            None => {
                let names = KNOWN
                    .iter()
                    .flat_map(|k| std::iter::once(k.name).chain(k.also.iter().copied()));
                Err(proofmass_io::spelling::nearest(word, names))
            }
        }
    }

    /// What is measured to show it, at rest or over frequency.
    pub fn shown_by(self, over_frequency: bool) -> Measurement {
        match self {
            Self::Noise(_) => Measurement::Noise,
            Self::Of(known) if known.name == "scale" && over_frequency => Measurement::Shaker,
            Self::Of(known) => known.shown_by,
        }
    }

    /// Its name in a sheet.
    pub fn name(self) -> &'static str {
        match self {
            Self::Noise(term) => term.symbol(),
            Self::Of(known) => known.name,
        }
    }
}

/// What a quantity of a result is: the name of the characteristic, the axis (empty for a device of one), the frequency.
pub(crate) fn shown_by(kind: &str, quantity: &str) -> Option<(&'static str, String, Option<f64>)> {
    if !is_of_a_device(kind) || kind == "noise" {
        return None;
    }
    let (base, frequency) = match at_frequency(quantity) {
        Some((base, frequency)) => (base, Some(frequency)),
        None => (quantity.to_owned(), None),
    };
    let axis = |a: &str| AXES.contains(&a);
    let pair = |p: &str| {
        let mut letters = p.chars();
        let both = [letters.next(), letters.next()];
        letters.next().is_none()
            && both.iter().flatten().count() == 2
            && both.iter().flatten().all(|c| ('x'..='z').contains(c))
            && both[0] != both[1]
    };
    let parts: Vec<&str> = base.split('.').collect();
    let found = match parts[..] {
        ["bias"] => ("bias", ""),
        ["bias", a] if axis(a) => ("bias", a),
        // That of a test over levels is at a frequency which its result does not state.
        ["sensitivity"] if kind == "level-linearity" => return None,
        ["scale" | "sensitivity"] | ["S", "modulus"] | ["modulus"] => ("scale", ""),
        ["scale", a] if axis(a) => ("scale", a),
        ["S", "xx", "modulus"] => ("scale", "x"),
        ["S", "yy", "modulus"] => ("scale", "y"),
        ["S", "zz", "modulus"] => ("scale", "z"),
        ["misalignment", p] if pair(p) => ("misalignment", p),
        ["orthogonality", p] if pair(p) => ("non-orthogonality", p),
        ["transverse"] => ("transverse-sensitivity", ""),
        ["transverse", a] if axis(a) => ("transverse-sensitivity", a),
        ["curvature", "2"] | ["amplitude_coefficient"] => ("second-order", ""),
        ["curvature", "3"] => ("third-order", ""),
        ["curvature", a, "2"] if axis(a) => ("second-order", a),
        ["curvature", a, "3"] if axis(a) => ("third-order", a),
        ["slope"] | ["bias", "T1"] => ("bias-temperature", ""),
        ["slope", a] | ["bias", a, "T1"] if axis(a) => ("bias-temperature", a),
        ["scale", "T1"] => ("scale-temperature", ""),
        ["scale", a, "T1"] if axis(a) => ("scale-temperature", a),
        ["drift", "bias"] => ("bias-drift", ""),
        ["drift", "bias", a] if axis(a) => ("bias-drift", a),
        ["mode", "1", "frequency"] | ["resonance", "frequency"] => ("resonance", ""),
        ["frequency"] if kind == "step" => ("resonance", ""),
        ["mode", "1", "damping"] | ["resonance", "damping"] => ("damping", ""),
        ["damping"] if kind == "step" => ("damping", ""),
        ["low_pass", "corner"] => ("bandwidth", ""),
        ["high_pass", "corner"] => ("low-corner", ""),
        ["delay"] => ("delay", ""),
        _ => return None,
    };
    Some((found.0, found.1.to_owned(), frequency))
}

/// The axis that a channel of a recording is named after: `acc_x` and `ax` are x.
pub(crate) fn axis_of_channel(channel: &str) -> Option<&'static str> {
    let lower = channel.trim().to_ascii_lowercase();
    let rest = |a: &str| lower.strip_suffix(a).map(str::to_owned);
    AXES.into_iter().find(|a| match rest(a) {
        Some(before) => {
            before.is_empty()
                || before.ends_with(['_', '.', '-', ' '])
                || matches!(before.as_str(), "a" | "acc" | "accel")
        }
        None => false,
    })
}
