//! Findings of this room: each fault of a run or of a whole campaign is told by its name; sound campaigns are told nothing
//! (`law_sound_campaigns_are_told_nothing`).

use num_complex::Complex64;
use proofmass_shaker::{
    Acts, Configuration, PhasorRow, ShakerCampaign, ShakerMethod, calibrate, diagnose, joint,
    observations,
};
use proofmass_uncertainty::Finding;

#[path = "../examples/shaker_faults.rs"]
#[allow(dead_code, reason = "its printed table")]
mod shaker_faults;

use shaker_faults::shaker_coverage::Simulated;
use shaker_faults::{Fault, THROUGHOUT, certificate, codes, runs, throughout, usual};

fn insist(code: &str, found: &[String]) {
    assert!(found.iter().any(|c| c == code), "{code}: {found:?}");
}

fn spare(code: &str, found: &[String]) {
    assert!(!found.iter().any(|c| c == code), "{code}: {found:?}");
}

fn named(found: &[Finding]) -> Vec<String> {
    found.iter().map(|f| f.code().to_owned()).collect()
}

/// Three frequencies of 44 runs each.
fn campaign(seed: u64) -> Simulated {
    usual().campaign(&[10.0, 160.0, 1000.0], seed)
}

/// What is said of a campaign with one struck run.
fn struck(strike: impl Fn(&mut [PhasorRow], usize)) -> Vec<String> {
    let mut simulated = campaign(70_100);
    strike(&mut simulated.rows, 44 + 20);
    let (rows, spurious) = (&simulated.rows, &simulated.spurious);
    let (_, findings) = diagnose(rows, spurious, &usual().budget(), None).expect("a diagnosis");
    named(&findings)
}

#[test]
fn law_a_fault_of_one_run_has_its_code() {
    insist(
        "wrong-gain",
        &struck(|rows, k| Fault::OneGain.strike(rows, k)),
    );
    insist(
        "wrong-configuration",
        &struck(|rows, k| Fault::Wedge.strike(rows, k)),
    );
    insist(
        "wrong-frequency",
        &struck(|rows, k| Fault::Frequency.strike(rows, k)),
    );
    insist(
        "copied-run",
        &struck(|rows, k| Fault::Copied.strike(rows, k)),
    );
    insist(
        "dead-channel",
        &struck(|rows, k| Fault::Dead.strike(rows, k)),
    );
    // What no single cause makes.
    insist(
        "outlier-configuration",
        &struck(|rows, k| {
            rows[k].outputs[0] *= Complex64::from_polar(1.3, 0.4);
            rows[k].outputs[1] *= Complex64::from_polar(0.8, -0.7);
            rows[k].outputs[2] *= Complex64::from_polar(1.1, 0.9);
        }),
    );
}

#[test]
fn law_a_fault_of_the_whole_campaign_is_named() {
    let mut told = vec![];
    for (k, (name, code)) in THROUGHOUT.iter().enumerate() {
        let codes = throughout(k, 80_100);
        assert!(codes.iter().any(|c| c == code), "{name}: {codes:?}");
        for accused in ["outlier-configuration", "wrong-configuration", "wrong-gain"] {
            spare(accused, &codes);
        }
        told.extend(codes);
    }
    insist("phases-conjugated", &told);
    insist("angle-sense", &told);
    insist("spurious-sign", &told);
    insist("reference-inverted", &told);
    insist("mask-offset", &told);
    insist("gain-drift", &told);
    // The rotation template half a turn off: x and y are inverted together.
    let Simulated {
        mut rows, spurious, ..
    } = campaign(80_101);
    for row in &mut rows {
        row.outputs[0] = -row.outputs[0];
        row.outputs[1] = -row.outputs[1];
    }
    insist("mask-reversed", &codes(&usual(), rows, spurious));
}

#[test]
fn law_a_certificate_off_at_one_frequency_is_named() {
    spare("certificate-off", &named(&certificate(None, 90_100)));
    for (place, hertz) in [(0, "5 Hz"), (3, "40 Hz"), (5, "160 Hz")] {
        let told = certificate(Some(place), 90_100);
        let said = told.iter().find(|f| f.code() == "certificate-off");
        let said = said.expect("named").what();
        assert!(said.ends_with(&format!("at {hertz}")), "{said}");
    }
}

#[test]
fn known_angles_that_were_declared_too_large() {
    let simulated = campaign(5);
    let with = |factor: f64| {
        let mut budget = usual().budget();
        for input in budget
            .inputs
            .iter_mut()
            .filter(|i| i.acts == Acts::Rotation)
        {
            let declared = proofmass_shaker::ShakerInput::new(
                &input.key,
                input.acts,
                factor * input.standard_uncertainty(),
                &input.varies_with,
            );
            *input = declared;
        }
        named(
            &joint(&simulated.rows, &simulated.spurious, &budget)
                .expect("a fit")
                .findings,
        )
    };
    insist("angle-prior-too-large", &with(5.0));
    spare("angle-prior-too-large", &with(1.0));
}

#[test]
fn known_plan_and_runs_that_differ() {
    let simulated = campaign(6);
    let mut plan: Vec<Configuration> = vec![];
    for row in &simulated.rows {
        if !plan.iter().any(|c| c.same_as(&row.configuration)) {
            plan.push(row.configuration);
        }
    }
    let against = |plan: &[Configuration]| {
        let (rows, spurious) = (&simulated.rows, &simulated.spurious);
        named(
            &diagnose(rows, spurious, &usual().budget(), Some(plan))
                .expect("a diagnosis")
                .1,
        )
    };
    spare("unplanned-configuration", &against(&plan));
    insist("unplanned-configuration", &against(&plan[1..]));
}

/// A stiff device on adhesive up to 1500 Hz, where it is 8 % more sensitive; one run is left out by name.
#[test]
fn known_high_frequencies_and_choices_that_are_told() {
    let calibrated = |rise: f64, highest: f64, excluded: bool| {
        let mut simulated = usual().campaign(&[10.0, 160.0, highest], 7);
        for row in simulated.rows.iter_mut().filter(|r| r.frequency == highest) {
            row.outputs = row.outputs.map(|o| o * rise);
        }
        let mut campaign = ShakerCampaign::new(runs(&simulated.rows), usual().budget());
        campaign.methods = vec![ShakerMethod::Joint];
        if excluded {
            campaign.methods.push(ShakerMethod::PublishedMagnitude);
            campaign.excluded = vec![campaign.runs[3].run.clone()];
        }
        let calibration = calibrate(&campaign).expect("a calibration");
        let own = calibration.results.into_iter().flat_map(|r| r.findings);
        let all: Vec<Finding> = calibration.findings.into_iter().chain(own).collect();
        named(&all)
    };
    let told = calibrated(1.08, 1500.0, true);
    insist("resonance-onset", &told);
    insist("adhesive-mounting", &told);
    insist("published-method", &told);
    insist("excluded-run", &told);
    let plain = calibrated(1.0, 200.0, false);
    for code in [
        "resonance-onset",
        "adhesive-mounting",
        "published-method",
        "excluded-run",
    ] {
        spare(code, &plain);
    }
}

/// 50 Hz is the mains, and nothing tells whether there is any.
#[test]
fn known_drive_on_the_mains() {
    let of = |frequency: f64| {
        let simulated = usual().campaign(&[frequency], 8);
        let mut all = runs(&simulated.rows);
        for run in &mut all {
            run.quality.resolution = Some(0.5);
        }
        let campaign = ShakerCampaign::new(all, usual().budget());
        named(&observations(&campaign).expect("observations").findings)
    };
    insist("drive-at-mains", &of(50.0));
    spare("drive-at-mains", &of(80.0));
}

/// A tilt of ±0.1° that nobody declared.
#[test]
fn known_angle_that_the_budget_leaves_out() {
    let told = |name: &str| {
        let mut cases = shaker_faults::shaker_coverage::CASES.iter();
        let case = cases.find(|c| c.name == name).expect("a case of the table");
        let simulated = case.campaign(&[10.0, 160.0, 1000.0], 9);
        let fit = joint(&simulated.rows, &simulated.spurious, &case.budget()).expect("a fit");
        let grave = |f: &&Finding| f.severity() == proofmass_uncertainty::Severity::Decision;
        fit.findings
            .iter()
            .filter(grave)
            .map(|f| f.code().to_owned())
            .collect::<Vec<_>>()
    };
    insist("missing-input", &told("tilt ±0.1° undeclared"));
    spare("missing-input", &told("tilt ±0.1°"));
}

/// Zero of the marks ±1° and gain ±0.5 % of every wedge: of 300 campaigns 66 % and 98 % are told; each seed here is one of them or not,
/// and fewer than three of ten happen once in two thousand.
#[test]
fn known_errors_that_the_runs_on_a_wedge_share() {
    let told = |name: &str| {
        let mut cases = shaker_faults::shaker_coverage::CASES.iter();
        let case = cases.find(|c| c.name == name).expect("a case of the table");
        let seen = |seed: &u64| {
            let simulated = case.campaign(&[10.0, 160.0, 1000.0], *seed);
            let fit = joint(&simulated.rows, &simulated.spurious, &case.budget()).expect("a fit");
            let shared = |f: &Finding| {
                f.code() == "missing-input"
                    && f.severity() != proofmass_uncertainty::Severity::Note
                    && f.evidence_text().contains("per wedge")
            };
            fit.findings.iter().any(shared)
        };
        (0..10).filter(seen).count()
    };
    assert!(told("marks ±1° undeclared") >= 3);
    assert!(told("gain ±0.5 % undeclared") >= 7);
    for declared in ["marks ±1° of wedges", "gain ±0.5 % of wedges"] {
        assert_eq!(told(declared), 0, "{declared}");
    }
}
