//! The results as tables of files.

use super::ShakerTriaxialOutcome;
use crate::page::AXES;
use crate::page::columns::{filed, frequency, number};
use crate::page::polar::{Polar, polar};
use proofmass_documents::StatedQuantity;
use proofmass_report::{Field, Rounding, Table};
use proofmass_shaker::datasheet::{Promise, SheetDeviation};
use proofmass_shaker::derived::{Expanded, SensitivityTerm};
use proofmass_shaker::published::PublishedFit;
use proofmass_shaker::recording::{CHANNELS, RunInput};
use proofmass_shaker::{
    AppliedAcceleration, ComponentCheck, Configuration, FrequencyCheck, FrequencyResult,
    MethodResult, OutputUnit, RunResult, SessionGain, ShakerMethod,
};
use proofmass_uncertainty::{BudgetLine, DegreesOfFreedom, Judgement, Verdict};

/// Moduli and phases of S and A at one frequency, by names such as `S.xx.modulus[frequency=10]`.
pub(super) fn quantities(f: &FrequencyResult) -> Vec<StatedQuantity> {
    f.sensitivity
        .iter()
        .chain(&f.exploitation)
        .flat_map(|t| std::iter::once(&t.modulus).chain(t.phase.as_ref()))
        .chain(&f.transverse)
        .chain(&f.intrinsic)
        .map(|e| stated(e, f.frequency))
        .collect()
}

/// A quantity at one frequency, as a result states it.
pub(crate) fn stated(e: &Expanded, frequency: f64) -> StatedQuantity {
    StatedQuantity {
        name: format!("{}[frequency={frequency}]", e.name),
        unit: e.unit.clone(),
        value: e.value,
        u: Some(e.standard_uncertainty),
        expanded: e.expanded,
        k: Some(e.coverage_factor),
        nu_eff: Some(
            e.dof
                .and_then(DegreesOfFreedom::new)
                .unwrap_or(DegreesOfFreedom::INFINITE),
        ),
        probability: e.probability,
        interval: None,
        method: None,
    }
}

pub(super) fn word(method: ShakerMethod) -> &'static str {
    match method {
        ShakerMethod::PublishedMagnitude => "published",
        ShakerMethod::Complex => "complex",
        ShakerMethod::Joint => "joint",
    }
}

/// A unit as headings spell it.
fn ascii(unit: &str) -> String {
    unit.replace('²', "2")
}

/// Tables of the matrices, their budgets, the residuals and the runs.
pub(super) fn tables(outcome: &ShakerTriaxialOutcome) -> Vec<Table> {
    let results = &outcome.calibration.results;
    let output = outcome.budget.output;
    let unit = &ascii(output.sensitivity());
    let sensitivity = matrix(
        results,
        unit,
        |f| &f.sensitivity,
        |p| (p.sensitivity, p.sensitivity_expanded),
    );
    let exploitation = matrix(
        results,
        output.exploitation(),
        |f| &f.exploitation,
        |p| (p.exploitation, p.exploitation_expanded),
    );
    let mut list = vec![
        sensitivity.file("sensitivity.csv"),
        exploitation.file("exploitation.csv"),
        derived(results).file("derived.csv"),
        budget(results, unit).file("budget.csv"),
        residuals(results, unit).file("residuals.csv"),
        phasors(&outcome.runs, outcome.acceleration, output).file("phasors.csv"),
        applied(&outcome.applied).file("applied.csv"),
    ];
    let compared = results.iter().any(|r| r.reproducibility.is_some());
    if compared {
        list.push(sessions(results).file("sessions.csv"));
    }
    if results.iter().any(|r| !r.datasheet.is_empty()) {
        list.push(datasheet(results).file("datasheet.csv"));
    }
    if !outcome.monte_carlo.is_empty() {
        list.push(monte_carlo(&outcome.monte_carlo, unit).file("monte-carlo.csv"));
    }
    if outcome.recordings > 0 {
        list.push(recordings(&outcome.runs).file("recordings.csv"));
    }
    list
}

/// Result and frequency, which every row of a result begins with.
type Head<'a> = (&'a MethodResult, f64);

fn begin<'a, R: 'a>(head: impl Fn(&R) -> Head<'a> + Copy + 'a) -> Vec<Field<'a, R>> {
    vec![
        Field::new("method", move |r| word(head(r).0.method).into()),
        Field::new("correction", move |r| head(r).0.correction.as_str().into()),
        frequency(move |r| head(r).1),
    ]
}

/// What every result has at each of its frequencies.
fn at_frequencies<'a, T, L: IntoIterator<Item = T> + 'a>(
    results: &'a [MethodResult],
    list: impl Fn(&'a FrequencyResult) -> L + 'a,
) -> impl Iterator<Item = (Head<'a>, T)> {
    let frequencies = results
        .iter()
        .flat_map(|result| result.frequencies.iter().map(move |f| (result, f)));
    let rows = frequencies.map(move |(result, f)| ((result, f.frequency), list(f)));
    rows.flat_map(|(head, list)| list.into_iter().map(move |item| (head, item)))
}

/// Values and expanded uncertainties of nine terms.
type Terms = ([[f64; 3]; 3], [[Option<f64>; 3]; 3]);

fn matrix(
    results: &[MethodResult],
    unit: &str,
    terms: impl Fn(&FrequencyResult) -> &[SensitivityTerm],
    published: impl Fn(&PublishedFit) -> Terms,
) -> Table {
    type Row<'a> = ((Head<'a>, String), Polar);
    let mut rows: Vec<Row<'_>> = Vec::new();
    for result in results {
        for f in &result.frequencies {
            rows.extend(terms(f).iter().map(|t| {
                let polar = Polar::new(Some([t.re, t.im]), &t.modulus, t.phase.as_ref());
                (((result, f.frequency), t.name.clone()), polar)
            }));
        }
        for p in &result.published {
            let (value, expanded) = published(&p.fit);
            for (k, (modulus, expanded)) in value
                .iter()
                .flatten()
                .zip(expanded.iter().flatten())
                .enumerate()
            {
                let polar = Polar {
                    parts: None,
                    modulus: *modulus,
                    u: expanded.map(|u| 0.5 * u),
                    expanded: *expanded,
                    k: 2.0,
                    dof: None,
                    phase: None,
                };
                let term = format!("{}{}", AXES[k / 3], AXES[k % 3]);
                rows.push((((result, p.frequency), term), polar));
            }
        }
    }
    let mut fields = begin(|r: &Row<'_>| r.0.0);
    fields.push(Field::new("term", |r: &Row<'_>| r.0.1.as_str().into()));
    fields.extend(polar(unit, None));
    Table::of("", fields, rows)
}

/// A quantity that follows from the matrices: its name, unit and value, and how well it is known where that is stated.
struct Derived<'a> {
    name: String,
    unit: &'a str,
    value: f64,
    stated: Option<&'a Expanded>,
}

impl<'a> From<&'a Expanded> for Derived<'a> {
    fn from(stated: &'a Expanded) -> Self {
        Self {
            name: stated.name.clone(),
            unit: &stated.unit,
            value: stated.value,
            stated: Some(stated),
        }
    }
}

impl Derived<'_> {
    /// S* and S** (or A*, A**) of a term: over the main term of its row, and its expanded uncertainty over its modulus.
    fn of_term(symbol: &str, k: usize, [starred, relative]: [Option<f64>; 2]) -> Vec<Self> {
        let of = |stars: &str, value: f64| Self {
            name: format!("{symbol}{stars}.{}{}", AXES[k / 3], AXES[k % 3]),
            unit: "1",
            value,
            stated: None,
        };
        let values = [starred.map(|v| of("*", v)), relative.map(|v| of("**", v))];
        values.into_iter().flatten().collect()
    }
}

/// Normalised matrices and relative uncertainties, transverse sensitivity, leaning of the axes, intrinsic properties.
fn derived(results: &[MethodResult]) -> Table {
    type Row<'a> = (Head<'a>, Derived<'a>);
    let stated = at_frequencies(results, |f| {
        let quantities = f
            .normalised
            .iter()
            .chain(&f.normalised_exploitation)
            .chain(&f.transverse)
            .chain(&f.misalignment)
            .chain(&f.intrinsic);
        let matrices = [("S", &f.sensitivity), ("A", &f.exploitation)];
        let relative = matrices.into_iter().flat_map(|(symbol, terms)| {
            terms.iter().enumerate().flat_map(move |(k, term)| {
                let relative = finite(term.modulus.expanded / term.modulus.value);
                Derived::of_term(symbol, k, [None, relative])
            })
        });
        quantities
            .map(Derived::from)
            .chain(relative)
            .collect::<Vec<_>>()
    });
    let published = results.iter().flat_map(|result| {
        result.published.iter().flat_map(move |p| -> Vec<Row<'_>> {
            let matrices = [
                ("S", &p.fit.sensitivity, &p.fit.sensitivity_expanded),
                ("A", &p.fit.exploitation, &p.fit.exploitation_expanded),
            ];
            let terms = matrices.into_iter().flat_map(|(symbol, values, expanded)| {
                (0..9).flat_map(move |k| {
                    let (i, j) = (k / 3, k % 3);
                    let starred = finite(values[i][j] / values[i][i]);
                    let relative = expanded[i][j].and_then(|u| finite(u / values[i][j].abs()));
                    Derived::of_term(symbol, k, [starred, relative])
                })
            });
            terms
                .map(|derived| ((result, p.frequency), derived))
                .collect()
        })
    });
    let mut fields = begin(|r: &Row<'_>| r.0);
    fields.extend([
        Field::new("quantity", |r: &Row<'_>| r.1.name.as_str().into()),
        Field::new("unit", |r: &Row<'_>| r.1.unit.into()),
        filed("value", |r: &Row<'_>| r.1.value),
        filed("u", |r: &Row<'_>| {
            r.1.stated.map(|q| q.standard_uncertainty)
        }),
        filed("U", |r: &Row<'_>| r.1.stated.map(|q| q.expanded)),
        filed("k", |r: &Row<'_>| r.1.stated.map(|q| q.coverage_factor)),
        filed("nu_eff", |r: &Row<'_>| r.1.stated.and_then(|q| q.dof)),
    ]);
    Table::of("", fields, stated.chain(published))
}

/// Every promise of the datasheet with every method and correction, at 95 %; an empty field where the sheet promises nothing.
fn datasheet(results: &[MethodResult]) -> Table {
    type Row<'a> = (Head<'a>, &'a SheetDeviation);
    let rows = results.iter().flat_map(|result| {
        let all = result.datasheet.iter();
        all.map(move |d| -> Row<'_> { ((result, d.frequency), d) })
    });
    let mut fields = begin(|r: &Row<'_>| r.0);
    fields.extend([
        Field::new("promise", |r: &Row<'_>| promise_word(r.1.promise).into()),
        Field::new("output", |r: &Row<'_>| r.1.axis.into()),
        filed("value_%", |r: &Row<'_>| 100.0 * r.1.value),
        filed("U_%", |r: &Row<'_>| 100.0 * r.1.expanded),
        filed("k", |r: &Row<'_>| r.1.coverage_factor),
        filed("limit_%", |r: &Row<'_>| r.1.tolerance.map(|t| 100.0 * t)),
        filed("E_n", |r: &Row<'_>| r.1.e_n),
        Field::new("verdict", |r: &Row<'_>| {
            judgement_word(r.1.judgement).into()
        }),
    ]);
    Table::of("", fields, rows)
}

pub(super) fn promise_word(promise: Promise) -> &'static str {
    match promise {
        Promise::Response => "response",
        Promise::Transverse => "transverse",
        _ => "sensitivity",
    }
}

/// As the verdicts of `device check`; nothing where the sheet has no limit.
pub(super) fn judgement_word(judgement: Option<Judgement>) -> &'static str {
    match judgement {
        Some(Judgement::Pass) => "pass",
        Some(Judgement::Fail) => "fail",
        Some(Judgement::Undecided) => "undecided",
        None => "",
    }
}

/// One row per term of S and input.
fn budget(results: &[MethodResult], unit: &str) -> Table {
    type Row<'a> = (Head<'a>, (&'a str, &'a BudgetLine));
    let rows = at_frequencies(results, |f| {
        let terms = f.sensitivity.iter();
        terms.flat_map(|t| t.budget.iter().map(|line| (t.name.as_str(), line)))
    });
    let mut fields = begin(|r: &Row<'_>| r.0);
    fields.extend([
        Field::new("term", |r: &Row<'_>| r.1.0.into()),
        Field::new("input", |r: &Row<'_>| r.1.1.key.as_str().into()),
        Field::new("description", |r: &Row<'_>| {
            r.1.1.description.as_str().into()
        }),
        Field::new("distribution", |r: &Row<'_>| {
            r.1.1.distribution.as_str().into()
        }),
        // Infinite degrees of freedom are an empty field.
        filed("dof", |r: &Row<'_>| {
            Some(r.1.1.dof)
                .filter(|nu| !nu.is_infinite())
                .map(|nu| nu.get())
        }),
        filed(format!("contribution_{unit}"), |r: &Row<'_>| {
            r.1.1.contribution
        }),
        filed("share", |r: &Row<'_>| r.1.1.share),
    ]);
    Table::of("", fields, rows)
}

fn residuals(results: &[MethodResult], unit: &str) -> Table {
    type Row<'a> = (Head<'a>, &'a RunResult);
    let rows = results.iter().flat_map(|result| {
        let runs = result.runs.iter();
        runs.map(move |run| -> Row<'_> { ((result, run.frequency), run) })
    });
    let mut fields = begin(|r: &Row<'_>| r.0);
    fields.push(Field::new("run", |r: &Row<'_>| r.1.run.as_str().into()));
    let mut runs = results.iter().flat_map(|r| &r.runs);
    if runs.any(|r| r.session.is_some()) {
        fields.push(session(|r: &Row<'_>| r.1.session.as_deref()));
    }
    for (k, axis) in AXES.into_iter().enumerate() {
        fields.push(filed(format!("direction_{axis}"), move |r: &Row<'_>| {
            r.1.direction[k]
        }));
    }
    for (k, axis) in AXES.into_iter().enumerate() {
        for (part, name) in ["real", "imaginary"].into_iter().enumerate() {
            fields.push(filed(
                format!("error_{name}_{axis}_{unit}"),
                move |r: &Row<'_>| finite(r.1.prediction_error[k][part]),
            ));
        }
        for (part, name) in ["real", "imaginary"].into_iter().enumerate() {
            fields.push(filed(
                format!("studentised_{name}_{axis}"),
                move |r: &Row<'_>| finite(r.1.studentised[k][part]),
            ));
        }
    }
    fields.push(filed("chi_squared_6", |r: &Row<'_>| finite(r.1.statistic)));
    fields.push(filed("influence", |r: &Row<'_>| finite(r.1.influence)));
    Table::of("", fields, rows)
}

/// The session of a run, where the table of runs has them.
fn session<'a, R: 'a>(of: impl for<'r> Fn(&'r R) -> Option<&'r str> + 'a) -> Field<'a, R> {
    Field::new("session", move |r| of(r).into())
}

/// A number, where it exists.
fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|v| v.is_finite())
}

/// Name, frequency and mounting, which every row of a run begins with.
fn mounted<'a, R: 'a>(
    of: impl for<'r> Fn(&'r R) -> (&'r str, f64, Configuration) + Copy + 'a,
) -> Vec<Field<'a, R>> {
    vec![
        Field::new("run", move |r| of(r).0.into()),
        frequency(move |r| of(r).1),
        filed("inclination_deg", move |r| of(r).2.inclination.to_degrees()),
        filed("rotation_deg", move |r| of(r).2.rotation.to_degrees()),
    ]
}

/// Phasors as they went into the fit, in the form of a table of runs.
fn phasors(runs: &[RunInput], acceleration: bool, output: OutputUnit) -> Table {
    type R = RunInput;
    let of_outputs = ascii(output.symbol());
    let mut fields = mounted(|r: &R| (r.run.as_str(), r.frequency, r.configuration));
    if runs.iter().any(|r| r.session.is_some()) {
        fields.push(session(|r: &R| r.session.as_deref()));
    }
    for (k, name) in CHANNELS.into_iter().enumerate() {
        let unit = match (k, acceleration) {
            (0, true) => "m/s2",
            (0, false) => "V",
            _ => &of_outputs,
        };
        let phasor = move |r: &R| match k {
            0 => r.reference,
            k => r.outputs[k - 1],
        };
        fields.extend([
            filed(format!("{name}_{unit}"), move |r: &R| phasor(r).norm()),
            filed(format!("{name}_phase_deg"), move |r: &R| {
                phasor(r).arg().to_degrees()
            }),
            filed(format!("u_{name}_{unit}"), move |r: &R| {
                let [rr, _, ii] = r.covariance[k];
                (0.5 * (rr + ii)).sqrt()
            }),
        ]);
    }
    Table::of("", fields, runs)
}

/// Accelerations along the axes of the device, with U at 95 % and its degrees of freedom: in phase with the reference (`real`), and a
/// quarter of a period ahead of it.
fn applied(runs: &[AppliedAcceleration]) -> Table {
    type R = AppliedAcceleration;
    let mut fields = mounted(|r: &R| (r.run.as_str(), r.frequency, r.configuration));
    if runs.iter().any(|r| r.session.is_some()) {
        fields.push(session(|r: &R| r.session.as_deref()));
    }
    fields.push(Field::new("correction", |r: &R| {
        r.correction.as_str().into()
    }));
    fields.push(filed("reference_m/s2", |r: &R| r.reference));
    for (i, axis) in AXES.into_iter().enumerate() {
        for (k, part) in ["real", "imaginary"].into_iter().enumerate() {
            let of = move |r: &R| r.components[i][k];
            fields.extend([
                filed(format!("a_{axis}_{part}_m/s2"), move |r: &R| of(r).value),
                filed(format!("U_a_{axis}_{part}_m/s2"), move |r: &R| {
                    of(r).expanded(0.95)
                }),
                filed(format!("nu_a_{axis}_{part}"), move |r: &R| {
                    finite(of(r).dof.get())
                }),
            ]);
        }
    }
    Table::of("", fields, runs)
}

/// Gains of the outputs in each session over their mean of the sessions.
fn sessions(results: &[MethodResult]) -> Table {
    type Row<'a> = (&'a MethodResult, &'a SessionGain);
    let rows = results.iter().flat_map(|result| {
        let told = result.reproducibility.iter();
        told.flat_map(move |told| told.gains.iter().map(move |g| -> Row<'_> { (result, g) }))
    });
    let mut fields = vec![
        Field::new("method", |r: &Row<'_>| word(r.0.method).into()),
        Field::new("correction", |r: &Row<'_>| r.0.correction.as_str().into()),
    ];
    fields.extend(session_gain(|r: &Row<'_>| r.1));
    Table::of("", fields, rows)
}

/// The gain of an output in a session, of file and page.
pub(super) fn session_gain<'a, R: 'a>(
    of: impl for<'r> Fn(&'r R) -> &'r SessionGain + Copy + 'a,
) -> [Field<'a, R>; 7] {
    [
        Field::new("session", move |r| of(r).session.as_str().into()).page("session", ""),
        number("readings", ("readings", ""), Rounding::Plain, move |r| {
            of(r).readings
        }),
        Field::new("output", move |r| AXES[of(r).output].into()).page("output", ""),
        number(
            "gain_ratio",
            ("gain over the mean", ""),
            Rounding::Decimals(5),
            move |r| 1.0 + of(r).modulus,
        ),
        number("u_gain_ratio", ("u", ""), Rounding::Decimals(5), move |r| {
            of(r).u_modulus
        }),
        number(
            "phase_deg",
            ("phase against the mean", "°"),
            Rounding::Decimals(3),
            move |r| of(r).phase.map(f64::to_degrees),
        ),
        number(
            "u_phase_deg",
            ("u", "°"),
            Rounding::Decimals(3),
            move |r| of(r).u_phase.map(f64::to_degrees),
        ),
    ]
}

/// What the samples of each recording said beside the phasors.
fn recordings(runs: &[RunInput]) -> Table {
    type R = RunInput;
    let mut fields = vec![
        Field::new("run", |r: &R| r.run.as_str().into()),
        frequency(|r: &R| r.frequency),
        filed("measured_frequency_Hz", |r: &R| {
            r.quality.measured_frequency
        }),
        filed("distortion_%", |r: &R| {
            r.quality.distortion.map(|d| 100.0 * d)
        }),
    ];
    if runs.iter().any(|r| r.session.is_some()) {
        fields.push(session(|r: &R| r.session.as_deref()));
    }
    for (k, name) in CHANNELS.into_iter().enumerate() {
        fields.push(filed(format!("snr_{name}_dB"), move |r: &R| {
            finite(*r.quality.signal_to_noise.get(k)?)
        }));
    }
    fields.push(Field::new("clipped", |r: &R| {
        let names: Vec<&str> = r.quality.clipped.iter().map(|&k| CHANNELS[k]).collect();
        names.join(" ").into()
    }));
    let recorded = |r: &&R| r.quality.measured_frequency.is_some();
    Table::of("", fields, runs.iter().filter(recorded))
}

fn monte_carlo(checks: &[FrequencyCheck], unit: &str) -> Table {
    type Row<'a> = (&'a FrequencyCheck, &'a ComponentCheck);
    let rows = checks
        .iter()
        .flat_map(|c| c.components.iter().map(move |v| -> Row<'_> { (c, v) }));
    let of = |name: &str, get: fn(&ComponentCheck) -> Option<f64>| {
        filed(format!("{name}_{unit}"), move |r: &Row<'_>| get(r.1))
    };
    let fields = [
        frequency(|r: &Row<'_>| r.0.frequency),
        Field::new("component", |r: &Row<'_>| r.1.component.as_str().into()),
        filed("trials", |r: &Row<'_>| r.0.trials as usize),
        of("u_propagated", |v| Some(v.linear)),
        of("u_monte_carlo", |v| v.monte_carlo),
        of("lower_propagated", |v| Some(v.linear_interval[0])),
        of("lower_monte_carlo", |v| Some(v.interval[0])),
        of("upper_propagated", |v| Some(v.linear_interval[1])),
        of("upper_monte_carlo", |v| Some(v.interval[1])),
        of("tolerance", |v| Some(v.validation.tolerance)),
        Field::new("validated", |r: &Row<'_>| {
            match r.1.validation.verdict {
                Verdict::Validated => "yes",
                Verdict::NotValidated => "no",
                Verdict::Undecided => "undecided",
            }
            .into()
        }),
    ];
    Table::of("", fields, rows)
}
