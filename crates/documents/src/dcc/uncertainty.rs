//! What is stated of the uncertainty of a quantity: expanded with k and probability, or standard.

use super::quantity::{self, Numbers};
use crate::xml::{Element, Namespace};
use proofmass_io::Result;
use proofmass_uncertainty::{dof_of_coverage_factor, normal_quantile, student_quantile};

/// Relative difference that rounding may make between k and the probability: 2 and 95 % differ by two per cent.
const ROUNDED: f64 = 0.05;

/// Half an interval over u below which the two contradict each other.
const SHORT: f64 = 0.5;

/// Degrees of freedom below which a coverage factor is doubted.
const FEW_DEGREES: f64 = 4.0;

/// The uncertainty of the values of a quantity, in their unit. A list of one holds for all values.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct DccUncertainty {
    /// As stated: expanded where there is a k, else standard.
    pub stated: Vec<f64>,
    /// Coverage factors; empty for standard uncertainties.
    pub k: Vec<f64>,
    /// Probabilities of the intervals; empty where none is stated.
    pub probability: Vec<f64>,
    /// Distribution, where one is stated for all values.
    pub distribution: Option<String>,
    /// The first value that does not lie in the interval that is stated of it.
    pub(super) outside: Option<Outside>,
}

/// A value with the interval that does not hold it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Outside {
    pub(super) value: f64,
    pub(super) interval: [f64; 2],
}

impl DccUncertainty {
    /// Standard uncertainty of a value.
    pub fn standard(&self, index: usize) -> f64 {
        let stated = one(&self.stated, index).unwrap_or(0.0);
        one(&self.k, index).map_or(stated, |k| stated / k)
    }

    pub(super) fn stated_of(&self, index: usize) -> f64 {
        one(&self.stated, index).unwrap_or(0.0)
    }

    /// The largest coverage factor with its probability and the degrees of freedom of the Student's t that has it, where these are few.
    pub(crate) fn of_few_degrees(&self) -> Option<(f64, f64, f64)> {
        let all = 0..self.k.len().max(self.probability.len());
        let pairs = all.filter_map(|i| Some((one(&self.k, i)?, one(&self.probability, i)?)));
        let (k, p) = pairs.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let few = student_quantile(0.5 + 0.5 * p, FEW_DEGREES);
        let degrees = || dof_of_coverage_factor(k, p).max(1.0);
        (k > few * (1.0 + ROUNDED)).then(|| (k, p, degrees()))
    }

    /// Coverage factor of a value, where its uncertainty is an expanded one.
    pub fn coverage_factor(&self, index: usize) -> Option<f64> {
        one(&self.k, index)
    }
}

pub(super) fn one(list: &[f64], index: usize) -> Option<f64> {
    match list {
        [all] => Some(*all),
        list => list.get(index).copied(),
    }
}

/// The form of a statement: its element, those of uncertainty, k, probability, distribution.
type Form = (&'static str, [&'static str; 4]);

/// Every form, of lists and of single values, with the deprecated ones. Of an interval the standard uncertainty is read.
const FORMS: &[Form] = &[
    (
        "expandedMUXMLList",
        [
            "valueExpandedMUXMLList",
            "coverageFactorXMLList",
            "coverageProbabilityXMLList",
            "distributionXMLList",
        ],
    ),
    (
        "expandedUncXMLList",
        [
            "uncertaintyXMLList",
            "coverageFactorXMLList",
            "coverageProbabilityXMLList",
            "distributionXMLList",
        ],
    ),
    (
        "expandedMU",
        [
            "valueExpandedMU",
            "coverageFactor",
            "coverageProbability",
            "distribution",
        ],
    ),
    (
        "expandedUnc",
        [
            "uncertainty",
            "coverageFactor",
            "coverageProbability",
            "distribution",
        ],
    ),
    (
        "standardMUXMLList",
        ["valueStandardMUXMLList", "", "", "distributionXMLList"],
    ),
    ("standardMU", ["valueStandardMU", "", "", "distribution"]),
    (
        "coverageIntervalMUXMLList",
        ["valueStandardMUXMLList", "", "", "distributionXMLList"],
    ),
    (
        "coverageIntervalXMLList",
        ["standardUncXMLList", "", "", "distributionXMLList"],
    ),
    (
        "coverageIntervalMU",
        ["valueStandardMU", "", "", "distribution"],
    ),
    ("coverageInterval", ["standardUnc", "", "", "distribution"]),
];

/// Elements around a statement; one is misspelt in the schema itself.
const AROUND: &[&str] = &[
    "measurementUncertaintyUnivariateXMLList",
    "measurementUncertaintyUnivariate",
    "measurementUncertaintyUnivaraite",
    "listMeasurementUncertaintyUnivariate",
    "listUnivariateUnc",
];

/// The uncertainty stated of the values of an element; of a list of elements that have their own values, of none.
pub(super) fn of(quantity: Element, values: &[f64]) -> Result<Option<DccUncertainty>> {
    let si = |e: &Element| e.namespace() == Namespace::Si;
    let direct = quantity.children().filter(si);
    let around = quantity
        .children()
        .filter(|e| si(e) && AROUND.contains(&e.name()))
        .flat_map(Element::children);
    let mut found = None;
    for element in direct.chain(around).filter(si) {
        let Some((_, names)) = FORMS.iter().find(|f| f.0 == element.name()) else {
            continue;
        };
        if found.is_some() {
            return Err(element.refuse("the uncertainty of these values stands twice"));
        }
        once(element, STATEMENT)?;
        let stated = statement(element, names, values.len().max(1))?;
        let limits = limits(element, values.len().max(1))?;
        if let Some(limits) = &limits {
            wide(element, limits, &stated)?;
        }
        found = Some(DccUncertainty {
            outside: limits.and_then(|limits| outside(&limits, values)),
            ..stated
        });
    }
    Ok(found)
}

/// What the name of an element of a statement begins with.
const STATEMENT: &[&str] = &[
    "value",
    "uncertainty",
    "standardUnc",
    "coverageFactor",
    "coverageProbability",
    "distribution",
    "interval",
];

/// Refuses an element that stands twice among its like, or that D-SI does not know there.
pub(super) fn once(element: Element, known: &[&str]) -> Result<()> {
    let own = || {
        element
            .children()
            .filter(|c| c.namespace() == Namespace::Si)
    };
    for (i, child) in own().enumerate() {
        if own().take(i).any(|before| before.name() == child.name()) {
            return Err(child
                .refuse(format!("stands twice in {}", element.name()))
                .with_hint("ask the laboratory which of the two holds"));
        }
        if !known.iter().any(|word| child.name().starts_with(word)) {
            return Err(child
                .refuse(format!("is no part of {}", element.name()))
                .with_hint("what it changes is not known: ask the laboratory for a certificate by the schema of D-SI"));
        }
    }
    Ok(())
}

/// The ends of the intervals, where both are stated.
fn limits(element: Element, values: usize) -> Result<Option<[Numbers; 2]>> {
    let ends = |word: &str| {
        let mut children = element.children();
        let end = children.find(|c| c.namespace() == Namespace::Si && c.name().starts_with(word));
        end.map(|end| quantity::numbers(end, values)).transpose()
    };
    Ok(match (ends("intervalMin")?, ends("intervalMax")?) {
        (Some(low), Some(high)) => Some([low, high]),
        _ => None,
    })
}

/// Refuses a standard uncertainty that no distribution has whose interval is this wide: half of it over u is a coverage factor of its
/// probability.
fn wide(element: Element, [low, high]: &[Numbers; 2], stated: &DccUncertainty) -> Result<()> {
    let probability = ["coverageProbabilityXMLList", "coverageProbability"];
    let mut probability = probability
        .iter()
        .filter_map(|p| element.child(Namespace::Si, p));
    let Some(p) = probability.next() else {
        return Ok(());
    };
    let p = quantity::numbers(p, low.values.len().max(stated.stated.len()))?;
    for i in 0..low
        .values
        .len()
        .max(high.values.len())
        .max(stated.stated.len())
    {
        let (Some(a), Some(b), Some(u), Some(p)) = (
            one(&low.values, i),
            one(&high.values, i),
            one(&stated.stated, i),
            one(&p.values, i),
        ) else {
            continue;
        };
        // An interval of no width says nothing of u.
        if b > a && u > 0.0 && p > 0.0 && p < 1.0 {
            let k = 0.5 * (b - a) / u;
            // Up to Student's t with one degree of freedom; of one that ends at a bound an interval may be short.
            let most = student_quantile(0.5 + 0.5 * p, 1.0) * (1.0 + ROUNDED);
            if !(SHORT..=most).contains(&k) {
                return Err(low
                    .refuse(format!("u = {u} contradicts the interval from {a} to {b}: half of it is {k:.3} u at {p}"))
                    .with_hint("ask the laboratory which of them holds; neither is changed"));
            }
        }
    }
    Ok(())
}

/// The first value that does not lie in its interval.
fn outside([low, high]: &[Numbers; 2], values: &[f64]) -> Option<Outside> {
    let mut all = values.iter().enumerate().filter_map(|(i, &value)| {
        let interval = [one(&low.values, i)?, one(&high.values, i)?];
        let holds = (interval[0]..=interval[1]).contains(&value);
        (!holds).then_some(Outside { value, interval })
    });
    all.next()
}

fn statement(element: Element, names: &[&str; 4], values: usize) -> Result<DccUncertainty> {
    let list = |name: &str| -> Result<Numbers> {
        if name.is_empty() {
            return Ok(Numbers::default());
        }
        let child = element
            .child(Namespace::Si, name)
            .ok_or_else(|| element.refuse(format!("has no {name}")))?;
        quantity::numbers(child, values)
    };
    let [stated, k, probability] = [list(names[0])?, list(names[1])?, list(names[2])?];
    for (numbers, what, sound) in [
        (
            &stated,
            "an uncertainty must not be negative",
            (|v| v >= 0.0) as fn(f64) -> bool,
        ),
        (&k, "a coverage factor lies from 1 to 20", |v| {
            (1.0..=20.0).contains(&v)
        }),
        (&probability, "a probability lies between 0 and 1", |v| {
            v > 0.0 && v < 1.0
        }),
    ] {
        if let Some(v) = numbers.values.iter().find(|v| !sound(**v)) {
            return Err(numbers.refuse(format!("{v} is out of range: {what}")));
        }
    }
    let distribution = element
        .child(Namespace::Si, names[3])
        .map(|e| e.text().to_owned());
    // A list of words of which all are the same is one word.
    let distribution = distribution.and_then(|words| {
        let mut words = words.split_whitespace();
        let first = words.next()?;
        words.all(|w| w == first).then(|| first.to_owned())
    });
    for i in 0..k.values.len().max(probability.values.len()) {
        if let (Some(factor), Some(p)) = (one(&k.values, i), one(&probability.values, i)) {
            agree(factor, p, distribution.as_deref(), &k)?;
        }
    }
    Ok(DccUncertainty {
        stated: stated.values,
        k: k.values,
        probability: probability.values,
        distribution,
        outside: None,
    })
}

/// Whether a coverage factor can belong to a probability: of a normal distribution it is one number, of any other a range.
fn agree(k: f64, p: f64, distribution: Option<&str>, place: &Numbers) -> Result<()> {
    let normal = normal_quantile(0.5 + 0.5 * p);
    let is_normal = distribution.is_some_and(|d| {
        let d = d.to_ascii_lowercase();
        d == "normal" || d == "gaussian" || d == "gauss"
    });
    let (least, most) = match is_normal {
        true => (normal, normal),
        // From a rectangle to Student's t with one degree of freedom.
        false => (
            normal.min(p * 3f64.sqrt()),
            student_quantile(0.5 + 0.5 * p, 1.0),
        ),
    };
    if k >= least * (1.0 - ROUNDED) && k <= most * (1.0 + ROUNDED) {
        return Ok(());
    }
    let due = match is_normal {
        true => format!("a normal distribution has k = {normal:.2} there"),
        false => format!("k lies between {least:.2} and {most:.2} there"),
    };
    Err(place
        .refuse(format!("k = {k} contradicts a probability of {p}: {due}"))
        .with_hint("ask the laboratory which of the two holds; neither is changed"))
}
