//! Primary calibration: the sensitivity by the acceleration that an interferometer tells.

use crate::copied_readings::{Reading, copies};
use crate::departing::{DeclaredReading, doubts};
use crate::findings;
use crate::interferometer::{AmplitudeCheck, CheckMethod, QuadratureFit};
use crate::repeated_runs::{MeanOfRuns, by_frequency, unrepeated};
use crate::single_axis::{SingleAxis, TransverseMotion};
use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_signal::transfer::turned;
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Finding, Influence,
    Severity,
};
use serde::{Deserialize, Serialize};

/// One run, as the samples tell it.
#[derive(Clone, Debug, PartialEq)]
pub struct PrimaryRun {
    /// Name of the run.
    pub run: String,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Acceleration by the interferometer, m/s².
    pub acceleration: Complex64,
    /// Output of the device, in its own unit.
    pub output: Complex64,
    /// Covariance rr, ri, ii of the two by the noise of the recording.
    pub noise: [[f64; 3]; 2],
    /// Covariance of the acceleration by the correction of the quadrature.
    pub correction: [f64; 3],
    /// Relative standard uncertainty of the acceleration by what is left of the quadrature.
    pub remainder: f64,
    /// Transverse motion relative to the motion along the axis, where it was measured.
    pub transverse: Option<f64>,
    /// Amplitudes by other methods.
    pub checks: Vec<AmplitudeCheck>,
}

/// An input of the budget that somebody declared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DeclaredInput {
    /// Key in the budget.
    pub name: String,
    /// What it is.
    pub description: String,
    /// Relative standard uncertainty of the modulus.
    pub relative: f64,
    /// Standard uncertainty of the phase, rad.
    pub phase: f64,
    /// Degrees of freedom of the two.
    pub dof: DegreesOfFreedom,
}

/// What is known of the bench beside the samples; the same in all runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PrimaryBudget {
    /// Relative standard uncertainty of the wavelength.
    pub wavelength: f64,
    /// Relative standard uncertainty of the sampling clock, which enters the acceleration squared.
    #[serde(default)]
    pub clock: f64,
    /// Standard uncertainty of the delay between the channels of the front end, s.
    #[serde(default)]
    pub front_end: f64,
    /// Transverse sensitivity and motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transverse: Option<TransverseMotion>,
    /// Voltage calibration, disturbing motion and whatever else was declared.
    #[serde(default)]
    pub declared: Vec<DeclaredInput>,
}

/// Degrees of freedom of the noise beside a drive: ten bins, in two parts each.
const NOISE_DOF: f64 = 20.0;
/// Causes that are drawn anew in every run: the repeats show them.
const OF_ONE_RUN: [&str; 3] = [
    "noise.acceleration",
    "noise.output",
    "quadrature.correction",
];

impl PrimaryRun {
    /// S, output over acceleration.
    pub fn sensitivity(&self) -> Complex64 {
        self.output / self.acceleration
    }

    /// Covariances of the relative modulus and of the phase of S by the causes of [`OF_ONE_RUN`].
    fn own(&self) -> [[f64; 3]; 3] {
        let (a, u) = (self.acceleration.inv(), self.output.inv());
        [
            turned(self.noise[0], a),
            turned(self.noise[1], u),
            turned(self.correction, a),
        ]
    }
}

fn influence(
    key: &str,
    description: &str,
    (evaluation, dof): (Evaluation, DegreesOfFreedom),
    rows: [f64; 4],
) -> Result<Influence, Error> {
    Ok(Influence {
        key: key.to_owned(),
        description: description.to_owned(),
        evaluation,
        distribution: "normal".to_owned(),
        dof,
        effect: Effect::Joint {
            covariance: Covariance::try_from_rows(2, &rows)?,
        },
    })
}

/// S of every run, with the budget of each.
///
/// Components `modulus` and `phase` (rad). Influences: noise of the two phasors, correction of the quadrature and what is left of it,
/// wavelength, clock, delay, transverse motion, and what was declared.
///
/// # Errors
/// [`Error::NotFinite`] for a run without signal.
pub fn sensitivities(
    runs: &[PrimaryRun],
    unit: &str,
    budget: &PrimaryBudget,
) -> Result<Vec<SingleAxis>, Error> {
    let few = (
        Evaluation::A,
        DegreesOfFreedom::new(NOISE_DOF).unwrap_or(DegreesOfFreedom::INFINITE),
    );
    let known = (Evaluation::B, DegreesOfFreedom::INFINITE);
    let of = |(index, run): (usize, &PrimaryRun)| {
        let s = run.sensitivity();
        let m = s.norm();
        if !(m > 0.0 && m.is_finite()) {
            return Err(Error::NotFinite {
                name: "output over acceleration",
                index,
            });
        }
        let parts = |[rr, ri, ii]: [f64; 3]| [rr * m * m, ri * m, ri * m, ii];
        let apart = |u: f64, phase: f64| [(u * m).powi(2), 0.0, 0.0, phase * phase];
        let [acceleration, output, correction] = run.own();
        let mut list = vec![
            influence(
                OF_ONE_RUN[0],
                "noise of the interferometer",
                few,
                parts(acceleration),
            )?,
            influence(OF_ONE_RUN[1], "noise of the output", few, parts(output))?,
            influence(
                OF_ONE_RUN[2],
                "offsets, gains and phase error of the quadrature signals",
                (Evaluation::A, DegreesOfFreedom::INFINITE),
                parts(correction),
            )?,
            influence(
                "quadrature.remainder",
                "what the correction leaves of the quadrature",
                known,
                apart(run.remainder, run.remainder),
            )?,
            influence(
                "wavelength",
                "wavelength of the laser",
                known,
                apart(budget.wavelength, 0.0),
            )?,
        ];
        if budget.clock > 0.0 {
            let rows = apart(2.0 * budget.clock, 0.0);
            list.push(influence("clock", "clock of the sampling", known, rows)?);
        }
        if budget.front_end > 0.0 {
            let turn = std::f64::consts::TAU * run.frequency * budget.front_end;
            let what = "delay between the channels of the front end";
            list.push(influence("front_end.delay", what, known, apart(0.0, turn))?);
        }
        if let Some(u) = budget
            .transverse
            .and_then(|t| t.uncertainty(run.transverse))
        {
            let what =
                "transverse sensitivity of the device, with the transverse motion of the table";
            list.push(influence("transverse", what, known, apart(u, u))?);
        }
        for d in &budget.declared {
            let how = (Evaluation::B, d.dof);
            let key = format!("declared.{}", d.name);
            list.push(influence(
                &key,
                &d.description,
                how,
                apart(d.relative, d.phase),
            )?);
        }
        Ok(SingleAxis {
            frequency: run.frequency,
            sensitivity: s,
            estimate: Estimate::new(components(s, unit), list)?,
        })
    };
    runs.iter().enumerate().map(of).collect()
}

fn components(s: Complex64, unit: &str) -> Vec<Component> {
    vec![
        Component::new("modulus", unit, s.norm()),
        Component::new("phase", "rad", s.arg()),
    ]
}

/// Mean over the runs of each frequency, in ascending frequency; a frequency of one run stays as it is.
///
/// What is drawn anew in every run (noise, correction of the quadrature) is replaced by the scatter of the runs, which is never less
/// than what the recordings tell of it ([`Repeats::mean_of`](proofmass_uncertainty::Repeats::mean_of)); the rest is common to them and stays.
///
/// Repeats that are copies are findings, and a run that is no repeat of the others: by the scatter of these alone, since nothing is
/// declared of how well a run repeats.
///
/// # Errors
/// As [`Estimate::new`].
pub fn means(
    runs: &[PrimaryRun],
    single: &[SingleAxis],
) -> Result<(Vec<SingleAxis>, Vec<Finding>), Error> {
    let mut means = Vec::new();
    let groups = by_frequency(single);
    let mut findings: Vec<Finding> = unrepeated(&groups).into_iter().collect();
    let frequencies = groups.len();
    for group in groups {
        let of_one: Vec<&SingleAxis> = group.iter().map(|&i| &single[i]).collect();
        if let [one] = of_one[..] {
            means.push(one.clone());
            continue;
        }
        let here = group.iter().map(|&i| &runs[i]);
        let readings = here
            .clone()
            .map(|r| Reading::new(&r.run, r.frequency, &[r.acceleration, r.output]));
        findings.extend(copies(&readings.collect::<Vec<_>>()));
        let names: Vec<&str> = here.map(|r| r.run.as_str()).collect();
        let values: Vec<Complex64> = of_one.iter().map(|r| r.sensitivity).collect();
        findings.extend(doubts(
            &names,
            of_one[0].frequency,
            &values,
            &DeclaredReading::NOTHING,
            frequencies,
        ));
        let n = group.len() as f64;
        let own: Vec<[f64; 3]> = group.iter().flat_map(|&i| runs[i].own()).collect();
        let noise = [0, 2].map(|part| (own.iter().map(|v| v[part]).sum::<f64>() / n).sqrt());
        let dof = DegreesOfFreedom::new(NOISE_DOF * n).unwrap_or(DegreesOfFreedom::INFINITE);
        means.push(MeanOfRuns::of(&of_one, &OF_ONE_RUN, (noise, dof))?.result);
    }
    Ok((means, findings))
}

/// What the samples do not show and nobody stated: a warning where `[[budget]]` has nothing, a note where something is left. `None` where all of it is stated.
pub fn undeclared(budget: &PrimaryBudget) -> Option<Finding> {
    let declared = &budget.declared;
    let mut missing = Vec::new();
    if declared.is_empty() {
        missing.push("the calibration of the voltage of the output");
        missing.push("the angle of the beam to the axis, and motion of the surface against the device (displacement)");
    }
    if budget.front_end == 0.0 && declared.iter().all(|d| d.phase == 0.0) {
        missing.push("the phase: delay between the channels");
    }
    if missing.is_empty() {
        return None;
    }
    if declared.is_empty() && budget.clock == 0.0 {
        missing.push("the sampling clock (displacement becomes acceleration by its square)");
    }
    let none = declared.is_empty();
    let what = match none {
        true => {
            "the budget has nothing but the laser and the noise: U is that of the samples, not that of a calibration"
        }
        false => "the budget leaves an input out",
    };
    let found = findings::primary_budget_incomplete(what, &missing.join("; "));
    Some(found.at(match none {
        true => Severity::Warning,
        false => Severity::Note,
    }))
}

/// Modulus at a frequency by another method, beside that of method 3.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MethodCheck {
    /// Frequency in Hz.
    pub frequency: f64,
    /// The method.
    pub method: CheckMethod,
    /// Runs that it could be used in.
    pub runs: usize,
    /// Modulus of S by it.
    pub modulus: f64,
    /// Its standard uncertainty by the amplitude alone.
    pub uncertainty: f64,
    /// Departure from method 3, relative.
    pub departure: f64,
    /// Its standard uncertainty: both methods.
    pub departure_uncertainty: f64,
}

impl MethodCheck {
    /// E_n with k = 2.
    ///
    /// **Source** `[ISO13528]` 9.7.
    pub fn e_n(&self) -> Option<f64> {
        let u = self.departure_uncertainty;
        (u > 0.0).then(|| self.departure / (2.0 * u))
    }
}

/// The other methods at every frequency, and the findings of those that disagree.
pub fn method_checks(
    runs: &[PrimaryRun],
    means: &[SingleAxis],
) -> (Vec<MethodCheck>, Vec<Finding>) {
    let mut checks = Vec::new();
    for result in means {
        let own: Vec<(f64, &AmplitudeCheck)> = runs
            .iter()
            .filter(|r| r.frequency == result.frequency)
            .flat_map(|r| r.checks.iter().map(|c| (r.output.norm(), c)))
            .collect();
        let (Some((_, first)), Some(modulus)) = (own.first(), result.estimate.get("modulus"))
        else {
            continue;
        };
        let n = own.len() as f64;
        let by = own.iter().map(|(u, c)| u / c.acceleration).sum::<f64>() / n;
        // The error of a count is the same in every run of one amplitude.
        let own = own.iter().map(|(_, c)| c.uncertainty / c.acceleration);
        let relative = own.sum::<f64>() / n;
        checks.push(MethodCheck {
            frequency: result.frequency,
            method: first.method,
            runs: n as usize,
            modulus: by,
            uncertainty: relative * by,
            departure: by / modulus.value - 1.0,
            departure_uncertainty: relative.hypot(modulus.standard_uncertainty / modulus.value),
        });
    }
    let beyond = |c: &&MethodCheck| c.e_n().is_some_and(|e| e.abs() > 1.5);
    let findings = checks.iter().filter(beyond).map(|c| {
        let name = match c.method {
            CheckMethod::FringeCounting => "fringe counting",
            CheckMethod::MinimumPoint => "the minimum point",
        };
        findings::methods_disagree(
            name,
            c.frequency,
            100.0 * c.departure,
            c.e_n().unwrap_or_default(),
        )
    });
    let findings = findings.collect();
    (checks, findings)
}

/// Phase beyond which the motion is taken the wrong way round rather than the device turned by its own dynamics, rad.
const TURNED: f64 = 2.6;

/// Whether the device is in antiphase with the motion at its lowest frequency: then the two signals are exchanged, or the device inverts.
pub fn sign_of_motion(means: &[SingleAxis]) -> Option<Finding> {
    let lowest = means.first()?;
    let phase = lowest.sensitivity.arg();
    (phase.abs() > TURNED).then(|| findings::motion_inverted(lowest.frequency, phase.to_degrees()))
}

/// Distance of the samples from the circle, root mean square and relative, from which on the pair is doubtful.
const RESIDUAL: f64 = 0.05;
/// Relative uncertainty of the acceleration by what is left of the quadrature from which on it is told.
const REMAINDER: f64 = 1e-3;

/// Whether the quadrature signals of a run cover the turn and lie on an ellipse.
pub fn quadrature_doubts(run: &PrimaryRun, fit: &QuadratureFit) -> Vec<Finding> {
    let mut doubts = Vec::new();
    if fit.arc < 360.0 {
        let [rr, _, ii] = run.correction;
        let u = 100.0 * (rr + ii).sqrt() / run.acceleration.norm();
        doubts.push(findings::quadrature_arc(&run.run, fit.arc, u, "").at(Severity::Warning));
    }
    if fit.residual > RESIDUAL || run.remainder > REMAINDER {
        let (residual, remainder) = (100.0 * fit.residual, 100.0 * run.remainder);
        doubts.push(findings::quadrature_residual(&run.run, residual, remainder));
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(acceleration: Complex64, output: Complex64) -> PrimaryRun {
        PrimaryRun {
            run: "a".into(),
            frequency: 160.0,
            acceleration,
            output,
            noise: [[1e-8, 0.0, 1e-8], [4e-12, 0.0, 4e-12]],
            correction: [0.0; 3],
            remainder: 0.0,
            transverse: None,
            checks: vec![],
        }
    }

    /// u² = (u_a/a)² + (u_U/U)² + u_λ² + u_d², and of the phase without the two last but one.
    #[test]
    fn known_budget_of_one_run_and_of_repeats() {
        let budget = PrimaryBudget {
            wavelength: 2e-5,
            declared: vec![DeclaredInput {
                name: "voltage".into(),
                description: "voltage".into(),
                relative: 3e-5,
                phase: 1e-5,
                dof: DegreesOfFreedom::INFINITE,
            }],
            ..PrimaryBudget::default()
        };
        let one = run(Complex64::new(6.0, 8.0), Complex64::new(0.0, 0.1));
        let single = sensitivities(std::slice::from_ref(&one), "V", &budget).unwrap();
        let e = &single[0].estimate;
        let noise = (1e-4 / 10.0f64).hypot(2e-6 / 0.1);
        let [m, p] = ["modulus", "phase"].map(|n| e.get(n).unwrap());
        assert!((m.value - 0.01).abs() < 1e-15);
        let wanted = noise.hypot(2e-5).hypot(3e-5) * 0.01;
        assert!((m.standard_uncertainty / wanted - 1.0).abs() < 1e-9);
        assert!((p.standard_uncertainty / noise.hypot(1e-5) - 1.0).abs() < 1e-9);
        // Four that agree too well: the recordings say what they may scatter by, and the rest does not average out.
        let four = vec![one; 4];
        let single = sensitivities(&four, "V", &budget).unwrap();
        let mean = means(&four, &single).unwrap().0;
        let m = mean[0].estimate.get("modulus").unwrap();
        let wanted = (0.5 * noise).hypot(2e-5).hypot(3e-5) * 0.01;
        assert!((m.standard_uncertainty / wanted - 1.0).abs() < 1e-9);
        assert_eq!(mean.len(), 1);
    }

    #[test]
    fn known_inputs_that_nobody_stated() {
        let mut budget = PrimaryBudget::default();
        let found = undeclared(&budget).unwrap();
        assert_eq!(
            (found.code(), found.severity()),
            ("primary-budget-incomplete", Severity::Warning)
        );
        for missing in ["voltage", "angle of the beam", "phase"] {
            assert!(found.evidence_text().contains(missing), "{found:?}");
        }
        budget.declared = vec![DeclaredInput {
            name: "voltage".into(),
            description: "voltage".into(),
            relative: 1e-4,
            phase: 0.0,
            dof: DegreesOfFreedom::INFINITE,
        }];
        let found = undeclared(&budget).unwrap();
        assert_eq!(found.severity(), Severity::Note);
        budget.declared[0].phase = 1e-4;
        assert!(undeclared(&budget).is_none());
    }

    /// One run of three that was read with another gain, and one that is a copy.
    #[test]
    fn known_run_that_is_no_repeat() {
        let at = |name: &str, modulus: f64| PrimaryRun {
            run: name.into(),
            ..run(
                Complex64::new(6.0, 8.0),
                Complex64::from_polar(modulus, 1.234_567_8),
            )
        };
        let of = |runs: &[PrimaryRun]| {
            let single = sensitivities(runs, "V", &PrimaryBudget::default()).unwrap();
            means(runs, &single).unwrap().1
        };
        let mut runs = vec![at("a", 0.1), at("b", 0.100_01), at("c", 0.099_995)];
        assert!(of(&runs).is_empty(), "{:?}", of(&runs));
        runs[1].output *= 10.0;
        let found = of(&runs);
        assert_eq!((found.len(), found[0].code()), (1, "no-repeat"));
        assert!(found[0].what().starts_with("run b is no repeat"));
        runs[1] = at("b", 0.1);
        assert_eq!(of(&runs)[0].code(), "copied-run");
        assert_eq!(of(&runs[..1])[0].code(), "repeatability-unseen");
    }

    #[test]
    fn known_methods_that_disagree_are_told() {
        let mut one = run(Complex64::new(10.0, 0.0), Complex64::new(0.1, 0.0));
        let check = |acceleration| AmplitudeCheck {
            method: CheckMethod::FringeCounting,
            acceleration,
            uncertainty: 0.02,
        };
        one.checks = vec![check(10.01)];
        let of = |one: &PrimaryRun| {
            let runs = std::slice::from_ref(one);
            let single = sensitivities(runs, "V", &PrimaryBudget::default()).unwrap();
            method_checks(runs, &means(runs, &single).unwrap().0)
        };
        let (checks, findings) = of(&one);
        assert!(findings.is_empty());
        assert!((checks[0].departure + 1e-3).abs() < 1e-5);
        assert!((checks[0].e_n().unwrap() + 0.25).abs() < 0.01);
        one.checks = vec![check(10.2)];
        assert_eq!(of(&one).1[0].code(), "methods-disagree");
    }
}
