//! Whether the gains of the outputs reproduce from session to session: a bench that was taken down and set up anew.

use super::supported::{BetweenSessions, Supported};
use crate::adjustment::{Adjustment, Projected};
use crate::budget::Budget;
use crate::findings;
use crate::geometry::Configuration;
use crate::matrix::AXES;
use crate::observation::{PhasorRow, ascending, sessions};
use crate::plan::conditioning;
use faer::Mat;
use proofmass_core::Error;
use proofmass_uncertainty::algebra::symmetric_eigen;
use proofmass_uncertainty::{Finding, Severity, chi_squared_chance};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Probability of gains as far apart by chance from which sessions are said to differ.
const DIFFERENT: f64 = 1e-3;
/// Least difference that is worth a word, relative and in rad: that of a drift.
const WORTH: f64 = 1e-3;
/// Runs that a session needs: the gain of one cannot be told from the error of that run.
const RUNS: usize = 2;
/// Information beside the largest below which a gain is told by nothing.
const UNTOLD: f64 = 1e-6;

/// The gain of one output in one session over its mean of the sessions that are compared, less one.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SessionGain {
    /// The session.
    pub session: String,
    /// Readings of the session.
    pub readings: usize,
    /// The output, 0 to 2.
    pub output: usize,
    /// Relative difference of the modulus.
    pub modulus: f64,
    /// What readings, mountings and the declared inputs of a session make of it: its standard uncertainty.
    pub u_modulus: f64,
    /// Difference of the phase, rad; `None` where phases are not against the reference.
    pub phase: Option<f64>,
    /// Its standard uncertainty, rad.
    pub u_phase: Option<f64>,
}

impl SessionGain {
    fn size(&self) -> f64 {
        let of = |value: f64, u: f64| (value / u).abs();
        let phase = self.phase.zip(self.u_phase).map_or(0.0, |(v, u)| of(v, u));
        of(self.modulus, self.u_modulus).max(phase)
    }
}

/// Gains of the sessions against each other, and whether they differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Reproducibility {
    /// By session and output.
    pub gains: Vec<SessionGain>,
    /// Weighted sum of squares of all differences over its degrees of freedom: F.
    pub statistic: f64,
    /// Degrees of freedom of the differences, and of what remains.
    pub dof: [f64; 2],
    /// Probability of an F at least as large, did sessions differ by what is declared.
    pub p_value: f64,
    /// Standard deviation of a modulus from session to session beyond what is declared, relative, and of a phase, rad.
    pub spread: [f64; 2],
    /// What nobody declared of it and is in the result, as the runs tell it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub between: Vec<BetweenSessions>,
    /// Sessions that are compared with no other, each with the reason.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub uncompared: Vec<(String, String)>,
}

impl Reproducibility {
    /// Whether the sessions differ by more than is declared, and by so much that it is worth a word.
    pub fn differs(&self) -> bool {
        let largest = |g: &SessionGain| g.modulus.abs().max(g.phase.map_or(0.0, f64::abs));
        let largest = self.gains.iter().map(largest).fold(0.0, f64::max);
        self.p_value < DIFFERENT && largest > WORTH
    }
}

/// Rows of sessions of two runs or more, at frequencies that they determine.
fn comparable(rows: &[PhasorRow]) -> Vec<PhasorRow> {
    let mut rows = rows.to_vec();
    loop {
        let before = rows.len();
        let all: Vec<Option<String>> = rows.iter().map(|r| r.session.clone()).collect();
        rows.retain(|r| all.iter().filter(|s| **s == r.session).count() >= RUNS);
        for f in ascending(rows.iter().map(|r| r.frequency)) {
            let here = rows.iter().filter(|r| r.frequency == f);
            let plan: Vec<Configuration> = here.map(|r| r.configuration).collect();
            if plan.len() < 3 || conditioning(&plan).is_err() {
                rows.retain(|r| r.frequency != f);
            }
        }
        if rows.len() == before {
            return rows;
        }
    }
}

/// Gains of each output in each session, as further columns beside the model, with the contrasts that the runs tell: between
/// sessions that have a frequency in common, or each with one of a third.
///
/// δ̂ = P⁺ GᵀN⁻¹r̂ with P = GᵀN⁻¹G − GᵀN⁻¹X C XᵀN⁻¹G; δ̂ᵀP δ̂ is χ² with the rank of P when sessions differ by what is declared. Inputs that
/// vary with the session are in X as they are declared; readings and mountings as the runs have them.
///
/// **Source** score test `[Rao1948]`; conditions of intermediate precision and of reproducibility, VIM 2.22 and 2.24.
pub(super) fn of(supported: &Supported, budget: &Budget) -> Result<Option<Reproducibility>, Error> {
    let all = sessions(&supported.rows);
    if all.len() < 2 || supported.rows.iter().any(|r| r.session.is_none()) {
        return Ok(None);
    }
    let rows = comparable(&supported.rows);
    let names = sessions(&rows);
    let place = |r: &PhasorRow| names.iter().position(|s| Some(*s) == r.session.as_deref());
    let places: Vec<usize> = rows.iter().filter_map(place).collect();
    let mut set: Vec<usize> = (0..names.len()).collect();
    for f in ascending(rows.iter().map(|r| r.frequency)) {
        let here: Vec<usize> = (0..rows.len())
            .filter(|&i| rows[i].frequency == f)
            .map(|i| set[places[i]])
            .collect();
        let first = here[0];
        set.iter_mut()
            .filter(|s| here.contains(s))
            .for_each(|s| *s = first);
    }
    let mut uncompared: Vec<(String, String)> = vec![];
    for session in &all {
        let readings = supported.rows.iter();
        let readings = readings.filter(|r| r.session.as_deref() == Some(session));
        let why = match names.iter().position(|n| n == session) {
            _ if readings.count() < RUNS => {
                "it has one run, and the gain of a session cannot be told from the error of a run"
            }
            Some(s) if set.iter().filter(|t| **t == set[s]).count() > 1 => continue,
            Some(_) => "no other session has one of its frequencies",
            None => {
                "the runs at its frequencies do not determine the sensitivity without sessions of one run"
            }
        };
        uncompared.push(((*session).to_owned(), why.to_owned()));
    }
    let mut told = Reproducibility {
        gains: vec![],
        statistic: 0.0,
        dof: [0.0; 2],
        p_value: 1.0,
        spread: [0.0; 2],
        between: supported.between.clone(),
        uncompared,
    };
    if told.uncompared.len() == all.len() {
        return Ok(Some(told));
    }
    let within = supported.within_sessions(budget);
    let adjustment = match Adjustment::new(&rows, &supported.spurious, &within) {
        Err(Error::NotConverged { .. }) => return Ok(Some(told)),
        other => other?,
    };
    let count = 6 * names.len();
    let Projected { seen, p, largest } = adjustment.projected(count, |i| {
        let columns = adjustment.gain_columns(i).into_iter().enumerate();
        columns.map(|(k, c)| (6 * places[i] + k, c)).collect()
    });
    let symmetric = Mat::from_fn(count, count, |i, j| 0.5 * (p[(i, j)] + p[(j, i)]));
    let eigen = symmetric_eigen(&symmetric, "eigenvalues of the gains of sessions")?;
    let along = |e: usize, v: &dyn Fn(usize) -> f64| -> f64 {
        (0..count).map(|i| eigen.U()[(i, e)] * v(i)).sum()
    };
    let seen: Vec<f64> = (0..count).map(|e| along(e, &|i| seen[i])).collect();
    let known: Vec<bool> = (0..count)
        .map(|e| eigen.S()[e] > UNTOLD * largest)
        .collect();
    let (mut chi_squared, mut rank) = (0.0, 0);
    for e in (0..count).filter(|&e| known[e]) {
        chi_squared += seen[e] * seen[e] / eigen.S()[e];
        rank += 1;
    }
    // A gain over the mean of the sessions it is compared with; `None` where nothing tells it.
    let contrast = |s: usize, k: usize| -> Option<(f64, f64)> {
        let together: Vec<usize> = (0..names.len()).filter(|&t| set[t] == set[s]).collect();
        let share = 1.0 / together.len() as f64;
        let v = |i: usize| {
            let mean = together.contains(&(i / 6)) && i % 6 == k;
            f64::from(u8::from(i == 6 * s + k)) - if mean { share } else { 0.0 }
        };
        let (mut value, mut variance, mut hidden) = (0.0, 0.0, 0.0);
        for e in 0..count {
            let part = along(e, &v);
            if known[e] {
                value += part * seen[e] / eigen.S()[e];
                variance += part * part / eigen.S()[e];
            } else {
                hidden += part * part;
            }
        }
        (together.len() > 1 && hidden < 1e-6).then(|| (value, variance.sqrt()))
    };
    let mut spread = [(0.0, 0.0); 2];
    for (s, session) in names.iter().enumerate() {
        for output in 0..3 {
            let [modulus, phase] = [0, 1].map(|part| contrast(s, 2 * output + part));
            let alone = set.iter().filter(|t| **t == set[s]).count() as f64;
            for (sum, part) in spread.iter_mut().zip([modulus, phase]) {
                if let Some((value, u)) = part {
                    // The variance about a mean of n is (n − 1)/n of that between sessions.
                    sum.0 += value * value - u * u;
                    sum.1 += 1.0 - 1.0 / alone;
                }
            }
            if let Some((modulus, u_modulus)) = modulus {
                told.gains.push(SessionGain {
                    session: (*session).to_owned(),
                    readings: places.iter().filter(|p| **p == s).count(),
                    output,
                    modulus,
                    u_modulus,
                    phase: phase.map(|p| p.0),
                    u_phase: phase.map(|p| p.1),
                });
            }
        }
    }
    told.spread = spread.map(|(sum, n): (f64, f64)| (sum / n.max(1.0)).max(0.0).sqrt());
    let left = adjustment.dof() as f64 - f64::from(rank);
    if rank > 0 && left > 0.0 {
        // Where readings scatter less than declared, the declaration counts.
        let scatter = ((adjustment.chi_squared - chi_squared) / left).max(1.0);
        let rank = f64::from(rank);
        told.statistic = chi_squared / rank / scatter;
        told.dof = [rank, left];
        told.p_value = match FisherSnedecor::new(rank, left) {
            Ok(f) => f.sf(told.statistic),
            Err(_) => chi_squared_chance(rank * told.statistic, rank),
        };
    }
    Ok(Some(told))
}

/// What is to be said of the sessions of these rows.
pub(super) fn findings(rows: &[PhasorRow], told: Option<&Reproducibility>) -> Vec<Finding> {
    let mut found = vec![];
    let Some(told) = told else {
        if let [one] = sessions(rows)[..] {
            found.push(findings::sessions_not_compared(
                "all runs are of one session: how well another one reproduces them was not seen",
                &format!("{} readings of session {one}", rows.len()),
            ));
        }
        return found;
    };
    if !told.uncompared.is_empty() {
        let names: Vec<&str> = told.uncompared.iter().map(|(s, _)| s.as_str()).collect();
        let mut reasons: Vec<&str> = told.uncompared.iter().map(|(_, w)| w.as_str()).collect();
        reasons.dedup();
        let (what, severity) = match told.gains.is_empty() {
            true => (
                "no session can be compared with another: how well they reproduce each other was not seen".to_owned(),
                Severity::Warning,
            ),
            false => (
                format!("session {} is compared with no other", names.join(", ")),
                Severity::Note,
            ),
        };
        let evidence = format!("session {}: {}", names.join(", "), reasons.join("; "));
        found.push(findings::sessions_not_compared(&what, &evidence).at(severity));
    }
    if told.differs() {
        let farthest = told.gains.iter();
        let farthest = farthest.max_by(|a, b| a.size().total_cmp(&b.size()));
        if let Some(farthest) = farthest {
            let of = told.gains.iter().filter(|g| g.session == farthest.session);
            let gains: Vec<String> = of.map(gain).collect();
            let [nu, left] = told.dof;
            let degrees = told.spread[1].to_degrees();
            let phases = told.gains.iter().any(|g| g.phase.is_some());
            let spread = match phases {
                true => format!("{:.2} % and {degrees:.2}°", 100.0 * told.spread[0]),
                false => format!("{:.2} %", 100.0 * told.spread[0]),
            };
            found.push(findings::sessions_differ(
                &farthest.session,
                &gains.join("; "),
                &spread,
                told.statistic,
                nu,
                left,
                told.p_value,
            ));
        }
    }
    found
}

fn gain(g: &SessionGain) -> String {
    let axis = AXES[g.output];
    let (value, u) = (100.0 * g.modulus, 100.0 * g.u_modulus);
    let phase = g.phase.zip(g.u_phase).map_or(String::new(), |(p, u)| {
        let (p, u) = (p.to_degrees(), u.to_degrees());
        format!(", {p:+.2}° (u = {u:.2}°)")
    });
    format!("output {axis} {value:+.2} % (u = {u:.2} %){phase}")
}
