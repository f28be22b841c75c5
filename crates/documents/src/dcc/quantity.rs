//! The quantities of a certificate: single values, lists, lists as one text, complex ones and hybrids.

use super::head::{content, short};
use super::uncertainty::{self, DccUncertainty};
use super::unit::DsiUnit;
use crate::xml::{Element, Namespace};
use num_complex::Complex64;
use proofmass_io::field::{is_reading, parse_number, shown};
use proofmass_io::{Error, Result};
use proofmass_signal::transfer::polar;
use proofmass_uncertainty::DecimalMark;

/// What the name of a part of a quantity begins with.
const PARTS: &[&str] = &[
    "label",
    "quantityType",
    "value",
    "unit",
    "significantDigit",
    "dateTime",
    "expanded",
    "coverageInterval",
    "standardMU",
    "measurementUncertainty",
];

/// Values of one list at most.
const MOST_VALUES: usize = 1_000_000;

/// One quantity: its values in one unit.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DccQuantity {
    /// What the certificate calls it.
    pub name: String,
    /// Label of the quantity within D-SI, such as `sensitivity magnitude`.
    pub label: Option<String>,
    /// Words of `refType`.
    pub ref_types: Vec<String>,
    /// Name of the result that it belongs to.
    pub result: String,
    /// Whether it states a condition or a property and no result.
    pub is_beside: bool,
    /// Line of the certificate.
    pub line: u64,
    /// Unit.
    pub unit: DsiUnit,
    /// Values.
    pub values: Vec<f64>,
    /// Uncertainty, where it is stated.
    pub uncertainty: Option<DccUncertainty>,
    /// Which list it stands in: quantities of one list belong together.
    pub(super) group: usize,
    /// Lines of single values that were put together.
    pub(super) lines: Vec<u64>,
    /// One half of a complex quantity.
    pub(super) is_of_complex: bool,
}

/// Whether a result is of the item as it was before an adjustment.
fn is_no_result(result: Element) -> bool {
    let types = result.attribute("refType").unwrap_or_default();
    types
        .split_whitespace()
        .any(|t| t == "basic_beforeAdjustment")
}

/// Numbers with the place they came from.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    pub(super) values: Vec<f64>,
    line: u64,
    name: String,
}

impl Numbers {
    pub(super) fn refuse(&self, what: impl Into<String>) -> Error {
        Error::new(proofmass_io::ErrorKind::Element, what)
            .line(self.line)
            .column(&self.name)
    }
}

/// The numbers of an element, one or as many as there are values.
pub(super) fn numbers(element: Element, values: usize) -> Result<Numbers> {
    let list = all_numbers(element)?;
    if list.values.len() != 1 && list.values.len() != values {
        return Err(element
            .refuse(format!(
                "holds {} numbers for {values} values",
                list.values.len()
            ))
            .with_hint("one number holds for all values, else every value has its own"));
    }
    Ok(list)
}

fn all_numbers(element: Element) -> Result<Numbers> {
    if let Some(child) = element.children().next() {
        return Err(child.refuse("stands among numbers"));
    }
    let mut values = Vec::new();
    for word in element.text().split_whitespace() {
        let value = parse_number(word.as_bytes(), DecimalMark::Point).filter(|v| is_reading(*v));
        values.push(value.ok_or_else(|| {
            element
                .refuse(format!(
                    "\"{}\" is not a finite number",
                    shown(word.as_bytes())
                ))
                .with_hint(match word.contains(',') {
                    true => "a certificate has the decimal point and no separators, in every language: ask the laboratory for one that is right",
                    false => "a certificate with such a number states no result there; nothing is filled in",
                })
        })?);
        if values.len() > MOST_VALUES {
            return Err(element.refuse(format!("holds more than {MOST_VALUES} numbers")));
        }
    }
    if values.is_empty() {
        return Err(element.refuse("holds no number"));
    }
    Ok(Numbers {
        values,
        line: element.line(),
        name: element.name().to_owned(),
    })
}

/// Every quantity of a document.
pub(super) fn of(root: Element) -> Result<Vec<DccQuantity>> {
    let mut found: Vec<DccQuantity> = Vec::new();
    for element in root
        .descendants()
        .filter(|e| e.namespace() == Namespace::Si)
    {
        // What stands within another quantity is read with that.
        let parent = element.parent().filter(|p| p.namespace() == Namespace::Si);
        let within = parent.is_some_and(|p| !matches!(p.name(), "list"));
        if !within {
            Reading::new(element).read(element, &mut found)?;
        }
    }
    Ok(found)
}

/// What the elements around a quantity say of it.
#[derive(Clone)]
struct Reading {
    name: String,
    ref_types: Vec<String>,
    result: String,
    is_beside: bool,
    group: usize,
}

impl Reading {
    fn new(element: Element) -> Self {
        let mut reading = Self {
            name: String::new(),
            ref_types: Vec::new(),
            result: String::new(),
            is_beside: false,
            group: usize::MAX,
        };
        let around = std::iter::successors(element.parent(), |e| e.parent());
        for parent in around.filter(|e| e.namespace() == Namespace::Dcc) {
            let name = || parent.child(Namespace::Dcc, "name").and_then(content);
            let line = usize::try_from(parent.line()).unwrap_or(usize::MAX);
            match parent.name() {
                "quantity"
                | "itemQuantity"
                | "usedMethodQuantity"
                | "measuringEquipmentQuantity"
                    if reading.name.is_empty() =>
                {
                    reading.name = name().unwrap_or_default();
                    let types = parent.attribute("refType").unwrap_or_default();
                    // What it should be, or what the item is for, is not what it was found to be.
                    let nominal = ["basic_nominalValue", "basic_targetValue"];
                    reading.is_beside |= types.split_whitespace().any(|t| nominal.contains(&t));
                    reading.ref_types = types.split_whitespace().map(short).collect();
                }
                "list" | "data" if reading.group == usize::MAX => reading.group = line,
                "result" if is_no_result(parent) => reading.is_beside = true,
                "result" if reading.result.is_empty() => {
                    reading.result = name().unwrap_or_default()
                }
                "influenceCondition"
                | "comment"
                | "itemQuantities"
                | "measuringEquipment"
                | "usedMethod"
                | "metaData"
                | "statement"
                | "relativeUncertainty"
                | "positionCoordinates" => {
                    reading.is_beside = true;
                }
                _ => {}
            }
        }
        reading
    }

    fn read(&self, element: Element, found: &mut Vec<DccQuantity>) -> Result<()> {
        match element.name() {
            "real" | "constant" => {
                let unit = element.child(Namespace::Si, "unit");
                let read = self.real(element, unit)?;
                found.push(read);
            }
            "realListXMLList" => found.extend(self.real_list(element)?),
            "realList" => self.rows(element, found)?,
            "complex" => found.extend(self.complex(
                element,
                ["valueMagnitude", "valuePhase"],
                ["valueReal", "valueImag"],
                ["unit", "unitPhase"],
            )?),
            "complexListXMLList" => found.extend(self.complex(
                element,
                ["valueMagnitudeXMLList", "valuePhaseXMLList"],
                ["valueRealXMLList", "valueImagXMLList"],
                ["unitXMLList", "unitPhaseXMLList"],
            )?),
            "complexList" => {
                for one in element
                    .children()
                    .filter(|e| e.is(Namespace::Si, "complex"))
                {
                    self.read(one, found)?;
                }
            }
            "hybrid" => self.hybrid(element, found)?,
            "list" => {}
            _ => {}
        }
        Ok(())
    }

    fn quantity(
        &self,
        element: Element,
        label: Option<String>,
        unit: DsiUnit,
        values: Vec<f64>,
    ) -> DccQuantity {
        DccQuantity {
            name: self.name.clone(),
            label,
            ref_types: self.ref_types.clone(),
            result: self.result.clone(),
            is_beside: self.is_beside,
            line: element.line(),
            unit,
            lines: vec![element.line(); values.len()],
            values,
            uncertainty: None,
            group: self.group,
            is_of_complex: false,
        }
    }

    /// A single value.
    fn real(&self, element: Element, unit: Option<Element>) -> Result<DccQuantity> {
        uncertainty::once(element, PARTS)?;
        let value = element
            .child(Namespace::Si, "value")
            .ok_or_else(|| element.refuse("has no value"))?;
        let value = numbers(value, 1)?;
        let unit = unit.ok_or_else(|| element.refuse("has no unit"))?;
        let label = element
            .child(Namespace::Si, "label")
            .map(|l| short(l.text()));
        let mut read = self.quantity(element, label, DsiUnit::new(unit.text()), value.values);
        read.uncertainty = uncertainty::of(element, &read.values)?;
        if let (None, Some(u)) = (
            &read.uncertainty,
            element.child(Namespace::Si, "valueStandardMU"),
        ) {
            read.uncertainty = Some(DccUncertainty {
                stated: numbers(u, 1)?.values,
                ..DccUncertainty::default()
            });
        }
        Ok(read)
    }

    /// Values in one text; where each has its own unit, those of a unit are put together.
    fn real_list(&self, element: Element) -> Result<Vec<DccQuantity>> {
        uncertainty::once(element, PARTS)?;
        let child = |name: &str| {
            element
                .child(Namespace::Si, name)
                .ok_or_else(|| element.refuse(format!("has no {name}")))
        };
        let values = all_numbers(child("valueXMLList")?)?.values;
        let units = child("unitXMLList")?;
        let words: Vec<&str> = units.text().split_whitespace().collect();
        if words.len() != 1 && words.len() != values.len() {
            return Err(units
                .refuse(format!(
                    "holds {} units for {} values",
                    words.len(),
                    values.len()
                ))
                .with_hint("one unit holds for all values, else every value has its own"));
        }
        let stated = uncertainty::of(element, &values)?;
        let label = label(element);
        if words.iter().all(|w| *w == words[0]) {
            let mut read = self.quantity(element, label, DsiUnit::new(words[0]), values);
            read.uncertainty = stated;
            return Ok(vec![read]);
        }
        let each = values.iter().zip(&words).enumerate();
        Ok(each
            .map(|(i, (value, unit))| {
                let mut read =
                    self.quantity(element, label.clone(), DsiUnit::new(unit), vec![*value]);
                read.uncertainty = stated.as_ref().map(|u| DccUncertainty {
                    stated: vec![u.stated_of(i)],
                    k: uncertainty::one(&u.k, i).into_iter().collect(),
                    probability: uncertainty::one(&u.probability, i).into_iter().collect(),
                    distribution: u.distribution.clone(),
                    outside: u.outside.filter(|o| o.value == *value),
                });
                read
            })
            .collect())
    }

    /// A list of single values: those with one label, the rows of one quantity or a row of several.
    fn rows(&self, element: Element, found: &mut Vec<DccQuantity>) -> Result<()> {
        let common = element.child(Namespace::Si, "listUnit");
        let common_u = uncertainty::of(element, &[])?;
        for one in element.children().filter(|e| e.is(Namespace::Si, "real")) {
            let unit = one.child(Namespace::Si, "unit").or(common);
            let mut read = self.real(one, unit)?;
            if read.uncertainty.is_none() {
                read.uncertainty.clone_from(&common_u);
            }
            found.push(read);
        }
        Ok(())
    }

    /// The same values in several units: the first one in a notation that is known.
    fn hybrid(&self, element: Element, found: &mut Vec<DccQuantity>) -> Result<()> {
        let mut parts = Vec::new();
        for part in element
            .children()
            .filter(|e| e.namespace() == Namespace::Si)
        {
            let mut read = Vec::new();
            self.read(part, &mut read)?;
            parts.push(read);
        }
        let of = |part: &Vec<DccQuantity>| part.first().map_or(0, |q| q.values.len());
        if let Some(part) = parts.iter().find(|p| of(p) != of(&parts[0])) {
            let line = part.first().map_or(element.line(), |q| q.line);
            return Err(element
                .refuse(format!(
                    "its parts have {} and {} values",
                    of(&parts[0]),
                    of(part)
                ))
                .line(line));
        }
        let known = |part: &&Vec<DccQuantity>| {
            part.iter().all(|q| {
                q.unit.sensitivity().is_some()
                    || q.unit.angle().is_some()
                    || q.unit.frequency().is_some()
            })
        };
        // Of units that are known the numbers are the same.
        let in_si = |q: &DccQuantity| -> Option<Vec<f64>> {
            let sensitivity = q.unit.sensitivity().map(|s| s.1);
            let factor = sensitivity.or(q.unit.angle()).or(q.unit.frequency())?;
            Some(q.values.iter().map(|v| factor * v).collect())
        };
        let mut firsts = parts
            .iter()
            .filter_map(|p| Some((p.first()?, in_si(p.first()?)?)));
        if let Some((_, first)) = firsts.next() {
            for (q, other) in firsts {
                let off = |(a, b): (&f64, &f64)| (a - b).abs() > 0.005 * a.abs().max(b.abs());
                if let Some(i) = first.iter().zip(&other).position(off) {
                    return Err(element
                        .refuse(format!("{} {} is another value than that in the unit before", q.values[i], q.unit.symbol()))
                        .line(q.line)
                        .with_hint("a hybrid states one value in several units: ask the laboratory which of them holds"));
                }
            }
        }
        let best = parts.iter().find(known).or_else(|| parts.first());
        found.extend(best.into_iter().flatten().cloned());
        Ok(())
    }

    /// Modulus and phase of a complex quantity, or its real and imaginary part.
    fn complex(
        &self,
        element: Element,
        polar: [&str; 2],
        cartesian: [&str; 2],
        units: [&str; 2],
    ) -> Result<Vec<DccQuantity>> {
        let is_polar = element.child(Namespace::Si, polar[0]).is_some();
        let names = if is_polar { polar } else { cartesian };
        let need = |name: &str| {
            element
                .child(Namespace::Si, name)
                .ok_or_else(|| element.refuse(format!("has no {name}")))
        };
        let first = all_numbers(need(names[0])?)?;
        let second = need(names[1])?;
        let n = first.values.len();
        let values = [first.values, all_numbers(second)?.values];
        if values[1].len() != n {
            return Err(second.refuse(format!("holds {} numbers for {n} values", values[1].len())));
        }
        let unit = |name: &str| -> Result<DsiUnit> {
            let unit = need(name)?;
            let mut words = unit.text().split_whitespace();
            match (words.next(), words.next()) {
                (Some(word), None) => Ok(DsiUnit::new(word)),
                _ => Err(unit.refuse("one unit is read for all values of a complex quantity")),
            }
        };
        let value_unit = unit(units[0])?;
        let part_unit = match is_polar {
            true => unit(units[1])?,
            false => value_unit.clone(),
        };
        let covariance = covariance(element, n, [&value_unit, &part_unit])?;
        let (values, second_unit, u) = if is_polar {
            let u =
                covariance.map(|[a, _, c]| [a, c].map(|v| v.into_iter().map(f64::sqrt).collect()));
            (values, part_unit, u)
        } else {
            let (values, u) = polar_form(&values, covariance.as_ref());
            (values, DsiUnit::new("\\radian"), u)
        };
        let whole = label(element).unwrap_or_default();
        let mut read = Vec::new();
        let ends = ["magnitude", "phase"];
        for (i, (values, unit)) in values
            .into_iter()
            .zip([value_unit, second_unit])
            .enumerate()
        {
            let label = format!("{whole} {}", ends[i]).trim().to_owned();
            let mut part = self.quantity(element, Some(label), unit, values);
            part.is_of_complex = true;
            part.uncertainty = u.as_ref().map(|u: &[Vec<f64>; 2]| DccUncertainty {
                stated: u[i].clone(),
                ..DccUncertainty::default()
            });
            read.push(part);
        }
        Ok(read)
    }
}

/// Modulus and phase of real and imaginary parts, with the standard uncertainties of both.
fn polar_form(
    [re, im]: &[Vec<f64>; 2],
    covariance: Option<&[Vec<f64>; 3]>,
) -> ([Vec<f64>; 2], Option<[Vec<f64>; 2]>) {
    let all: Vec<Complex64> = re
        .iter()
        .zip(im)
        .map(|(re, im)| Complex64::new(*re, *im))
        .collect();
    let u = covariance.map(|c| {
        let each = all.iter().enumerate();
        let (modulus, phase) = each
            .map(|(i, z)| polar(*z, [c[0][i], c[1][i], c[2][i]]))
            .unzip();
        [modulus, phase]
    });
    let values = [
        all.iter().map(|z| z.norm()).collect(),
        all.iter().map(|z| z.arg()).collect(),
    ];
    (values, u)
}

fn label(element: Element) -> Option<String> {
    let labels = ["labelXMLList", "label"];
    let label = labels
        .iter()
        .find_map(|l| element.child(Namespace::Si, l))?;
    Some(short(label.text())).filter(|l| !l.is_empty())
}

/// Variance, covariance and variance of the two parts of each value, from the covariance matrices of a bivariate statement, in the products
/// of the units of the parts.
fn covariance(
    element: Element,
    values: usize,
    units: [&DsiUnit; 2],
) -> Result<Option<[Vec<f64>; 3]>> {
    let matrix = |e: &Element| matches!(e.name(), "covarianceMatrix" | "covarianceMatrixXMLList");
    let bivariate = |e: &Element| {
        let regions = [
            "ellipsoidalRegion",
            "rectangularRegion",
            "ellipsoidalRegionMUXMLList",
            "rectangularRegionMUXMLList",
        ];
        regions.contains(&e.name())
            && e.parent()
                .is_none_or(|p| p.name() != "measurementUncertaintyMultivariateXMLList")
    };
    let mut regions = element.descendants().filter(bivariate);
    let Some(region) = regions.next() else {
        return Ok(None);
    };
    let Some(matrix) = region.children().find(matrix) else {
        return Err(region.refuse("has no covariance matrix"));
    };
    let columns: Vec<Element> = matrix
        .children()
        .filter(|e| e.namespace() == Namespace::Si)
        .collect();
    let mut cells = Vec::new();
    for column in &columns {
        let elements = column.children().filter(|e| e.namespace() == Namespace::Si);
        for cell in elements {
            let value = ["value", "valueXMLList"]
                .iter()
                .find_map(|v| cell.child(Namespace::Si, v));
            let value = value.ok_or_else(|| cell.refuse("has no value"))?;
            let mut read = numbers(value, values)?;
            let unit = ["unit", "unitXMLList"];
            let unit = unit.iter().find_map(|u| cell.child(Namespace::Si, u));
            let unit = unit.ok_or_else(|| cell.refuse("has no unit"))?;
            let mut words = unit.text().split_whitespace();
            let stated = DsiUnit::new(words.next().unwrap_or_default());
            let (row, column) = (cells.len() % 2, (cells.len() / 2).min(1));
            let factor = stated.factor_to_product(units[column], units[row]);
            let factor = factor.filter(|_| words.all(|w| w == stated.text()));
            let factor = factor.ok_or_else(|| {
                unit.refuse(format!(
                    "a covariance in {} does not belong to values in {} and {}",
                    unit.text(),
                    units[column].text(),
                    units[row].text()
                ))
                .with_hint("it is in the product of the units of the two parts: ask the laboratory which unit holds")
            })?;
            read.values.iter_mut().for_each(|v| *v *= factor);
            cells.push(read);
        }
    }
    if columns.len() != 2 || cells.len() != 4 {
        return Err(matrix
            .refuse("the covariance matrix of a complex value has two columns of two elements"));
    }
    for i in 0..values {
        let [a, b, c, d] =
            [0, 1, 2, 3].map(|k| uncertainty::one(&cells[k].values, i).unwrap_or(0.0));
        let near = (b - c).abs() <= 1e-6 * (b.abs() + c.abs());
        if !(a >= 0.0 && d >= 0.0 && near && b * c <= a * d * (1.0 + 1e-6)) {
            return Err(cells[0].refuse(format!(
                "the covariance matrix of value {} is not valid: {a}, {b}; {c}, {d}",
                i + 1
            )));
        }
    }
    let of = |k: usize| -> Vec<f64> {
        (0..values)
            .filter_map(|i| uncertainty::one(&cells[k].values, i))
            .collect()
    };
    Ok(Some([of(0), of(1), of(3)]))
}
