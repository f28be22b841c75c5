//! What is filed late, wrong, or against what is here.

use crate::places::{each, make};
use crate::recorded::*;
use proofmass_records::*;
use proofmass_static::static_test::RecalibrationRule;

fn codes_of(filed: &Filed) -> Vec<&str> {
    filed.findings.iter().map(|f| f.code()).collect()
}

fn certified(records: &mut Records, standard: i64, from: &str, file: &FiledFile) -> Filed {
    let certificate = FiledCertificate {
        standard,
        number: format!("C {from}"),
        valid_from: from.into(),
        valid_until: Some("2026-12-31".into()),
        u_relative: Some(0.0025),
        file: Some(file.clone()),
        ..Default::default()
    };
    records
        .file_content(TODAY, None, Content::Certificate(certificate))
        .unwrap()
}

#[test]
fn law_a_certificate_that_is_filed_late_is_found_behind_its_results() {
    each(|place, folder| {
        let campaign = campaign(folder);
        let mut records = make(place);
        let r = standard(&mut records, "R-7");
        let result = records
            .add_result(&campaign.join("result"), &filing(), TODAY)
            .unwrap();
        let named = file(
            &mut records,
            &candidate("1", "2026-04-01", 1.0, 0.01, 0.0025),
            Some("R-7"),
        );
        let before = day_of(TODAY).unwrap();
        let recall = |records: &mut Records| -> Vec<i64> {
            let since = day_of("2026-01-01").ok();
            let recall = records.recall(r, before, since, Some(0.01)).unwrap();
            assert!(
                recall.results.iter().all(|r| r.undetermined.is_none()),
                "{recall:?}"
            );
            recall.results.iter().map(|r| r.result).collect()
        };
        let bytes = std::fs::read(campaign.join("reference.csv")).unwrap();
        let table = records.keep_file("reference.csv", &bytes).unwrap();
        let filed = certified(&mut records, r, "2026-01-01", &table);
        assert!(filed.findings.is_empty());
        assert_eq!(recall(&mut records), [named.number, result.number]);
        // One that was not valid yet is told.
        let s = standard(&mut records, "R-8");
        let again = certified(&mut records, r, "2026-05-20", &table);
        assert_eq!(codes_of(&again), ["certificate-not-valid"]);
        let stolen = FiledCertificate {
            standard: s,
            number: "C 2".into(),
            valid_from: "2026-01-01".into(),
            file: Some(table),
            ..Default::default()
        };
        let refused = records.add(TODAY, None, Content::Certificate(stolen));
        assert!(
            refused
                .unwrap_err()
                .to_string()
                .contains("another standard")
        );
        assert!(records.check().unwrap().is_whole());
    });
}

#[test]
fn law_a_table_of_a_certificate_says_its_uncertainty() {
    let table =
        "frequency_Hz,sensitivity_mV/(m/s2),U_relative_%\n80,10,0.5\n160,10,0.5\n320,10,0.8\n";
    let read = |u: Option<f64>| {
        let certificate = FiledCertificate {
            u_relative: u,
            ..Default::default()
        };
        let read = certificate.reading("reference.csv", table.as_bytes(), &device("R"));
        read.map(|(certificate, _)| certificate)
    };
    let certificate = read(None).unwrap();
    assert_eq!(certificate.u_relative, None, "it depends on the frequency");
    assert_eq!(
        certificate.u_at,
        [[80.0, 0.0025], [160.0, 0.0025], [320.0, 0.004]]
    );
    assert_eq!(read(Some(0.003)).unwrap().u_relative, Some(0.003));
    let refused = read(Some(0.01)).unwrap_err().to_string();
    assert!(refused.contains("0.500 to 0.800 %"), "{refused}");
    let page = FiledCertificate::default()
        .reading("certificate.pdf", b"%PDF", &device("R"))
        .unwrap()
        .0;
    assert!(page.u_at.is_empty());
    assert!(
        FiledCertificate::default()
            .reading("other.csv", b"a,b\n1,2\n", &device("R"))
            .is_err()
    );
}

#[test]
fn law_what_rests_on_a_superseded_result_is_told() {
    each(|place, _| {
        let mut records = make(place);
        let mut working = candidate("W", "2026-01-05", 1.0, 0.01, 0.005);
        working.files = vec![("calibration.json".into(), b"the calibration of W".to_vec())];
        let first = file(&mut records, &working, None);
        let Content::Result(filed) = records.entry(first.number).unwrap().content else {
            panic!()
        };
        let mut further = candidate("9", "2026-02-05", 1.0, 0.01, 0.005);
        further.inputs = vec![("w.json".into(), filed.files[0].sha256.clone(), None)];
        let second = file(&mut records, &further, None);
        assert!(!codes(&second).contains(&"input-superseded".to_owned()));
        let superseded = Content::Supersession(FiledSupersession {
            old: first.number,
            new: None,
            reason: "loose cable".into(),
        });
        let told = records.file_content(TODAY, None, superseded).unwrap();
        assert_eq!(codes_of(&told), ["rests-on-superseded"]);
        further.sha256 = "evaluated again".into();
        further.date = "2026-03-05".into();
        let late = file(&mut records, &further, None);
        assert_eq!(codes(&late), ["input-superseded", "standard-not-named"]);
    });
}

#[test]
fn refuses_what_contradicts_what_is_here() {
    each(|place, _| {
        let mut records = make(place);
        let one = file(
            &mut records,
            &candidate("1", "2026-01-01", 1.0, 0.01, 0.005),
            None,
        );
        let two = file(
            &mut records,
            &candidate("2", "2026-01-01", 1.0, 0.01, 0.005),
            None,
        );
        let (device, other) = (records.device("1").unwrap(), records.device("2").unwrap());
        let r = standard(&mut records, "R");
        let before = records.entries(1).unwrap().len();
        let check = |unit: &str, date: &str| {
            let what = ("S.modulus".into(), unit.into());
            Content::Check(
                FiledCheck::measured(device, date.into(), what, [1.0, 0.1], [1.0, 0.1]).unwrap(),
            )
        };
        let event = FiledEvent {
            device,
            date: "2026-06-02".into(),
            event: EventKind::Drop,
            text: String::new(),
        };
        let rule = FiledRule {
            device: Some(device),
            rule: RecalibrationRule::default(),
            tolerances: vec![Tolerance {
                quantity: "S.modulos".into(),
                change: Some(0.1),
                limits: None,
            }],
        };
        let supersession = |old, new, reason: &str| {
            Content::Supersession(FiledSupersession {
                old,
                new,
                reason: reason.into(),
            })
        };
        let backwards = FiledCertificate {
            standard: r,
            number: "C".into(),
            valid_from: "2026-01-01".into(),
            valid_until: Some("2025-12-31".into()),
            ..Default::default()
        };
        let in_use = FiledUse {
            device: other,
            result: one.number,
            date: "2026-02-01".into(),
        };
        for (content, why) in [
            (check("count/(m/s²)", "2026-02-01"), "is known in V/(m/s²)"),
            (check("V/(m/s²)", "2026-06-02"), "lies ahead"),
            (Content::Event(event), "lies ahead"),
            (Content::Rule(rule), "S.modulos"),
            (supersession(one.number, None, " "), "for a reason"),
            (Content::Certificate(backwards), "before it begins"),
            (Content::InUse(in_use), "of another device"),
        ] {
            let refused = records.add(TODAY, None, content).unwrap_err();
            assert!(refused.to_string().contains(why), "{refused}");
            assert!(refused.hint().is_some());
        }
        let campaign = Filing {
            campaign: Some(one.number),
            ..Default::default()
        };
        let refused = records.file_candidate(
            &candidate("3", "2026-01-01", 1.0, 0.1, 0.0),
            &campaign,
            TODAY,
        );
        assert!(refused.unwrap_err().to_string().contains("is no campaign"));
        assert_eq!(records.entries(1).unwrap().len(), before);
        records
            .add(TODAY, None, supersession(two.number, None, "wrong cable"))
            .unwrap();
        let refused = records.add(TODAY, None, supersession(one.number, Some(two.number), "x"));
        assert!(
            refused
                .unwrap_err()
                .to_string()
                .contains("no longer counts")
        );
    });
}

#[test]
fn law_limits_that_are_stated_late_judge_the_last_result() {
    each(|place, _| {
        let mut records = make(place);
        file(
            &mut records,
            &candidate("1", "2026-01-01", 1.04, 0.01, 0.005),
            None,
        );
        file(
            &mut records,
            &candidate("2", "2026-01-01", 1.00, 0.01, 0.005),
            None,
        );
        let rule = FiledRule {
            device: None,
            rule: RecalibrationRule::default(),
            tolerances: vec![Tolerance {
                quantity: "S.modulus".into(),
                change: None,
                limits: Some([0.95, 1.05]),
            }],
        };
        let told = records
            .file_content(TODAY, None, Content::Rule(rule))
            .unwrap();
        assert_eq!(codes_of(&told), ["tolerance-not-kept"]);
        assert!(told.findings[0].to_string().contains("A1 1"));
    });
}

#[test]
fn law_a_value_in_another_unit_is_the_same_quantity() {
    let mut records = Records::in_memory().unwrap();
    let text = "serial,date,quantity,value,unit,u\n7,2020-01-01,S.modulus,10,mV/(m/s²),0.1\n\
                7,2021-01-01,S.modulus,0.0101,V/(m/s2),0.0001\n7,2022-01-01,S.modulus,98.0665,mV/g,1\n";
    let source = proofmass_io::Source::from_bytes("old.csv", text.as_bytes()).unwrap();
    records.add_spreadsheet(source, None, TODAY).unwrap();
    let device = records.device("7").unwrap();
    let history = records.history(device).unwrap();
    assert_eq!(history.len(), 1, "one quantity");
    let points = &history[0].series.points;
    assert_eq!(history[0].series.unit, "V/(m/s²)");
    for (point, value) in points.iter().zip([0.01, 0.0101, 0.01]) {
        assert!((point.value / value - 1.0).abs() < 1e-12, "{point:?}");
    }
}

#[test]
fn refuses_to_go_on_behind_a_damaged_end_and_to_back_up_damage() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("lab.records");
    let mut records = make(place.to_str().unwrap());
    for k in 0..3 {
        records
            .add(TODAY, None, Content::Device(device(&k.to_string())))
            .unwrap();
    }
    drop(records);
    let change = |number: i64| {
        let database = rusqlite::Connection::open(&place).unwrap();
        let changed = "UPDATE entry SET body = replace(body, 'A1', 'A2') WHERE number = ?1";
        assert_eq!(database.execute(changed, [number]).unwrap(), 1);
    };
    change(1);
    let mut records = Records::open_to_add(place.to_str().unwrap()).unwrap();
    let refused = records.backup(&folder.path().join("copy")).unwrap_err();
    assert!(refused.to_string().contains("entry 1"), "{refused}");
    records.copy_as_it_is(&folder.path().join("copy")).unwrap();
    drop(records);
    change(3);
    let refused = Records::open_to_add(place.to_str().unwrap()).err().unwrap();
    assert!(refused.to_string().contains("entry 3"), "{refused}");
    let check = Records::open(place.to_str().unwrap())
        .unwrap()
        .check()
        .unwrap();
    assert_eq!(check.damage.len(), 2, "{:?}", check.damage);
}

/// A digital calibration certificate of the sensitivity of one device at two frequencies.
fn digital(signature: &str) -> String {
    let list = |label: &str, values: &str, unit: &str, u: &str| {
        format!(
            "<d:quantity><s:realListXMLList><s:labelXMLList>{label}</s:labelXMLList><s:valueXMLList>{values}</s:valueXMLList>\
             <s:unitXMLList>{unit}</s:unitXMLList>{u}</s:realListXMLList></d:quantity>"
        )
    };
    let u = "<s:measurementUncertaintyUnivariateXMLList><s:expandedMUXMLList><s:valueExpandedMUXMLList>0.1 0.2</s:valueExpandedMUXMLList>\
             <s:coverageFactorXMLList>2</s:coverageFactorXMLList><s:coverageProbabilityXMLList>0.95</s:coverageProbabilityXMLList>\
             </s:expandedMUXMLList></s:measurementUncertaintyUnivariateXMLList>";
    let unit = r"\milli\volt\second\tothe{2}\metre\tothe{-1}";
    let lists = list("frequency", "80 160", r"\hertz", "")
        + &list("sensitivity magnitude", "10 10.4", unit, u);
    format!(
        "<d:digitalCalibrationCertificate xmlns:d=\"https://ptb.de/dcc\" xmlns:s=\"https://ptb.de/si\" schemaVersion=\"3.3.0\">\
         <d:administrativeData><d:coreData><d:uniqueIdentifier>N-17</d:uniqueIdentifier>\
         <d:beginPerformanceDate>2026-01-02</d:beginPerformanceDate><d:endPerformanceDate>2026-01-03</d:endPerformanceDate></d:coreData>\
         <d:items><d:item><d:name><d:content>Accelerometer</d:content></d:name><d:manufacturer><d:name><d:content>maker</d:content></d:name>\
         </d:manufacturer><d:model>A1</d:model><d:identifications><d:identification><d:issuer>manufacturer</d:issuer><d:value>R-7</d:value>\
         </d:identification></d:identifications></d:item></d:items></d:administrativeData><d:measurementResults><d:measurementResult>\
         <d:results><d:result><d:name><d:content>S</d:content></d:name><d:data><d:list>{lists}</d:list></d:data></d:result></d:results>\
         </d:measurementResult></d:measurementResults>{signature}</d:digitalCalibrationCertificate>"
    )
}

#[test]
fn law_a_digital_certificate_says_what_is_not_typed() {
    let text = digital("");
    let read = |certificate: FiledCertificate, of: &str| {
        let read = certificate.reading("c.xml", text.as_bytes(), &device(of));
        read.map(|(certificate, _)| certificate)
    };
    let said = read(FiledCertificate::default(), "r 7").unwrap();
    assert_eq!(
        (said.number.as_str(), said.valid_from.as_str()),
        ("N-17", "2026-01-03")
    );
    let expected = [[80.0, 0.005], [160.0, 0.1 / 10.4]];
    for (at, expected) in said.u_at.iter().zip(expected) {
        assert_eq!(at[0], expected[0]);
        assert!((at[1] / expected[1] - 1.0).abs() < 1e-12, "{at:?}");
    }
    let other = FiledCertificate {
        number: "N-18".into(),
        ..Default::default()
    };
    assert!(
        read(other, "R-7")
            .unwrap_err()
            .to_string()
            .contains("the number N-17")
    );
    let refused = read(FiledCertificate::default(), "R-8").unwrap_err();
    assert!(
        refused.to_string().contains("certificate of maker A1 R-7"),
        "{refused}"
    );
}

#[test]
fn law_a_digital_certificate_is_a_result_of_its_item() {
    each(|place, _| {
        let mut records = make(place);
        let add = |records: &mut Records, text: &str| {
            let source = proofmass_io::Source::from_bytes("c.xml", text.as_bytes()).unwrap();
            records
                .add_digital(source, &Filing::default(), TODAY)
                .unwrap()
        };
        let filed = add(&mut records, &digital(""));
        assert!(codes(&filed).is_empty());
        assert!(add(&mut records, &digital("")).known);
        let Content::Result(result) = records.entry(filed.number).unwrap().content else {
            panic!()
        };
        assert_eq!(result.number.as_deref(), Some("N-17"));
        let q = &result.quantities[1];
        assert_eq!(
            (q.name.as_str(), q.unit.as_str()),
            ("S.modulus[frequency=160]", "V/(m/s²)")
        );
        assert!((q.value - 0.0104).abs() < 1e-15 && (q.u.unwrap() - 1e-4).abs() < 1e-15);
        let signed = digital("<x:Signature xmlns:x=\"http://www.w3.org/2000/09/xmldsig#\"/>");
        let signed = add(&mut records, &signed);
        assert!(
            codes(&signed).iter().any(|c| c.contains("signature")),
            "{signed:?}"
        );
        assert!(records.check().unwrap().is_whole());
    });
}

/// Files `what` and gives the codes of its findings.
fn told(records: &mut Records, what: Content) -> Vec<String> {
    let filed = records.file_content(TODAY, None, what).unwrap();
    filed.findings.iter().map(|f| f.code().to_owned()).collect()
}

#[test]
fn law_an_effect_is_stated_only_where_budget_and_certificate_agree() {
    each(|place, _| {
        let mut records = make(place);
        let r = standard(&mut records, "R");
        certificate(&mut records, r, "C", ["2025-01-01", "2027-01-01"], 0.005);
        file(
            &mut records,
            &candidate("1", "2026-01-05", 1.0, 0.01, 0.005),
            Some("R"),
        );
        // Its budget has twice the uncertainty for the reference: another certificate was behind it.
        file(
            &mut records,
            &candidate("2", "2026-01-06", 1.0, 0.02, 0.01),
            Some("R"),
        );
        let recall = records
            .recall(r, day_of(TODAY).unwrap(), None, Some(0.015))
            .unwrap();
        assert!((recall.results[0].effects[0].effect + 0.015).abs() < 1e-12);
        let why = recall.results[1].undetermined.clone().unwrap();
        assert!(why.contains("1.000 %") && why.contains("0.500 %"), "{why}");
    });
}

#[test]
fn law_the_own_result_of_a_working_standard_is_its_certificate() {
    each(|place, _| {
        let mut records = make(place);
        let w = standard(&mut records, "W");
        let mut own = candidate("W", "2026-01-05", 2.0, 0.02, 0.01);
        own.files = vec![("result.json".into(), b"the result of W".to_vec())];
        let own = file(&mut records, &own, None);
        assert_eq!(own.new_device, None, "it is the standard");
        let Content::Result(filed) = records.entry(own.number).unwrap().content else {
            panic!()
        };
        let mut further = candidate("9", "2026-02-05", 1.0, 0.012, 0.01);
        further.inputs = vec![("w.json".into(), filed.files[0].sha256.clone(), None)];
        let further = file(&mut records, &further, None);
        assert_eq!(further.new_device, Some(own.number + 1));
        let recall = records
            .recall(w, day_of(TODAY).unwrap(), None, Some(0.01))
            .unwrap();
        assert!(
            recall.since.starts_with("its calibration on 2026-01-05"),
            "{}",
            recall.since
        );
        assert_eq!(recall.results.len(), 1);
        assert!(
            (recall.results[0].effects[0].effect + 0.01).abs() < 1e-12,
            "{recall:?}"
        );
    });
}

#[test]
fn law_a_wrong_entry_is_taken_back() {
    each(|place, _| {
        let mut records = make(place);
        let r = standard(&mut records, "R");
        let first = certificate(&mut records, r, "C 1", ["2025-01-01", "2027-01-01"], 0.005);
        let second = certificate(&mut records, r, "C 2", ["2026-01-01", "2028-01-01"], 0.005);
        let result = file(
            &mut records,
            &candidate("1", "2026-02-05", 1.0, 0.01, 0.005),
            Some("R"),
        );
        let device = records.device("1").unwrap();
        let check = |value: f64, reference: f64| {
            let what = ("S.modulus".into(), "V/(m/s²)".into());
            let (date, numbers) = ("2026-03-01".into(), [value, 0.001]);
            Content::Check(
                FiledCheck::measured(r, date, what, numbers, [reference, 0.001]).unwrap(),
            )
        };
        assert!(told(&mut records, check(1.0, 1.0)).is_empty());
        assert_eq!(told(&mut records, check(1.1, 1.0)), ["check-failed"]);
        assert_eq!(
            told(&mut records, check(1000.0, 1000.0)),
            ["check-against-another"]
        );
        let last = records.entries(1).unwrap().len() as i64;
        let back = |records: &mut Records, old: i64| {
            let what = FiledSupersession {
                old,
                new: None,
                reason: "typed wrong".into(),
            };
            records.add(TODAY, None, Content::Supersession(what))
        };
        // Both wrong checks, the second certificate, and a supersession.
        back(&mut records, last).unwrap();
        back(&mut records, last - 1).unwrap();
        assert!(
            back(&mut records, last)
                .unwrap_err()
                .to_string()
                .contains("no longer")
        );
        let recall = records
            .recall(r, day_of(TODAY).unwrap(), None, None)
            .unwrap();
        assert!(
            recall
                .since
                .starts_with("its last good check, on 2026-03-01"),
            "{}",
            recall.since
        );
        assert_eq!(records.results_behind(second).unwrap(), [result.number]);
        back(&mut records, second).unwrap();
        assert_eq!(records.results_behind(first).unwrap(), [result.number]);
        let superseded = back(&mut records, result.number).unwrap();
        assert!(records.results_of(device).unwrap().is_empty());
        back(&mut records, superseded).unwrap();
        assert_eq!(records.results_of(device).unwrap(), [result.number]);
        assert!(
            back(&mut records, device)
                .unwrap_err()
                .to_string()
                .contains("is a device")
        );
        assert!(records.check().unwrap().is_whole());
    });
}

#[test]
fn law_what_a_result_says_otherwise_is_told() {
    each(|place, _| {
        let mut records = make(place);
        file(
            &mut records,
            &candidate("1", "2026-01-05", 1.0, 0.01, 0.005),
            None,
        );
        let filing = Filing {
            device: Some("1".into()),
            ..Default::default()
        };
        let mut other = candidate("2", "2026-01-06", 1.0, 0.01, 0.005);
        other.quantities[0].unit = "count/(m/s²)".into();
        let filed = records.file_candidate(&other, &filing, TODAY).unwrap();
        assert_eq!(
            codes(&filed),
            [
                "standard-not-named",
                "device-named-otherwise",
                "unit-otherwise"
            ]
        );
        let withdrawal = FiledEvent {
            device: records.device("1").unwrap(),
            date: "2026-01-10".into(),
            event: EventKind::Withdrawal,
            text: String::new(),
        };
        records
            .add(TODAY, None, Content::Event(withdrawal))
            .unwrap();
        let late = file(
            &mut records,
            &candidate("1", "2026-01-12", 1.0, 0.01, 0.005),
            None,
        );
        assert_eq!(codes(&late), ["standard-not-named", "device-withdrawn"]);
        // A number is a number here and no serial number.
        assert!(
            records
                .device("#99")
                .unwrap_err()
                .to_string()
                .contains("no entry 99")
        );
        assert_eq!(
            told(&mut records, Content::Device(device("01"))),
            ["serial-spelled-otherwise"]
        );
        let mut twice = candidate("3", "2026-01-06", 1.0, 0.01, 0.005);
        twice.quantities.push(twice.quantities[0].clone());
        let refused = records.file_candidate(&twice, &Filing::default(), TODAY);
        assert!(refused.unwrap_err().to_string().contains("stands twice"));
    });
}

#[test]
fn law_a_tolerance_without_a_frequency_is_that_of_all() {
    let tolerance = |name: &str| Tolerance {
        quantity: name.into(),
        change: Some(0.1),
        limits: None,
    };
    for (name, quantity, is_of) in [
        ("S.modulus", "S.modulus[frequency=160]", true),
        ("S.modulus", "S.modulus", true),
        ("S.mod", "S.modulus", false),
        ("S.modulus[frequency=16]", "S.modulus[frequency=160]", false),
    ] {
        assert_eq!(tolerance(name).is_of(quantity), is_of, "{name} {quantity}");
    }
}

#[test]
fn refuses_an_exported_folder_that_lacks_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path());
    let mut records = make(folder.path().join("lab.records").to_str().unwrap());
    records
        .add_result(&campaign.join("result"), &filing(), TODAY)
        .unwrap();
    let out = proofmass_io::OutputFolder::create(folder.path().join("out"), false).unwrap();
    records.export_folder(&out).unwrap();
    let out = out.commit().unwrap();
    let lost = std::fs::read_dir(&out)
        .unwrap()
        .flatten()
        .find(|f| f.file_name().len() == 64)
        .unwrap();
    std::fs::remove_file(lost.path()).unwrap();
    let mut copy = make(folder.path().join("copy.records").to_str().unwrap());
    let refused = copy.import_folder(&out).unwrap_err();
    assert!(refused.to_string().contains("is not in"), "{refused}");
    assert!(copy.entries(1).unwrap().is_empty());
}

#[test]
fn law_a_certificate_is_the_document_of_its_result() {
    each(|place, _| {
        let mut records = make(place);
        let r = standard(&mut records, "R");
        certificate(&mut records, r, "C", ["2025-01-01", "2027-01-01"], 0.005);
        let rule = FiledRule {
            device: None,
            rule: RecalibrationRule::default(),
            tolerances: Vec::new(),
        };
        records.add(TODAY, None, Content::Rule(rule)).unwrap();
        let mut result = candidate("1", "2026-01-05", 1.0, 0.01, 0.005);
        result.files = vec![("result.json".into(), b"the result".to_vec())];
        let filed = file(&mut records, &result, Some("R"));
        let Content::Result(there) = records.entry(filed.number).unwrap().content else {
            panic!()
        };
        let device = records.device("1").unwrap();
        let due = records.due_of(device).unwrap();
        let document = Candidate {
            kind: "certificate".into(),
            date: "2026-02-01".into(),
            sha256: "its own".into(),
            quantities: Vec::new(),
            files: vec![("certificate.xml".into(), b"<dcc/>".to_vec())],
            inputs: vec![("result.json".into(), there.files[0].sha256.clone(), None)],
            ..result.clone()
        };
        let filing = Filing {
            number: Some("CAL-2026-0042".into()),
            ..Default::default()
        };
        let document = records.file_candidate(&document, &filing, TODAY).unwrap();
        assert!(codes(&document).is_empty(), "{:?}", codes(&document));
        // No calibration of its own, and part of a recall.
        assert_eq!(records.due_of(device).unwrap(), due);
        assert_eq!(records.results_of(device).unwrap(), [filed.number]);
        assert_eq!(records.history(device).unwrap()[0].series.points.len(), 1);
        let recall = records
            .recall(r, day_of(TODAY).unwrap(), None, None)
            .unwrap();
        let numbers: Vec<Option<&str>> =
            recall.results.iter().map(|r| r.number.as_deref()).collect();
        assert_eq!(numbers, [None, Some("CAL-2026-0042")]);
    });
}
