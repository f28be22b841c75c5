//! Sessions of a campaign: their key of the budget, and whether they reproduce each other.

use num_complex::Complex64;
use proofmass_core::Error;
use proofmass_shaker::campaign::frequency_result;
use proofmass_shaker::geometry::published_plan;
use proofmass_shaker::monte_carlo::{CheckOptions, validate};
use proofmass_shaker::plan::{Expected, predict, sound_matrix};
use proofmass_shaker::{
    Acts, Budget, Configuration, Correction, Fit, Key, PhasorRow, ShakerCampaign, ShakerInput,
    ShakerMethod, SpuriousTable, calibrate, joint,
};
use proofmass_uncertainty::{Finding, Severity};
use std::ops::ControlFlow;

#[path = "../examples/session_map.rs"]
#[allow(dead_code, reason = "its printed table")]
mod program;

use program::shaker_faults::runs;
use program::shaker_faults::shaker_coverage::Gluings;
use program::{Change, Sessions, Split, differ, holding};

const READING: [Key; 2] = [Key::Run, Key::Channel];

/// Readings of 0.1 % and 1 mrad, and one more input.
fn budget(more: Option<ShakerInput>) -> Budget {
    let mut inputs = vec![
        ShakerInput::new("reading", Acts::OutputModulus, 1e-3, &READING),
        ShakerInput::new("phase", Acts::OutputPhase, 1e-3, &READING),
        ShakerInput::new("noise", Acts::OutputAdditive, 5e-5, &READING),
    ];
    inputs.extend(more);
    Budget::new(inputs).expect("a budget")
}

/// Every third configuration of the published plan once in each session, of a device of 10 mV/(m/s²), without an error.
fn exact(sessions: &[&str], frequencies: &[f64]) -> Vec<PhasorRow> {
    let mut rows = vec![];
    for &frequency in frequencies {
        for session in sessions {
            for configuration in published_plan().into_iter().step_by(3) {
                let [x, y, z] = configuration.direction();
                let s = sound_matrix(0.01);
                let outputs = std::array::from_fn(|j| {
                    (s[0][j] * x + s[1][j] * y + s[2][j] * z) * Complex64::new(10.0, 0.0)
                });
                let one = Complex64::new(10.0, 0.0);
                let name = format!("{session}, {configuration:?}, {frequency} Hz");
                let row = PhasorRow::new(name, frequency, configuration, one, outputs);
                rows.push(PhasorRow {
                    session: Some((*session).to_owned()),
                    ..row
                });
            }
        }
    }
    rows
}

/// Relative contribution of an input to |S_xx|.
fn contribution(fit: &Fit, key: &str) -> f64 {
    let result = frequency_result(&fit.frequencies[0]).expect("a matrix");
    let term = &result.sensitivity[0];
    let line = term.budget.iter().find(|l| l.key == key);
    line.map_or(0.0, |l| l.contribution / term.modulus.value)
}

fn with(codes: &str, findings: &[Finding]) -> Option<Finding> {
    findings.iter().find(|f| f.code() == codes).cloned()
}

fn session_gain(acts: Acts, keys: &[Key]) -> Budget {
    budget(Some(ShakerInput::new("session.gain", acts, 0.01, keys)))
}

/// A gain error of a session, drawn anew in each of n sessions with the same runs, is in their mean: u/√n. One of the campaign is in
/// it whole, one of each frequency in each session as one of the session.
#[test]
fn law_an_error_of_the_session_is_averaged_over_the_sessions() {
    let none = SpuriousTable::default();
    let names = ["a", "b", "c"];
    for n in [2, 3] {
        let rows = exact(&names[..n], &[80.0, 160.0]);
        let expected = 0.01 / (n as f64).sqrt();
        for (acts, keys) in [
            (Acts::OutputModulus, &[Key::Session, Key::Channel][..]),
            (Acts::OutputModulus, &[Key::Session]),
            (Acts::ReferenceModulus, &[Key::Session]),
            (Acts::ReferenceModulus, &[Key::Session, Key::Frequency]),
        ] {
            let fit = joint(&rows, &none, &session_gain(acts, keys)).expect("a fit");
            let got = contribution(&fit, "session.gain");
            assert!((got / expected - 1.0).abs() < 1e-6, "{keys:?} {got}");
            // What a session has at all frequencies is common to them.
            let common = fit.shared.expect("a joint fit").len();
            assert_eq!(common > 0, !keys.contains(&Key::Frequency), "{keys:?}");
        }
        let whole = session_gain(Acts::ReferenceModulus, &[]);
        let fit = joint(&rows, &none, &whole).expect("a fit");
        assert!((contribution(&fit, "session.gain") / 0.01 - 1.0).abs() < 1e-6);
    }
}

/// The trials draw it as the law of propagation has it.
#[test]
fn crosscheck_monte_carlo_draws_one_error_per_session() {
    let rows = exact(&["a", "b"], &[160.0]);
    let budget = session_gain(Acts::OutputModulus, &[Key::Session, Key::Channel]);
    let checks = validate(
        ShakerMethod::Joint,
        &rows,
        &SpuriousTable::default(),
        &budget,
        &CheckOptions::default(),
        &mut |_| ControlFlow::Continue(()),
    )
    .expect("trials");
    let xx = &checks[0].components[0];
    // The standard deviation of 10 000 trials is known to 0.7 %; four of those.
    let ratio = xx.monte_carlo.expect("settled") / xx.linear;
    assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
    assert!((xx.linear / (0.01 * 0.01 / 2f64.sqrt()) - 1.0).abs() < 0.02);
}

/// Two sessions halve the variance of what one has whole.
#[test]
fn law_a_plan_has_an_error_for_each_session() {
    let plan: Vec<Configuration> = published_plan().into_iter().step_by(3).collect();
    let twice: Vec<Configuration> = plan.iter().chain(&plan).copied().collect();
    let budget = session_gain(Acts::ReferenceModulus, &[Key::Session]);
    let main = |sessions: &[String]| {
        let expected = Expected {
            budget: &budget,
            spurious: &SpuriousTable::default(),
            sensitivity: &sound_matrix(0.01),
            amplitude: 10.0,
            frequency: 160.0,
            sessions,
        };
        predict(&twice, &expected).map(|p| p[0].relative_real)
    };
    let of = |k: usize| if k < plan.len() { "a" } else { "b" }.to_owned();
    let two: Vec<String> = (0..twice.len()).map(of).collect();
    let (one, two) = (main(&[]).expect("one"), main(&two).expect("two"));
    assert!(((one * one - two * two) / 0.5e-4 - 1.0).abs() < 1e-6);
    assert!(matches!(main(&["a".to_owned()]), Err(Error::Length { .. })));
}

/// Twelve mountings in two sessions.
const TWO: Sessions = Sessions {
    gluings: Gluings::Twelve,
    count: 2,
    split: Split::Mixed,
    change: Change::None,
    declared: None,
};

/// The whole calibration of a simulated campaign: findings, and the share of the main terms and of all reals that it holds.
fn calibrated(sessions: &Sessions, seed: u64) -> (Vec<Finding>, [f64; 2]) {
    let simulated = sessions.campaign(seed);
    let mut campaign = ShakerCampaign::new(runs(&simulated.rows), sessions.budget());
    campaign.methods = vec![ShakerMethod::Joint];
    campaign.corrections = vec![Correction {
        label: "measured".to_owned(),
        table: simulated.spurious.clone(),
    }];
    let calibration = calibrate(&campaign).expect("sound runs");
    let result = &calibration.results[0];
    let (mut main, mut all) = (0, 0);
    for (f, truth) in result.frequencies.iter().zip(&simulated.truth) {
        for (p, q) in f.estimate.quantities().iter().enumerate() {
            let s = truth[p / 6][p / 2 % 3];
            let truth = if p % 2 == 0 { s.re } else { s.im };
            let held = i32::from((q.value - truth).abs() <= q.expanded(0.95));
            all += held;
            if [0, 8, 16].contains(&p) {
                main += held;
            }
        }
    }
    let findings = calibration.findings.iter().chain(&result.findings);
    let n = result.frequencies.len() as f64;
    let share = [f64::from(main) / (3.0 * n), f64::from(all) / (18.0 * n)];
    (findings.cloned().collect(), share)
}

/// 0.3 % and 3 mrad from session to session, declared as that. The three frequencies of a campaign have their session errors in common: of 60
/// campaigns 180 independent intervals of main terms, 95 % ± 1.6 %, four of those; the map has 60 times as many.
#[test]
fn coverage_of_a_declared_change_between_sessions() {
    let sessions = Sessions {
        change: Change::Outputs(0.003),
        declared: Some(0.003),
        ..TWO
    };
    let n = 60;
    let all: Vec<[f64; 2]> = (0..n)
        .map(|k| calibrated(&sessions, 600_000 + k).1)
        .collect();
    let mean = |k: usize| all.iter().map(|a| a[k]).sum::<f64>() / n as f64;
    assert!(mean(0) > 0.885, "{}", mean(0));
    assert!(mean(1) > 0.92, "{}", mean(1));
}

/// Nobody is told anything of sessions that reproduce each other: 20 campaigns, each with 0.1 % of a chance.
#[test]
fn law_healthy_sessions_are_told_nothing() {
    for split in [Split::Mixed, Split::Wedges] {
        for seed in 0..10 {
            let healthy = Sessions { split, ..TWO };
            let (findings, _) = calibrated(&healthy, 610_000 + seed);
            let codes: Vec<&str> = findings.iter().map(Finding::code).collect();
            for code in [
                "sessions-differ",
                "sessions-not-compared",
                "duplicate-configuration",
            ] {
                assert!(!codes.contains(&code), "{codes:?}");
            }
        }
    }
}

/// A step of 1 % of output y is told with its size, and enters U although nobody declared it.
#[test]
fn known_step_between_two_sessions_is_named() {
    let stepped = Sessions {
        gluings: Gluings::Published,
        change: Change::Step(0.01),
        ..TWO
    };
    let (findings, _) = calibrated(&stepped, 620_000);
    let told = findings.iter().find(|f| f.code() == "sessions-differ");
    let told = told.expect("named");
    assert_eq!(told.severity(), Severity::Decision);
    assert!(told.evidence_text().contains("output y"), "{told}");
    for accused in [
        "wrong-gain",
        "outlier-configuration",
        "gain-drift",
        "runs-set-aside",
    ] {
        assert!(with(accused, &findings).is_none(), "{accused}");
    }
    let (fit, simulated) = stepped.fit(620_000);
    let told = fit.reproducibility.as_ref().expect("two sessions");
    assert!(told.differs() && told.p_value < 1e-6, "{told:?}");
    for gain in &told.gains {
        let sign = if gain.session == "day 2" { 1.0 } else { -1.0 };
        let step = if gain.output == 1 { 0.005 * sign } else { 0.0 };
        assert!(
            (gain.modulus - step).abs() < 4.0 * gain.u_modulus,
            "{gain:?}"
        );
    }
    // 0, 1 % and 0 between two sessions: a standard deviation of 1 %/√2/√3 from session to session.
    let size = told.between[0].standard_uncertainty;
    assert!((0.002..0.008).contains(&size), "{size}");
    let line = contribution(&fit, "session.reproducibility");
    assert!(
        (line / (size / 2f64.sqrt()) - 1.0).abs() < 0.1,
        "{line} {size}"
    );
    // The mean of the sessions is 0.5 % off in y, and U reaches the truth.
    let [main, ..] = holding(&fit, &simulated);
    assert!(main > 0.99, "{main}");
}

/// A difference that the budget declares is none.
#[test]
fn law_what_is_declared_is_not_told() {
    let stepped = |declared| Sessions {
        gluings: Gluings::Published,
        change: Change::Step(0.01),
        declared,
        ..TWO
    };
    let told = |declared| differ(&stepped(declared).fit(630_001).0);
    assert!(told(None) && !told(Some(0.007)));
    // Declared far too small it is told.
    assert!(told(Some(0.0005)));
    // Half of what it is: U has what the runs tell.
    let (fit, _) = stepped(Some(0.002)).fit(630_001);
    let enlarged = fit.components.iter().find(|c| c.key == "session.gain");
    assert!(enlarged.expect("told by the runs").used > 1.5);
}

/// Sessions that nothing compares have a word, and no test.
#[test]
fn refuses_to_compare_what_the_runs_do_not_tell() {
    let none = SpuriousTable::default();
    let of = |rows: &[PhasorRow]| joint(rows, &none, &budget(None)).expect("a fit");
    let word = |fit: &Fit| {
        let said = fit
            .findings
            .iter()
            .find(|f| f.code() == "sessions-not-compared");
        said.cloned().expect("a word")
    };
    // All of one session.
    let one = of(&exact(&["a"], &[80.0, 160.0]));
    assert!(one.reproducibility.is_none());
    assert_eq!(word(&one).severity(), Severity::Note);
    assert!(word(&one).what().contains("one session"));
    // A session of one run, 5 % off: it is compared with none, and the others are.
    let mut rows = exact(&["a", "b"], &[80.0]);
    let mut stray = rows[3].clone();
    stray.session = Some("c".to_owned());
    stray.outputs = stray.outputs.map(|o| o * 1.05);
    rows.push(stray);
    let fit = of(&rows);
    assert!(word(&fit).what().contains("session c"), "{}", word(&fit));
    assert!(word(&fit).evidence_text().contains("one run"));
    assert!(!differ(&fit), "{:?}", fit.findings);
    assert_eq!(fit.reproducibility.expect("a and b").gains.len(), 6);
    // Each frequency in a session of its own.
    let mut rows = exact(&["a"], &[80.0]);
    rows.extend(exact(&["b"], &[160.0]));
    let fit = of(&rows);
    assert_eq!(word(&fit).severity(), Severity::Warning);
    assert!(
        fit.reproducibility
            .as_ref()
            .is_some_and(|r| r.gains.is_empty())
    );
    // Sessions that a third one ties together are compared.
    rows.extend(exact(&["c"], &[80.0, 160.0]));
    let told = of(&rows).reproducibility.expect("three");
    assert!(told.uncompared.is_empty() && told.gains.len() == 9);
    assert!(
        told.gains
            .iter()
            .all(|g| g.modulus.abs() < 1e-9 && g.u_modulus > 1e-5)
    );
}

#[test]
fn refuses_an_input_of_the_session_where_runs_name_none() {
    let mut rows = exact(&["a", "b"], &[80.0]);
    rows[5].session = None;
    let budget = session_gain(Acts::OutputModulus, &[Key::Session]);
    let error = joint(&rows, &SpuriousTable::default(), &budget).expect_err("one has none");
    assert!(matches!(error, Error::TooFew { got: 29, .. }), "{error}");
    assert!(error.to_string().contains("session"), "{error}");
}
