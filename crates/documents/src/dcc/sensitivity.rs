//! The sensitivity of an accelerometer over frequency that a certificate states.

use super::head::DigitalCertificate;
use super::quantity::DccQuantity;
use crate::findings;
use proofmass_io::{Error, ErrorKind, Result, Unit};
use proofmass_uncertainty::Finding;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Labels, as in the examples of the PTB for accelerometers.
const FREQUENCY: &str = "frequency";
const MAGNITUDE: &str = "sensitivity magnitude";
const PHASE: &str = "sensitivity phase";
/// Relative difference of two frequencies that are one: no bench sets them apart, and no number of nine digits shows it.
const ONE_FREQUENCY: f64 = 1e-9;
/// What two statements of one value may differ by, in standard uncertainties: U rounded to two digits moves a value by a tenth of u with
/// k = 2, and real and imaginary parts may be rounded as well.
const ONE_VALUE: f64 = 0.5;
/// The same of values that state no uncertainty, relative.
const ONE_EXACT_VALUE: f64 = 1e-6;
/// Ratio of two statements of one uncertainty: rounding up to two digits makes a tenth, k beside Student's t as much again.
const ONE_UNCERTAINTY: f64 = 1.25;

/// One frequency, in SI.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SensitivityRow {
    /// Line of the certificate.
    pub line: u64,
    /// Frequency, Hz.
    pub frequency: f64,
    /// Modulus, in the unit of the output per m/s².
    pub sensitivity: f64,
    /// Its standard uncertainty.
    pub sensitivity_uncertainty: f64,
    /// Phase and its standard uncertainty, rad.
    pub phase: Option<[f64; 2]>,
}

/// A sensitivity over frequency.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DccSensitivity {
    /// What the device gives: volts, an acceleration, counts.
    pub output: Unit,
    /// Rows in the order of the certificate.
    pub rows: Vec<SensitivityRow>,
    /// What to doubt.
    pub findings: Vec<Finding>,
}

impl DigitalCertificate {
    /// The sensitivity over frequency that the certificate states, of the result named `result` where there are several.
    ///
    /// Frequency, magnitude and phase are known by their labels, by the words of `refType`, or by their unit.
    ///
    /// # Errors
    /// None or several; a unit that is none of a sensitivity to acceleration, a frequency or an angle; lists of unequal length; a frequency
    /// that stands twice or is not above zero; no uncertainty: with element and line.
    pub fn sensitivity(&self, result: Option<&str>) -> Result<DccSensitivity> {
        self.table(result).map_err(|e| e.at(&self.path))
    }

    fn table(&self, result: Option<&str>) -> Result<DccSensitivity> {
        let mut groups: Vec<Vec<&DccQuantity>> = Vec::new();
        for quantity in self.quantities.iter().filter(|q| !q.is_beside) {
            match groups.iter_mut().find(|g| g[0].group == quantity.group) {
                Some(group) => group.push(quantity),
                None => groups.push(vec![quantity]),
            }
        }
        let mut tables = Vec::new();
        for group in groups {
            tables.extend(Parts::of(&group)?);
        }
        let names = || {
            let mut names: Vec<&str> = tables
                .iter()
                .map(|t| t.magnitude[0].result.as_str())
                .collect();
            names.dedup();
            names.join(", ")
        };
        let chosen: Vec<&Parts> = match result {
            Some(name) => tables
                .iter()
                .filter(|t| t.magnitude[0].result == name)
                .collect(),
            None => tables.iter().collect(),
        };
        match (&chosen[..], result) {
            ([one], _) => one.rows(),
            ([], Some(name)) if !tables.is_empty() => Err(Error::new(
                ErrorKind::Format,
                format!("the certificate has no sensitivity in a result named {name:?}"),
            )
            .with_hint(format!("there are: {}", names()))),
            ([], _) => Err(Error::new(
                ErrorKind::Format,
                "the certificate states no sensitivity over frequency",
            )
            .with_hint(format!(
                "it needs, in one list, quantities with the labels \"{FREQUENCY}\" and \"{MAGNITUDE}\", and \"{PHASE}\" where it is known"
            ))),
            (several, _) => Err(Error::new(
                ErrorKind::Format,
                format!("the certificate states {} sensitivities over frequency", several.len()),
            )
            .with_hint(format!("name the result with `axis`: {}", names()))),
        }
    }
}

/// What belongs together to a table; of single values one quantity each.
struct Parts<'a> {
    frequency: Vec<&'a DccQuantity>,
    magnitude: Vec<&'a DccQuantity>,
    phase: Vec<&'a DccQuantity>,
    /// Modulus and phase of a complex quantity that states the same again.
    again: [Vec<&'a DccQuantity>; 2],
}

/// Whether a quantity says that it is this one: by its label, else by refType, else by its name.
fn says(quantity: &DccQuantity, label: &str, types: &[&str]) -> bool {
    match &quantity.label {
        Some(own) => own.eq_ignore_ascii_case(label),
        None => {
            quantity
                .ref_types
                .iter()
                .any(|t| types.contains(&t.as_str()))
                || quantity.name.eq_ignore_ascii_case(label)
        }
    }
}

impl<'a> Parts<'a> {
    fn of(group: &[&'a DccQuantity]) -> Result<Option<Self>> {
        // Where a complex quantity states the same again, it is held against the other.
        let labelled = |label: &str, types: &[&str]| -> [Vec<&'a DccQuantity>; 2] {
            let said = group.iter().copied().filter(|q| says(q, label, types));
            let (complex, alone): (Vec<_>, Vec<_>) = said.partition(|q| q.is_of_complex);
            match alone.is_empty() {
                true => [complex, alone],
                false => [alone, complex],
            }
        };
        let [mut magnitude, again] = labelled(MAGNITUDE, &["vib_sensitivity", "vib_magnitude"]);
        if magnitude.is_empty() {
            // A certificate without labels: what has the unit of a voltage per acceleration.
            let unit = |q: &&DccQuantity| {
                q.label.is_none() && matches!(q.unit.sensitivity(), Some((Unit::Volt, _)))
            };
            magnitude = group.iter().copied().filter(unit).collect();
        }
        if magnitude.is_empty() {
            return Ok(None);
        }
        let [mut frequency, _] = labelled(FREQUENCY, &["vib_frequency", "basic_frequency"]);
        if frequency.is_empty() {
            let unit = |q: &&DccQuantity| q.label.is_none() && q.unit.frequency().is_some();
            frequency = group.iter().copied().filter(unit).collect();
        }
        if frequency.is_empty() {
            return Err(
                refuse(magnitude[0], "a sensitivity without its frequencies").with_hint(format!(
                    "a quantity with the label \"{FREQUENCY}\" belongs into the same list"
                )),
            );
        }
        let [mut phase, phase_again] = labelled(PHASE, &["vib_phase"]);
        if phase.is_empty() {
            let unit = |q: &&DccQuantity| q.label.is_none() && q.unit.angle().is_some();
            phase = group.iter().copied().filter(unit).collect();
        }
        Ok(Some(Self {
            frequency,
            magnitude,
            phase,
            again: [again, phase_again],
        }))
    }

    fn rows(&self) -> Result<DccSensitivity> {
        let frequency = Column::of(&self.frequency, |q| {
            let factor = q.unit.frequency();
            factor.ok_or_else(|| wrong_unit(q, "frequency", "\\hertz"))
        })?;
        let mut output = None;
        let mut sensitivity = |q: &DccQuantity| {
            let (unit, factor) = q.unit.sensitivity().ok_or_else(|| {
                wrong_unit(
                    q,
                    "sensitivity to acceleration",
                    "\\milli\\volt\\second\\tothe{2}\\metre\\tothe{-1}",
                )
            })?;
            match output.replace(unit) {
                Some(other) if other != unit => Err(refuse(
                    q,
                    format!("a sensitivity of an output in {unit} beside one in {other}"),
                )),
                _ => Ok(factor),
            }
        };
        let angle = |q: &DccQuantity| {
            let factor = q.unit.angle();
            factor.ok_or_else(|| wrong_unit(q, "phase", "\\degree"))
        };
        let magnitude = Column::of(&self.magnitude, &mut sensitivity)?;
        let magnitude_again = Column::of(&self.again[0], &mut sensitivity)?;
        for quantity in &self.magnitude {
            let foreign = |text: &&String| {
                let text = text.to_lowercase();
                let others = ["phase", "frequency", "displacement", "transverse"];
                others.iter().any(|word| text.contains(word))
            };
            let mut said = quantity.ref_types.iter().chain([&quantity.name]);
            if let Some(other) = said.find(foreign) {
                return Err(refuse(
                    quantity,
                    format!("is called {other:?}, and a sensitivity by its label"),
                )
                .with_hint("ask the laboratory which of the two it is"));
            }
        }
        let phase = Column::of(&self.phase, angle)?;
        let phase_again = Column::of(&self.again[1], angle)?;
        let n = frequency.cells.len();
        for (column, what, may_lack) in [
            (&magnitude, "sensitivities", false),
            (&phase, "phases", true),
            (&magnitude_again, "complex sensitivities", true),
            (&phase_again, "complex sensitivities", true),
        ] {
            let m = column.cells.len();
            if m != n && !(m == 0 && may_lack) {
                let at = column.first;
                return Err(at
                    .map_or_else(|| Error::new(ErrorKind::Element, ""), |q| refuse(q, format!("{m} {what} for {n} frequencies")))
                    .with_hint("lists of one result have the same length: ask the laboratory which of the values are missing"));
            }
        }
        magnitude.agree(&magnitude_again, |difference| difference)?;
        phase.agree(&phase_again, |difference| {
            let turn = difference.rem_euclid(TAU);
            turn.min(TAU - turn)
        })?;
        let twice = frequency.twice();
        let mut rows: Vec<SensitivityRow> = Vec::new();
        for i in 0..n {
            let (f, s) = (&frequency.cells[i], &magnitude.cells[i]);
            if !(f.value > 0.0) {
                return Err(refuse(
                    f.of,
                    format!(
                        "a frequency of {} Hz is out of range: it must be positive",
                        f.value
                    ),
                )
                .line(f.line));
            }
            if let Some(before) = twice.filter(|t| t.1 == i).and_then(|t| rows.get(t.0)) {
                return Err(refuse(
                    f.of,
                    format!("the frequency {} Hz stands twice, first with a sensitivity of {}", f.value, before.sensitivity),
                )
                .line(f.line)
                .with_hint("a certificate has one result at a frequency: ask the laboratory which one holds"));
            }
            if !(s.value > 0.0) {
                return Err(refuse(
                    s.of,
                    format!(
                        "a sensitivity of {} is out of range: it must be positive",
                        s.value
                    ),
                )
                .line(s.line)
                .with_hint("the magnitude is above zero; an inverted output has a phase of 180°"));
            }
            let u = |cell: &Cell| {
                cell.uncertainty.ok_or_else(|| {
                    refuse(cell.of, "states no uncertainty")
                        .line(cell.line)
                        .with_hint("a result without uncertainty is no standard: ask the laboratory for it")
                })
            };
            let sensitivity_uncertainty = u(s)?;
            if sensitivity_uncertainty <= 0.0 {
                return Err(refuse(s.of, "states an uncertainty of zero").with_hint(
                    "a sensitivity is never exact: ask the laboratory for its uncertainty",
                ));
            }
            if sensitivity_uncertainty > 0.5 * s.value {
                return Err(
                    refuse(s.of, "the uncertainty is more than half of the sensitivity")
                        .line(s.line),
                );
            }
            rows.push(SensitivityRow {
                line: s.line,
                frequency: f.value,
                sensitivity: s.value,
                sensitivity_uncertainty,
                phase: match phase.cells.get(i) {
                    Some(p) => Some([p.value, u(p)?]),
                    None => None,
                },
            });
        }
        Ok(DccSensitivity {
            output: output.unwrap_or(Unit::Volt),
            findings: doubtful_phases(&rows).into_iter().collect(),
            rows,
        })
    }
}

/// Phases that no accelerometer below its resonance has: beyond a whole turn, or all of them nearer to ±90° than to 0° and 180°.
fn doubtful_phases(rows: &[SensitivityRow]) -> Option<Finding> {
    let phases: Vec<f64> = rows.iter().filter_map(|r| Some(r.phase?[0])).collect();
    let across = |p: &f64| (p.rem_euclid(PI) - FRAC_PI_2).abs() < FRAC_PI_4;
    let beyond = phases.iter().find(|p| p.abs() > TAU);
    let doubtful = beyond.or_else(|| phases.first().filter(|_| phases.iter().all(across)))?;
    Some(findings::phase_unlikely(*doubtful, doubtful.to_degrees()))
}

/// Numbers in SI, one for each frequency.
struct Column<'a> {
    first: Option<&'a DccQuantity>,
    cells: Vec<Cell<'a>>,
}

struct Cell<'a> {
    of: &'a DccQuantity,
    line: u64,
    value: f64,
    uncertainty: Option<f64>,
}

impl<'a> Column<'a> {
    fn of(
        quantities: &[&'a DccQuantity],
        mut factor: impl FnMut(&DccQuantity) -> Result<f64>,
    ) -> Result<Self> {
        let mut cells = Vec::new();
        for quantity in quantities.iter().copied() {
            if quantities.len() > 1 && quantity.values.len() > 1 {
                return Err(refuse(quantity, "the quantity stands twice in one list")
                    .with_hint("a certificate with several results has a list for each"));
            }
            if let Some(outside) = quantity.uncertainty.as_ref().and_then(|u| u.outside) {
                let [low, high] = outside.interval;
                let said = format!(
                    "{} does not lie in its interval from {low} to {high}",
                    outside.value
                );
                return Err(refuse(quantity, &said)
                    .with_hint("ask the laboratory which of the two holds: neither is changed"));
            }
            let factor = factor(quantity)?;
            for (i, value) in quantity.values.iter().enumerate() {
                // In the order of a table of numbers: into SI, then divided by k.
                let uncertainty = quantity.uncertainty.as_ref().map(|u| {
                    let stated = u.stated_of(i) * factor;
                    u.coverage_factor(i).map_or(stated, |k| stated / k)
                });
                cells.push(Cell {
                    of: quantity,
                    line: quantity.lines.get(i).copied().unwrap_or(quantity.line),
                    value: value * factor,
                    uncertainty,
                });
            }
        }
        Ok(Self {
            first: quantities.first().copied(),
            cells,
        })
    }

    /// Places of the first value that stands there again, in their order.
    fn twice(&self) -> Option<(usize, usize)> {
        let mut order: Vec<usize> = (0..self.cells.len()).collect();
        let value = |i: &usize| self.cells[*i].value;
        order.sort_by(|a, b| value(a).total_cmp(&value(b)));
        let near = order
            .windows(2)
            .filter(|w| (value(&w[1]) - value(&w[0])).abs() <= ONE_FREQUENCY * value(&w[1]).abs());
        let places = near.map(|w| (w[0].min(w[1]), w[0].max(w[1])));
        places.min_by_key(|p| p.1)
    }

    /// Refuses another statement of the same values that contradicts this one; `size` is what a difference amounts to.
    fn agree(&self, again: &Self, size: impl Fn(f64) -> f64) -> Result<()> {
        for (one, other) in self.cells.iter().zip(&again.cells) {
            let u = one.uncertainty.or(other.uncertainty);
            let limit = ONE_EXACT_VALUE * one.value.abs() + ONE_VALUE * u.unwrap_or(0.0);
            if let (Some(a), Some(b)) = (one.uncertainty, other.uncertainty)
                && a.max(b) > ONE_UNCERTAINTY * a.min(b)
            {
                return Err(refuse(
                    other.of,
                    format!(
                        "a complex quantity states u = {b} where line {} states u = {a}",
                        one.line
                    ),
                )
                .with_hint("one value has two uncertainties: ask the laboratory which one holds"));
            }
            if size(one.value - other.value).abs() > limit {
                return Err(refuse(
                    other.of,
                    format!(
                        "a complex quantity states {} where line {} states {}",
                        other.value, one.line, one.value
                    ),
                )
                .with_hint("one value has two statements: ask the laboratory which one holds"));
            }
        }
        Ok(())
    }
}

fn wrong_unit(quantity: &DccQuantity, what: &str, example: &str) -> Error {
    let error = refuse(
        quantity,
        format!(
            "{} is no unit of a {what} that is known here",
            quantity.unit.text()
        ),
    );
    match quantity.unit.is_charge_per_acceleration() {
        true => error.with_hint("a charge per acceleration is the sensitivity of the sensor alone: a standard is calibrated with its charge amplifier, in volts"),
        false => error.with_hint(format!("such as {example}")),
    }
}

fn refuse(quantity: &DccQuantity, what: impl Into<String>) -> Error {
    let name = quantity.label.as_deref().unwrap_or(&quantity.name);
    Error::new(ErrorKind::Element, what)
        .line(quantity.line)
        .column(name)
}
