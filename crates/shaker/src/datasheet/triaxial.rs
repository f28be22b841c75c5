//! The datasheet of a triaxial device as its maker prints it, and what a calibration says of its promises.

use crate::campaign::{MethodResult, ShakerMethod};
use crate::derived::{Expanded, PROBABILITY};
use crate::matrix::AXES;
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_dynamic::FrequencyResponse;
use proofmass_signal::transfer::polar;
use proofmass_uncertainty::findings::{beyond_limit, limit_undecided};
use proofmass_uncertainty::{DegreesOfFreedom, Finding, Judgement, Limits};
use serde::{Deserialize, Serialize};

/// What a maker states of a triaxial device.
///
/// ```
/// use proofmass_shaker::datasheet::{Datasheet, SheetBand};
/// // 10.2 mV/(m/s²) ± 10 %; ± 5 % from 2 Hz to 5 kHz and ± 10 % from 1.4 Hz to 6.5 kHz; transverse at most 5 %.
/// let mut sheet = Datasheet::of(10.2e-3, Some(1.02e-3));
/// sheet.bands = vec![SheetBand::new(2.0, 5000.0, 0.05), SheetBand::new(1.4, 6500.0, 0.10)];
/// sheet.transverse = Some(0.05);
/// assert_eq!(sheet.band(0, 160.0), Some(0.05));
/// assert_eq!(sheet.band(0, 6000.0), Some(0.10));
/// assert_eq!(sheet.band(0, 1.0), None);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(from = "Stated")]
#[non_exhaustive]
pub struct Datasheet {
    /// Sensitivity along x, y and z, where it is stated.
    pub axes: [Option<SheetSensitivity>; 3],
    /// Bands of frequencies.
    pub bands: Vec<SheetBand>,
    /// Frequency in Hz from whose sensitivity the bands count; without it they count from the sensitivity of the sheet.
    pub reference: Option<f64>,
    /// Largest transverse sensitivity, relative.
    pub transverse: Option<f64>,
}

/// Sensitivity of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SheetSensitivity {
    /// Output per m/s².
    pub value: f64,
    /// Its tolerance or expanded uncertainty, likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
}

/// A band of frequencies within which the sensitivity departs by no more than a tolerance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SheetBand {
    /// Lowest frequency, Hz.
    pub from: f64,
    /// Highest frequency, Hz.
    pub to: f64,
    /// Largest departure, relative.
    pub tolerance: f64,
    /// Outputs that it holds for, 0 to 2; all when empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub axes: Vec<usize>,
}

impl SheetBand {
    /// A band of all axes.
    pub fn new(from: f64, to: f64, tolerance: f64) -> Self {
        Self {
            from,
            to,
            tolerance,
            axes: Vec::new(),
        }
    }
}

/// As it is read: one number with its tolerance for all axes, or everything.
#[derive(Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
enum Stated {
    /// Sensitivity of all axes and its tolerance.
    One(f64, f64),
    /// Axes, bands and transverse sensitivity.
    Whole {
        /// Sensitivity along x, y and z, where it is stated.
        axes: [Option<SheetSensitivity>; 3],
        /// Bands of frequencies.
        #[serde(default)]
        bands: Vec<SheetBand>,
        /// Frequency in Hz from whose sensitivity the bands count; without it they count from the sensitivity of the sheet.
        #[serde(default)]
        reference: Option<f64>,
        /// Largest transverse sensitivity, relative.
        #[serde(default)]
        transverse: Option<f64>,
    },
}

impl From<Stated> for Datasheet {
    fn from(stated: Stated) -> Self {
        match stated {
            Stated::One(value, tolerance) => Self::of(value, Some(tolerance)),
            Stated::Whole {
                axes,
                bands,
                reference,
                transverse,
            } => Self {
                axes,
                bands,
                reference,
                transverse,
            },
        }
    }
}

/// What a sheet promises.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Promise {
    /// |S_jj| against the sensitivity of the sheet.
    Sensitivity,
    /// |S_jj| against that at the reference frequency.
    Response,
    /// The transverse sensitivity.
    Transverse,
}

/// One promise of a sheet at one frequency, and what was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SheetDeviation {
    /// What is promised.
    pub promise: Promise,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Output.
    pub axis: &'static str,
    /// Departure as a share of what it is held against; of the transverse sensitivity itself.
    pub value: f64,
    /// Its expanded uncertainty at 95 %, as the same share.
    pub expanded: f64,
    /// That over its standard uncertainty.
    pub coverage_factor: f64,
    /// Tolerance of the sheet at this frequency, as the same share; of the transverse sensitivity its limit. `None` where the sheet has none.
    pub tolerance: Option<f64>,
    /// E_n = (|S_jj| − S_p)/√(U² + U_p²), U_p the tolerance; none of a transverse sensitivity, which is promised to have a limit and no
    /// value.
    pub e_n: Option<f64>,
    /// Whether the whole interval is within the limits, beyond, or neither. **Source** `[JCGM106] 8.3`.
    pub judgement: Option<Judgement>,
}

impl SheetDeviation {
    /// √(U² + U_p²) as a share of the value of the sheet: E_n is the departure over it.
    pub fn allowed(&self) -> Option<f64> {
        Some(self.expanded.hypot(self.tolerance?))
    }

    /// `x at 1000 Hz: +6.2 % ± 0.5 %, limit ± 5 %`.
    fn in_words(&self) -> String {
        let [value, expanded, limit] =
            [self.value, self.expanded, self.tolerance.unwrap_or(0.0)].map(|v| 100.0 * v);
        let at = format!("{} at {} Hz", self.axis, self.frequency);
        match self.promise {
            Promise::Transverse => {
                format!("{at}: {value:.2} % ± {expanded:.2} %, limit {limit} %")
            }
            _ => format!("{at}: {value:+.2} % ± {expanded:.2} %, limit ± {limit:.2} %"),
        }
    }

    /// Of a sensitivity against what it should be.
    fn about(head: Head, value: f64, u: (f64, f64), tolerance: Option<f64>) -> Result<Self, Error> {
        let (promise, frequency, axis) = head;
        let (expanded, coverage_factor) = u;
        let limits = tolerance.map(|t| Limits::between(-t, t)).transpose()?;
        Ok(Self {
            promise,
            frequency,
            axis: AXES[axis],
            value,
            expanded,
            coverage_factor,
            tolerance,
            e_n: tolerance.map(|t| value / expanded.hypot(t)),
            judgement: limits.map(|l| l.judge((value - expanded, value + expanded))),
        })
    }
}

type Head = (Promise, f64, usize);

/// A modulus with U at 95 % and k.
#[derive(Clone, Copy)]
struct Measured {
    value: f64,
    expanded: f64,
    k: f64,
}

impl Measured {
    /// At 95 %, whatever factor it is stated with.
    fn of(e: &Expanded) -> Self {
        let dof = e.dof.and_then(DegreesOfFreedom::new);
        let k = dof
            .unwrap_or(DegreesOfFreedom::INFINITE)
            .coverage_factor(PROBABILITY);
        Self {
            value: e.value,
            expanded: k * e.standard_uncertainty,
            k,
        }
    }
}

/// Farthest that a measured frequency may be from the reference frequency of the sheet to stand for it: an octave.
const NEAR: f64 = 2.0;

impl Datasheet {
    /// One sensitivity of all axes.
    pub fn of(value: f64, tolerance: Option<f64>) -> Self {
        Self {
            axes: [Some(SheetSensitivity { value, tolerance }); 3],
            ..Self::default()
        }
    }

    /// Tolerance of an output at a frequency by the bands: the smallest of those that hold there.
    pub fn band(&self, axis: usize, frequency: f64) -> Option<f64> {
        self.bands
            .iter()
            .filter(|b| b.axes.is_empty() || b.axes.contains(&axis))
            .filter(|b| (b.from..=b.to).contains(&frequency))
            .map(|b| b.tolerance)
            .min_by(f64::total_cmp)
    }

    /// The measured frequency that stands for the reference frequency: the nearest, within an octave.
    pub fn reference_among(&self, frequencies: impl IntoIterator<Item = f64>) -> Option<f64> {
        let reference = self.reference?;
        let away = |f: f64| (f / reference).ln().abs();
        let nearest = frequencies
            .into_iter()
            .min_by(|a, b| away(*a).total_cmp(&away(*b)))?;
        (away(nearest) <= NEAR.ln()).then_some(nearest)
    }

    /// Every promise at every frequency of a result.
    ///
    /// Without bands the tolerance of the sensitivity holds at every frequency. With bands that of a band holds within it, about the
    /// sensitivity of the sheet; where [`Datasheet::reference`] says from which frequency they count, about the measured sensitivity there,
    /// and the tolerance of the sensitivity holds at that frequency alone. U of such a ratio knows what the two frequencies share; where that
    /// is not known it is the largest that any correlation allows.
    ///
    /// # Errors
    /// As [`MethodResult::frequency_response`].
    pub fn against(&self, result: &MethodResult) -> Result<Vec<SheetDeviation>, Error> {
        let moduli = moduli(result);
        let counted = self.reference_among(moduli.iter().map(|m| m.0));
        let response = match counted {
            Some(_) if !self.bands.is_empty() => result.frequency_response()?,
            _ => None,
        };
        let mut list = Vec::new();
        for (frequency, axes) in &moduli {
            for (axis, m) in axes.iter().enumerate() {
                let Some(sheet) = self.axes[axis] else {
                    continue;
                };
                let own = sheet.tolerance.map(|t| t / sheet.value);
                let tolerance = match (self.bands.is_empty(), self.reference) {
                    (true, _) => own,
                    (false, None) => self.band(axis, *frequency),
                    (false, Some(_)) => own.filter(|_| counted == Some(*frequency)),
                };
                list.push(SheetDeviation::about(
                    (Promise::Sensitivity, *frequency, axis),
                    m.value / sheet.value - 1.0,
                    (m.expanded / sheet.value, m.k),
                    tolerance,
                )?);
            }
            let Some(from) = counted.filter(|f| f != frequency) else {
                continue;
            };
            let Some((_, reference)) = moduli.iter().find(|m| m.0 == from) else {
                continue;
            };
            for (axis, (m, r)) in axes.iter().zip(reference).enumerate() {
                let Some(tolerance) = self.band(axis, *frequency) else {
                    continue;
                };
                let ratio = m.value / r.value;
                let k = m.k.max(r.k);
                let relative = match &response {
                    Some(response) => k * of_ratio(response, axis, [*frequency, from])?,
                    None => m.expanded / m.value + r.expanded / r.value,
                };
                list.push(SheetDeviation::about(
                    (Promise::Response, *frequency, axis),
                    ratio - 1.0,
                    (ratio * relative, k),
                    Some(tolerance),
                )?);
            }
        }
        if let Some(limit) = self.transverse {
            list.extend(across(result, limit)?);
        }
        Ok(list)
    }

    /// Frequencies at which no band holds for an output that the sheet states, where there are bands.
    pub fn beyond_the_bands(&self, frequencies: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let stated = |axis: &usize| self.axes[*axis].is_some();
        let outside = |f: &f64| (0..3).filter(stated).any(|a| self.band(a, *f).is_none());
        let all = frequencies.into_iter().filter(outside);
        all.filter(|_| !self.bands.is_empty()).collect()
    }
}

/// |S_jj| of the three outputs at every frequency, with U at 95 %; of the published method with its k = 2.
fn moduli(result: &MethodResult) -> Vec<(f64, [Measured; 3])> {
    if result.method == ShakerMethod::PublishedMagnitude {
        let known = result.published.iter().filter_map(|p| {
            let of = |j: usize| {
                Some(Measured {
                    value: p.fit.sensitivity[j][j].abs(),
                    expanded: p.fit.sensitivity_expanded[j][j].filter(|u| u.is_finite())?,
                    k: 2.0,
                })
            };
            Some((p.frequency, [of(0)?, of(1)?, of(2)?]))
        });
        return known.collect();
    }
    let of = |f: &crate::FrequencyResult| {
        let terms = [0, 4, 8].map(|k| Measured::of(&f.sensitivity[k].modulus));
        (f.frequency, terms)
    };
    result.frequencies.iter().map(of).collect()
}

/// Relative standard uncertainty of |S_jj(f)|/|S_jj(g)|, f and g in Hz.
fn of_ratio(
    response: &FrequencyResponse,
    axis: usize,
    frequencies: [f64; 2],
) -> Result<f64, Error> {
    let p = response.real_part(axis, axis)?;
    let series = response.series();
    let n = series.dimension();
    let places = frequencies.map(|f| series.points().iter().position(|p| p.at == f));
    let [Some(first), Some(second)] = places else {
        return Err(Error::TooFew {
            name: "frequencies of a ratio",
            needed: 2,
            got: places.iter().flatten().count(),
        });
    };
    let places = [first, second];
    // d|z|/|z| of the two reals of the element.
    let along = |place: usize| -> ([f64; 2], f64) {
        let estimate = &series.points()[place].estimate;
        let [re, im] = [0, 1].map(|k| estimate.components()[p + k].value);
        let square = re * re + im * im;
        let c = estimate.covariance();
        let parts = [c[(p, p)], c[(p, p + 1)], c[(p + 1, p + 1)]];
        let (u, _) = polar(Complex64::new(re, im), parts);
        ([re / square, im / square], u / square.sqrt())
    };
    let [(a, u), (b, v)] = places.map(along);
    Ok(match series.covariance(places[0], places[1]) {
        None => u + v,
        Some(block) => {
            let mut shared = 0.0;
            for (i, da) in a.iter().enumerate() {
                for (j, db) in b.iter().enumerate() {
                    shared += da * db * block[n * (p + i) + p + j];
                }
            }
            (u * u + v * v - 2.0 * shared).max(0.0).sqrt()
        }
    })
}

/// The transverse sensitivities against their limit.
fn across(result: &MethodResult, limit: f64) -> Result<Vec<SheetDeviation>, Error> {
    let limits = Limits::below(limit)?;
    let mut list = Vec::new();
    for f in &result.frequencies {
        for axis in AXES {
            let name = format!("transverse.{axis}");
            let Some(q) = f.transverse.iter().find(|q| q.name == name) else {
                continue;
            };
            let m = Measured::of(q);
            let lowest = (m.value - m.expanded).max(0.0);
            list.push(SheetDeviation {
                promise: Promise::Transverse,
                frequency: f.frequency,
                axis,
                value: m.value,
                expanded: m.expanded,
                coverage_factor: m.k,
                tolerance: Some(limit),
                e_n: None,
                judgement: Some(limits.judge((lowest, m.value + m.expanded))),
            });
        }
    }
    Ok(list)
}

/// What a reader has to know of the bands and the transverse sensitivity: promises that are not kept (a decision), and those that the
/// interval leaves open. The sensitivity itself without bands is told by [`off_datasheet`](super::off_datasheet), at one frequency.
pub fn kept(sheet: &Datasheet, deviations: &[SheetDeviation]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let groups = [
        (
            Promise::Sensitivity,
            "the sensitivity within the bands of the datasheet",
            "look at the motion of the bench, the mounting and the conditioner; else the device does not keep to its datasheet",
        ),
        (
            Promise::Response,
            "the sensitivity against that at the reference frequency of the datasheet",
            "look at resonances of wedge and mounting and at the motion of the bench; else the device does not keep to its datasheet",
        ),
        (
            Promise::Transverse,
            "the transverse sensitivity against the datasheet",
            "look at the motion of the bench and the mounting; else the device does not keep to its datasheet",
        ),
    ];
    let alone = sheet.bands.is_empty() || sheet.reference.is_some();
    for (promise, subject, remedy) in groups {
        if promise == Promise::Sensitivity && alone {
            continue;
        }
        let list = |judgement: Judgement| -> Vec<String> {
            let these = deviations.iter().filter(|d| d.promise == promise);
            these
                .filter(|d| d.judgement == Some(judgement))
                .map(SheetDeviation::in_words)
                .collect()
        };
        let (beyond, open) = (list(Judgement::Fail), list(Judgement::Undecided));
        if !beyond.is_empty() {
            findings.push(beyond_limit(
                &format!("{subject} is"),
                &listed(&beyond),
                remedy,
            ));
        }
        if !open.is_empty() {
            let advice = "the budget shows which contribution to reduce";
            findings.push(limit_undecided(subject, &listed(&open), advice));
        }
    }
    findings
}

/// The first of them, and how many more.
fn listed(all: &[String]) -> String {
    const SHOWN: usize = 6;
    let more = all.len().saturating_sub(SHOWN);
    let shown = all.iter().take(SHOWN).map(String::as_str);
    let mut text = shown.collect::<Vec<_>>().join("; ");
    if more > 0 {
        text += &format!("; and {more} more, in datasheet.csv");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::PublishedResult;
    use crate::published::PublishedFit;

    /// The printed S and U(S) of one case, V/(m/s²), as a result of the published method.
    fn printed(case: &str) -> MethodResult {
        let text = include_str!("../../tests/inrim-pcb356a15/matrices.csv");
        let rows: Vec<Vec<&str>> = text.lines().map(|l| l.split(',').collect()).collect();
        let rows: Vec<&Vec<&str>> = rows.iter().filter(|f| f[0] == case).collect();
        let published = rows.chunks(9).map(|nine| {
            let of = |column: usize| -> [[f64; 3]; 3] {
                std::array::from_fn(|i| {
                    std::array::from_fn(|j| nine[3 * i + j][column].parse().unwrap())
                })
            };
            PublishedResult {
                frequency: nine[0][1].parse().unwrap(),
                fit: PublishedFit {
                    exploitation: of(3),
                    exploitation_expanded: of(4).map(|r| r.map(Some)),
                    sensitivity: of(5).map(|r| r.map(|s| 1e-3 * s)),
                    sensitivity_expanded: of(6).map(|r| r.map(|u| Some(1e-3 * u))),
                },
            }
        });
        MethodResult {
            method: ShakerMethod::PublishedMagnitude,
            correction: case.to_owned(),
            frequencies: vec![],
            published: published.collect(),
            chi_squared: None,
            runs: vec![],
            angles: vec![],
            findings: vec![],
            reproducibility: None,
            datasheet: vec![],
            shared: None,
            identifiability: None,
            components: vec![],
            motion: vec![],
        }
    }

    /// The sheet of the PCB 356A15, `[Murgia2022]` 2.1.8: 10.2 mV/(m/s²) ± 10 %, bands of 5 % and 10 %, transverse at most 5 %.
    fn sheet() -> Datasheet {
        let mut sheet = Datasheet::of(10.2e-3, Some(1.02e-3));
        sheet.bands = vec![
            SheetBand::new(1.4, 6500.0, 0.10),
            SheetBand::new(2.0, 5000.0, 0.05),
        ];
        sheet.transverse = Some(0.05);
        sheet
    }

    #[test]
    fn published_sensitivities_against_the_sheet_of_the_source() {
        // "All sensitivities lie within the band of the maker, but at high frequencies those corrected with the second measurement": by
        // value ± U two more do not, both at 1000 Hz.
        let mut beyond = vec![];
        let mut outside = vec![];
        for case in ["uncorrected", "corrected-first", "corrected-second"] {
            let all = sheet().against(&printed(case)).unwrap();
            assert_eq!(all.len(), 27);
            for d in &all {
                assert_eq!(d.tolerance, Some(0.05));
                let name = format!("{case} {} {}", d.frequency, d.axis);
                if d.judgement == Some(Judgement::Fail) {
                    beyond.push(name.clone());
                }
                if d.value.abs() > 0.05 {
                    outside.push(name);
                }
            }
            if case == "uncorrected" {
                // S_xx = 10.74 ± 0.24 at 5 Hz: E_n of annex C is 0.54/√(0.24² + 0.51²).
                let d = &all[0];
                assert!((d.value - 0.54 / 10.2).abs() < 1e-12);
                assert!((d.e_n.unwrap() - 0.54 / 0.24f64.hypot(0.51)).abs() < 1e-9);
                assert_eq!(d.judgement, Some(Judgement::Undecided));
            }
        }
        assert_eq!(
            beyond,
            [
                "uncorrected 1000 x",
                "corrected-first 1000 z",
                "corrected-second 315 x",
                "corrected-second 315 y",
                "corrected-second 315 z",
                "corrected-second 630 y",
                "corrected-second 1000 z",
            ]
        );
        // By their values alone fifteen more do not.
        assert_eq!(
            outside,
            [
                "uncorrected 5 x",
                "uncorrected 5 z",
                "uncorrected 1000 x",
                "uncorrected 1000 y",
                "corrected-first 160 y",
                "corrected-first 315 y",
                "corrected-first 1000 z",
                "corrected-second 5 x",
                "corrected-second 5 z",
                "corrected-second 10 z",
                "corrected-second 160 x",
                "corrected-second 160 y",
                "corrected-second 160 z",
                "corrected-second 315 x",
                "corrected-second 315 y",
                "corrected-second 315 z",
                "corrected-second 630 x",
                "corrected-second 630 y",
                "corrected-second 630 z",
                "corrected-second 1000 x",
                "corrected-second 1000 y",
                "corrected-second 1000 z",
            ]
        );
    }

    #[test]
    fn known_bands_that_count_from_a_frequency() {
        let mut sheet = sheet();
        sheet.reference = Some(15.0);
        let all = sheet.against(&printed("corrected-first")).unwrap();
        // 20 Hz stands for 15 Hz; its sensitivity alone has the 10 % of the sheet.
        let of = |promise: Promise, f: f64| {
            let same = |d: &&SheetDeviation| d.promise == promise && d.frequency == f;
            all.iter().find(same).unwrap()
        };
        assert_eq!(of(Promise::Sensitivity, 20.0).tolerance, Some(0.1));
        assert_eq!(of(Promise::Sensitivity, 315.0).tolerance, None);
        assert_eq!(of(Promise::Sensitivity, 315.0).e_n, None);
        let d = of(Promise::Response, 315.0);
        assert!((d.value - (9.73 / 9.85 - 1.0)).abs() < 1e-12);
        // Nothing is known of what the two share: U is the sum.
        let relative = 0.22 / 9.73 + 0.22 / 9.85;
        assert!((d.expanded - 9.73 / 9.85 * relative).abs() < 1e-12);
        assert!(
            !all.iter()
                .any(|d| d.promise == Promise::Response && d.frequency == 20.0)
        );
        // Nothing was measured near 5 kHz, and 1 Hz is in no band.
        sheet.reference = Some(5000.0);
        assert_eq!(sheet.reference_among([5.0, 315.0]), None);
        assert_eq!(sheet.beyond_the_bands([1.0, 1.5, 7000.0]), [1.0, 7000.0]);
    }

    #[test]
    fn known_forms_of_a_request() {
        let one: Datasheet = serde_json::from_str("[0.0102, 0.00102]").unwrap();
        assert_eq!(one, Datasheet::of(0.0102, Some(0.00102)));
        let text = serde_json::to_string(&sheet()).unwrap();
        assert_eq!(serde_json::from_str::<Datasheet>(&text).unwrap(), sheet());
    }
}
