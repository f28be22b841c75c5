//! What is filed is found again, forward and backward.

use crate::places::{each, make};
use crate::recorded::*;
use proofmass_records::*;
use proofmass_static::static_test::RecalibrationRule;

#[test]
fn law_a_result_folder_is_filed_once_and_computed_again_to_the_byte() {
    each(|place, folder| {
        let campaign = campaign(folder);
        let mut records = make(place);
        let filing = Filing::default();
        let filing = Filing {
            largest: 100.0,
            ..filing
        };
        let filed = records
            .add_result(&campaign.join("result"), &filing, TODAY)
            .unwrap();
        assert!(!filed.known);
        assert_eq!(codes(&filed), ["standard-not-named"]);
        let again = records
            .add_result(&campaign.join("result/result.json"), &filing, TODAY)
            .unwrap();
        assert!(again.known);
        assert_eq!(again.number, filed.number);
        assert_eq!(records.recompute(filed.number).unwrap(), Recomputed::Same);
        let rests = records.rests_on(filed.number).unwrap();
        let names: Vec<&str> = rests
            .iter()
            .map(|r| r.name.rsplit('/').next().unwrap())
            .collect();
        assert_eq!(names, ["campaign.toml", "reference.csv", "runs.csv"]);
        assert!(rests.iter().all(|r| r.kept && r.sha256.len() == 64));
        let check = records.check().unwrap();
        assert!(check.is_whole(), "{:?}", check.damage);
        assert!(check.files >= 7 && check.entries == 2);
        // The reference is in the budget of every quantity.
        let Content::Result(result) = records.entry(filed.number).unwrap().content else {
            panic!()
        };
        let q = &result.quantities[0];
        let share = q.u_standard.unwrap() / q.value;
        assert!((share - 0.0025).abs() < 1e-5, "U = 0.5 %, k = 2: {share}");
    });
}

#[test]
fn law_a_certificate_is_found_by_the_digest_of_its_file() {
    each(|place, folder| {
        let campaign = campaign(folder);
        let mut records = make(place);
        let standard = standard(&mut records, "R-7");
        let bytes = std::fs::read(campaign.join("reference.csv")).unwrap();
        let file = records.keep_file("reference.csv", &bytes).unwrap();
        let filed = FiledCertificate {
            standard,
            number: "C 1".into(),
            laboratory: None,
            valid_from: "2024-01-01".into(),
            valid_until: Some("2026-01-01".into()),
            u_relative: Some(0.0025),
            file: Some(file),
            ..Default::default()
        };
        records
            .add(TODAY, None, Content::Certificate(filed))
            .unwrap();
        let filed = records.add_result(&campaign, &filing(), TODAY);
        assert!(filed.is_err(), "a campaign is no result");
        let filed = records
            .add_result(&campaign.join("result"), &filing(), TODAY)
            .unwrap();
        assert_eq!(codes(&filed), ["certificate-not-valid"]);
        let recall = records
            .recall(standard, day_of("2026-06-01").unwrap(), None, Some(0.01))
            .unwrap();
        assert_eq!(recall.results.len(), 1);
        let effect = &recall.results[0].effects[0];
        assert!(
            (effect.effect / 0.01 / -0.01 - 1.0).abs() < 0.01,
            "one per cent of 10 mV/(m/s²), too small: {effect:?}"
        );
        // A relative error turns no phase.
        assert_eq!(recall.results[0].effects.len(), 7);
        let rests = records.rests_on(filed.number).unwrap();
        assert!(
            rests
                .iter()
                .any(|r| r.name.starts_with("certificate C 1 of maker A1 R-7"))
        );
    });
}

#[test]
fn law_a_result_is_superseded_and_never_changed() {
    each(|place, _| {
        let mut records = make(place);
        let first = file(
            &mut records,
            &candidate("1", "2026-01-01", 1.0, 0.01, 0.005),
            None,
        );
        let before = records.entries(1).unwrap();
        let filing = Filing {
            supersedes: Some(first.number),
            reason: Some("wrong cable".into()),
            ..Default::default()
        };
        let second = records
            .file_candidate(
                &candidate("1", "2026-01-01", 1.1, 0.01, 0.005),
                &filing,
                TODAY,
            )
            .unwrap();
        assert_eq!(records.entries(1).unwrap()[..before.len()], before);
        assert_eq!(
            records.superseded(first.number).unwrap(),
            Some((Some(second.number), "wrong cable".into()))
        );
        let device = records.device("1").unwrap();
        assert_eq!(records.results_of(device).unwrap(), [second.number]);
        let twice = records.add(
            TODAY,
            None,
            Content::Supersession(FiledSupersession {
                old: first.number,
                new: None,
                reason: "again".into(),
            }),
        );
        assert!(
            twice
                .unwrap_err()
                .to_string()
                .contains("superseded already")
        );
        assert!(records.check().unwrap().is_whole());
    });
}

#[test]
fn law_history_drift_jump_and_due() {
    each(|place, _| {
        let mut records = make(place);
        let standard = standard(&mut records, "R");
        certificate(
            &mut records,
            standard,
            "C",
            ["2000-01-01", "2030-01-01"],
            0.005,
        );
        let noise = [0.3, -0.8, 0.5, 0.1, -0.4, 0.9, -0.6, 0.2, 0.4, -0.7];
        for (k, e) in noise.iter().enumerate() {
            let jump = if k < 6 { 0.0 } else { 0.1 };
            let value = 1.0 + 0.001 * e + 0.002 * k as f64 + jump;
            file(
                &mut records,
                &candidate("7", &format!("{}-03-01", 2010 + k), value, 0.0051, 0.005),
                Some("R"),
            );
        }
        let device = records.device("7").unwrap();
        let history = records.history(device).unwrap();
        assert_eq!(history.len(), 1);
        let found = &history[0];
        let jump = found.jump.as_ref().unwrap();
        assert_eq!(
            [jump.after, jump.before].map(|d| date_of(d as i64)),
            ["2015-03-01", "2016-03-01"]
        );
        assert!((jump.height - 0.1).abs() < 3.0 * jump.standard_uncertainty);
        assert_eq!(found.findings[0].code(), "calibration-jump");
        // After an adjustment the history counts anew.
        let event = FiledEvent {
            device,
            date: "2015-06-01".into(),
            event: EventKind::Adjustment,
            text: "gain".into(),
        };
        records.add(TODAY, None, Content::Event(event)).unwrap();
        let found = records.history(device).unwrap().remove(0);
        assert!(found.jump.is_none());
        let drift = found.drift.unwrap();
        assert!((drift.drift.value - 0.002 / 12.0).abs() < 3.0 * drift.drift.standard_uncertainty);
        // Rules: of all, then its own.
        let rule = |device, rule| {
            Content::Rule(FiledRule {
                device,
                rule,
                tolerances: vec![Tolerance {
                    quantity: "S.modulus".into(),
                    change: Some(0.02),
                    limits: None,
                }],
            })
        };
        records
            .add(
                TODAY,
                None,
                rule(None, RecalibrationRule::Fixed { months: 12.0 }),
            )
            .unwrap();
        let due = records.due_of(device).unwrap().unwrap();
        assert_eq!(date_of(due.day), "2020-02-29");
        records
            .add(
                TODAY,
                None,
                rule(Some(device), RecalibrationRule::Drift { longest: 60.0 }),
            )
            .unwrap();
        let by_drift = records.due_of(device).unwrap().unwrap();
        assert!(
            by_drift.evidence.contains("drift against tolerance"),
            "{by_drift:?}"
        );
        assert!(by_drift.day > due.day - 365 && by_drift.day < due.day + 4 * 365);
        let listed = |records: &mut Records, until| -> Vec<i64> {
            let due = records.due(until).unwrap();
            due.into_iter().map(|d| d.device).collect()
        };
        assert!(listed(&mut records, by_drift.day).contains(&device));
        assert!(by_drift.is_over(by_drift.day + 1));
        let withdrawn = FiledEvent {
            device,
            date: "2020-01-01".into(),
            event: EventKind::Withdrawal,
            text: String::new(),
        };
        records.add(TODAY, None, Content::Event(withdrawn)).unwrap();
        // The standard is due where its certificate ends, by the rule of all sooner.
        assert_eq!(listed(&mut records, i64::MAX / 4), [standard]);
        assert!(records.check().unwrap().is_whole());
    });
}

#[test]
fn law_a_recall_goes_through_results_that_were_references() {
    each(|place, _| {
        let mut records = make(place);
        let standard = standard(&mut records, "R");
        certificate(
            &mut records,
            standard,
            "C",
            ["2025-01-01", "2027-01-01"],
            0.005,
        );
        let mut working = candidate("W", "2026-01-05", 1.0, 0.01, 0.005);
        working.files = vec![("calibration.json".into(), b"the calibration of W".to_vec())];
        let first = file(&mut records, &working, Some("R"));
        let mut further = candidate("9", "2026-02-05", 1.0, 0.012, 0.01);
        let digest = match records.entry(first.number).unwrap().content {
            Content::Result(result) => result.files[0].sha256.clone(),
            _ => panic!(),
        };
        further.inputs = vec![("w.json".into(), digest, None)];
        let second = file(&mut records, &further, None);
        file(
            &mut records,
            &candidate("10", "2026-02-06", 1.0, 0.01, 0.005),
            None,
        );
        let recall = records
            .recall(standard, day_of("2026-06-01").unwrap(), None, Some(0.02))
            .unwrap();
        let numbers: Vec<i64> = recall.results.iter().map(|r| r.result).collect();
        assert_eq!(numbers, [first.number, second.number]);
        assert_eq!(recall.results[1].through, [first.number]);
        // The error of the standard is that of the working standard, and of what was calibrated against it.
        for result in &recall.results {
            let effect = &result.effects[0];
            assert!((effect.effect + 0.02).abs() < 1e-12, "{effect:?}");
            assert!((effect.relative.unwrap() + 0.02).abs() < 1e-12 && !effect.at_most);
        }
        assert!(recall.since.starts_with("its certificate"));
        // A good check in between leaves out what was before.
        let check = |date: &str, value: f64| {
            let what = ("S.modulus".into(), "mV/(m/s²)".into());
            let [measured, known] = [value, 1.0].map(|v| [1e3 * v, 1.0]);
            Content::Check(
                FiledCheck::measured(standard, date.into(), what, measured, known).unwrap(),
            )
        };
        records
            .add(TODAY, None, check("2026-02-01", 1.001))
            .unwrap();
        records.add(TODAY, None, check("2026-05-01", 1.1)).unwrap();
        let recall = records
            .recall(standard, day_of("2026-06-01").unwrap(), None, None)
            .unwrap();
        assert_eq!(recall.results.len(), 0, "{recall:?}");
        assert_eq!(date_of(recall.days[0]), "2026-02-01");
        // Put right again, the time in question is that between the two good checks.
        let wrong = file(
            &mut records,
            &candidate("12", "2026-03-01", 1.0, 0.01, 0.005),
            Some("R"),
        );
        records
            .add(TODAY, None, check("2026-05-10", 1.001))
            .unwrap();
        let recall = records
            .recall(standard, day_of("2026-06-01").unwrap(), None, None)
            .unwrap();
        let numbers: Vec<i64> = recall.results.iter().map(|r| r.result).collect();
        assert_eq!(numbers, [wrong.number]);
        assert_eq!(recall.days.map(date_of), ["2026-02-01", "2026-05-10"]);
        assert!(
            recall.since.contains("failed on 2026-05-01"),
            "{}",
            recall.since
        );
        records.add(TODAY, None, check("2026-05-12", 1.1)).unwrap();
        let late = file(
            &mut records,
            &candidate("11", "2026-05-20", 1.0, 0.01, 0.005),
            Some("R"),
        );
        assert_eq!(codes(&late), ["standard-in-question"]);
        let recall = records
            .recall(standard, day_of("2026-06-01").unwrap(), None, None)
            .unwrap();
        let numbers: Vec<i64> = recall.results.iter().map(|r| r.result).collect();
        assert_eq!(numbers, [late.number]);
        assert!(
            records
                .recall(
                    standard,
                    day_of("2026-01-01").unwrap(),
                    day_of("2026-06-01").ok(),
                    None
                )
                .is_err()
        );
    });
}

#[test]
fn law_an_export_becomes_the_same_records() {
    each(|place, folder| {
        let campaign = campaign(folder);
        let mut records = make(place);
        records
            .add_result(
                &campaign.join("result"),
                &Filing {
                    largest: 1.0,
                    by: Some("Ada".into()),
                    ..Default::default()
                },
                TODAY,
            )
            .unwrap();
        let out = proofmass_io::OutputFolder::create(folder.join("out"), false).unwrap();
        records.export_folder(&out).unwrap();
        out.commit().unwrap();
        let other = folder.join("other.records");
        let mut copy = make(other.to_str().unwrap());
        assert_eq!(copy.import_folder(&folder.join("out")).unwrap(), 2);
        let (a, b) = (records.check().unwrap(), copy.check().unwrap());
        assert_eq!(a, b);
        assert!(b.is_whole(), "{:?}", b.damage);
        assert_eq!(copy.export_json().unwrap(), records.export_json().unwrap());
        assert!(
            copy.import_folder(&folder.join("out"))
                .unwrap_err()
                .to_string()
                .contains("not empty")
        );
        // A name is removed, and the chain holds.
        let by = copy.entries(1).unwrap()[1].1.by.clone().unwrap();
        assert_eq!(copy.person(&by).unwrap().as_deref(), Some("Ada"));
        copy.forget("Ada").unwrap();
        assert_eq!(copy.person(&by).unwrap(), None);
        assert!(copy.check().unwrap().is_whole());
        let tables = proofmass_jobs::Gathered::default();
        records.export_csv(&tables).unwrap();
        let tables = tables.into_memory();
        for name in ["devices.csv", "results.csv", "quantities.csv"] {
            assert!(proofmass_jobs::Store::holds(&tables, name));
        }
        // Parquet has the same numbers, which our own reader of recordings reads.
        let tables = proofmass_jobs::Gathered::default();
        records.export_parquet(&tables).unwrap();
        let tables = tables.into_memory();
        let bytes = |name: &str| {
            let source = proofmass_jobs::Store::open(&tables, name).unwrap();
            source.into_bytes(1 << 20).unwrap().0
        };
        for name in [
            "devices",
            "certificates",
            "results",
            "used",
            "checks",
            "events",
        ] {
            assert!(
                bytes(&format!("{name}.parquet")).starts_with(b"PAR1"),
                "{name}"
            );
        }
        assert!(bytes("quantities.parquet").ends_with(b"PAR1"));
    });
}

#[test]
fn law_a_spreadsheet_of_old_calibrations_is_filed_once() {
    each(|place, _| {
        let mut records = make(place);
        let text = "serial,model,date,number,frequency_Hz,sensitivity_mV/g,U_relative_%,k\n\
                    5,A1,2019-04-01,K1,160,98.0665,1,2\n5,A1,2019-04-01,K1,80,98.0665,,\n6,A1,2020-04-01,K1,160,100,1,2\n";
        let source = || proofmass_io::Source::from_bytes("old.csv", text.as_bytes()).unwrap();
        let filed = records.add_spreadsheet(source(), None, TODAY).unwrap();
        assert_eq!(filed.len(), 2);
        assert_eq!(
            codes(&filed[0]),
            ["standard-not-named", "uncertainty-not-stated"]
        );
        assert_eq!(codes(&filed[1]), ["standard-not-named", "number-taken"]);
        assert!(
            records
                .add_spreadsheet(source(), None, TODAY)
                .unwrap()
                .iter()
                .all(|f| f.known)
        );
        let Content::Result(result) = records.entry(filed[0].number).unwrap().content else {
            panic!()
        };
        let q = &result.quantities[0];
        assert_eq!(
            (q.name.as_str(), q.unit.as_str()),
            ("S.modulus[frequency=160]", "V/(m/s²)")
        );
        assert!((q.value - 0.01).abs() < 1e-12 && (q.u.unwrap() - 0.00005).abs() < 1e-12);
        assert_eq!(result.quantities[1].u, None);
        let other = "serial,date,quantity,value,unit,u\n7,2020-01-01,bias.x,0.1,m/s²,0.01\n";
        let source = proofmass_io::Source::from_bytes("other.csv", other.as_bytes()).unwrap();
        assert_eq!(
            records.add_spreadsheet(source, None, TODAY).unwrap().len(),
            1
        );
    });
}

#[test]
fn law_tolerances_are_judged_when_a_result_is_filed() {
    each(|place, _| {
        let mut records = make(place);
        file(
            &mut records,
            &candidate("1", "2025-01-01", 1.0, 0.01, 0.005),
            None,
        );
        let rule = FiledRule {
            device: None,
            rule: RecalibrationRule::Fixed { months: 12.0 },
            tolerances: vec![Tolerance {
                quantity: "S.modulus".into(),
                change: None,
                limits: Some([0.95, 1.05]),
            }],
        };
        records.add(TODAY, None, Content::Rule(rule)).unwrap();
        let good = file(
            &mut records,
            &candidate("1", "2025-02-01", 1.02, 0.01, 0.005),
            None,
        );
        assert_eq!(codes(&good), ["standard-not-named"]);
        let bad = file(
            &mut records,
            &candidate("1", "2026-05-01", 1.04, 0.01, 0.005),
            None,
        );
        assert_eq!(
            codes(&bad),
            ["standard-not-named", "device-overdue", "tolerance-not-kept"]
        );
    });
}
