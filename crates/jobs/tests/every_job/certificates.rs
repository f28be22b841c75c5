//! Certificates of every kind of calibration: the same numbers, to the digit, in sheet, digital certificate, page, terminal and JSON.

use crate::agreement::{check, in_the_terminal};
use crate::support::record;
use crate::{ask, calibrations};
use proofmass_documents::DigitalCertificate;
use proofmass_io::Source;
use proofmass_jobs::certificate::{
    CertificateData, CertificateFile, CertificateJob, CertificateOutcome, Language, Replaced,
};
use proofmass_jobs::{AnyData, Job, Outcome as _, StoredResult, Unwatched};
use std::collections::BTreeSet;
use std::path::Path;

/// A file of a laboratory with everything that a certificate must state, and markup in its names.
pub fn laboratory() -> CertificateFile {
    let text = r#"{
        "laboratory": {"name": "Lab <b>&\"x\"</b> #strong[y] $z$", "town": "Pisa", "country": "IT", "street": "Via 1"},
        "signatories": [{"name": "A. Rossi", "role": "head"}],
        "standards": [{"name": "Standard 1", "certificate": "PTB-17", "issuer": "PTB", "valid_until": "2027-01-01"}],
        "customer": {"name": "Customer", "town": "Turin", "country": "IT"},
        "item": {"model": "A-1", "serial": "4711", "condition": "no damage"},
        "calibration": {"received": "2026-01-02", "begin": "2026-01-03", "temperature_degC": [22.5, 23.5], "mounting": "stud", "humidity_%": [40, 45]}
    }"#;
    serde_json::from_str(text).expect("a laboratory")
}

pub fn job(language: Language, result: &StoredResult) -> CertificateJob {
    let mut file = laboratory();
    // Type and serial number are those of the result where it says them.
    let device = &result.record().device;
    if let Some(item) = &mut file.item {
        item.model = device.model.clone().or(item.model.take());
        item.serial = device.serial.clone().or(item.serial.take());
    }
    let reference = result
        .record()
        .inputs
        .iter()
        .find(|i| i.path.ends_with("reference.csv"));
    file.standards[0].input = reference.map(|_| "reference.csv".to_owned());
    CertificateJob {
        file,
        language,
        issued: Some("2026-02-01".into()),
        ..CertificateJob::default()
    }
}

fn evaluated(job: &CertificateJob, result: &StoredResult) -> CertificateOutcome {
    let outcome = job.evaluate(&CertificateData::new(result), &Unwatched);
    outcome.unwrap_or_else(|e| panic!("{}: {e} {:?}", result.kind(), e.place()))
}

fn calibrated() -> Vec<StoredResult> {
    vec![
        calibrations::shaker_single("shaker-single"),
        calibrations::shaker_primary("shaker-primary"),
        calibrations::shaker_triaxial("shaker-triaxial"),
        calibrations::transverse("transverse-sensitivity"),
        calibrations::multi_position("multi-position"),
        calibrations::temperature("temperature"),
    ]
}

pub fn certificate(kind: &str) {
    let single = calibrations::shaker_single("shaker-single");
    let result = check(kind, &|watch| {
        let data = CertificateData::new(&single);
        ask(
            job(Language::English, &single),
            &AnyData::Certificate(data),
            watch,
        )
    });
    let names: Vec<String> = result
        .files()
        .expect("files")
        .into_iter()
        .map(|f| f.0)
        .collect();
    for name in ["certificate.xml", "sheet.json"] {
        assert!(names.iter().any(|n| n == name), "{names:?}");
    }
}

/// Words and numbers of a text between tags.
fn plain(text: &str) -> String {
    let mut inside = false;
    let keep = |c: char| {
        inside = match c {
            '<' => true,
            '>' => false,
            _ => inside,
        };
        !inside && c != '>'
    };
    text.chars()
        .filter(|c| !c.is_whitespace())
        .filter({
            let mut keep = keep;
            move |c| keep(*c)
        })
        .collect()
}

#[test]
fn law_numbers_are_the_same_to_the_digit_wherever_they_stand() {
    for calibrated in calibrated() {
        let kind = calibrated.kind().to_owned();
        let outcome = evaluated(&job(Language::English, &calibrated), &calibrated);
        assert!(
            outcome.missing().is_empty(),
            "{kind}: {:?}",
            outcome.missing()
        );
        let result = StoredResult::new(record(), &outcome).expect("a result");
        let whole: serde_json::Value =
            serde_json::from_slice(&outcome.whole_sheet().unwrap()).unwrap();
        let mut sheet = whole.clone();
        sheet["attachments"] = serde_json::Value::Null;
        let sheet = sheet.to_string();
        let terminal: String = in_the_terminal(&result)
            .chars()
            .filter(|c| !c.is_whitespace())
            .collect();
        let page = plain(&result.html().expect("a page"));
        let json = result
            .section("certificate")
            .expect("a section")
            .to_string();
        let results = outcome.results();
        let tables = results.tables.iter().flat_map(|t| &t.columns);
        let lists: Vec<_> = tables.clone().map(|c| &c.numbers).collect();
        assert!(!lists.is_empty() || !results.singles.is_empty(), "{kind}");
        // Lists of the digital certificate, number by number.
        let read = DigitalCertificate::from_source(
            Source::from_bytes("c.xml", outcome.xml().to_owned()).unwrap(),
        )
        .unwrap_or_else(|e| panic!("{kind}: {e}"));
        for column in tables {
            let values: Vec<&str> = column.numbers.iter().map(|n| n.value.as_str()).collect();
            let listed = format!("<si:valueXMLList>{}</si:valueXMLList>", values.join(" "));
            assert!(outcome.xml().contains(&listed), "{kind}: {listed}");
            let of_xml = read
                .quantities
                .iter()
                .filter(|q| q.values.len() == values.len());
            let mut same = of_xml.filter(|q| {
                q.values
                    .iter()
                    .zip(&values)
                    .all(|(a, b)| *a == b.parse::<f64>().unwrap())
            });
            assert!(same.next().is_some(), "{kind}: {values:?}");
        }
        let singles = results.singles.iter().map(|s| &s.number);
        for number in lists.into_iter().flatten().chain(singles) {
            let printed = number.value.replace('-', "−");
            let mut stated = vec![printed];
            if number.interval.is_none() {
                stated.push(number.expanded.clone());
            }
            for text in stated {
                for (place, all) in [("sheet", &sheet), ("terminal", &terminal), ("page", &page)] {
                    assert!(all.contains(&text), "{kind}: {place} without {text}");
                }
            }
            assert!(
                json.contains(&format!("\"{}\"", number.value)),
                "{kind}: {}",
                number.value
            );
            assert!(
                outcome.xml().contains(&number.value),
                "{kind}: {}",
                number.value
            );
        }
        assert!(sheet.contains("rounded up to two significant digits"));
        // A slope in m/s²/K is one per kelvin.
        let per_kelvin = "<si:unit>\\metre\\second\\tothe{-2}\\kelvin\\tothe{-1}</si:unit>";
        assert!(kind != "temperature" || outcome.xml().contains(per_kelvin));
        // What its terms of the temperature are counted from, and where they were measured.
        let told = ["Reference temperature T₀", "Temperatures of the item"];
        assert!(
            kind != "temperature"
                || told
                    .iter()
                    .all(|t| sheet.contains(t) && outcome.xml().contains(t))
        );
        // Text from outside stays text.
        assert!(!outcome.xml().contains("<b>") && !result.html().unwrap().contains("<b>&"));
        // No formula comes from outside.
        let formulas = sheet.matches("\"math\"").count();
        let symbols = ["U", "k"].map(|s| sheet.matches(&format!("{{\"math\":\"{s}\"}}")).count());
        assert_eq!(formulas, symbols[0] + symbols[1]);
        assert_eq!(whole["attachments"].as_array().unwrap().len(), 2);
        // The same inputs, the same bytes.
        assert_eq!(
            evaluated(&job(Language::English, &calibrated), &calibrated)
                .whole_sheet()
                .unwrap(),
            outcome.whole_sheet().unwrap()
        );
    }
}

/// What a certificate must state (ISO/IEC 17025, 7.8.2 and 7.8.4) stands on the sheet in every language.
#[test]
fn law_every_mandatory_item_stands_in_every_language() {
    let result = calibrations::shaker_single("shaker-single");
    let mut texts = BTreeSet::new();
    for language in Language::ALL {
        let mut request = job(language, &result);
        request.number = Some("CAL-2026-0001".into());
        request.persian_digits = true;
        request.replaces = Some(Replaced {
            number: "CAL-2025-0009".into(),
            reason: "wrong serial number".into(),
            other_item: false,
        });
        let outcome = evaluated(&request, &result);
        let sheet: serde_json::Value =
            serde_json::from_slice(&outcome.whole_sheet().unwrap()).unwrap();
        assert_eq!(sheet["language"], language.code());
        assert_eq!(sheet["direction"], language.direction());
        assert!(sheet["watermark"].is_null());
        let text = format!("{} {}", sheet["issuer"], sheet["blocks"]);
        for item in [
            "CAL-2026-0001",
            "Via 1",
            "Pisa",
            "Customer",
            "Turin",
            "no damage",
            "A. Rossi",
            "head",
            "PTB-17",
            "Standard 1",
            "ISO 16063-21",
            "JCGM 100",
            "CAL-2025-0009",
            "wrong serial number",
            "SHA-256",
            "stud",
        ] {
            assert!(text.contains(item), "{language:?} without {item}");
        }
        let days = match language {
            Language::Persian => ["۲۰۲۶-۰۱-۰۲", "۲۰۲۶-۰۱-۰۳", "۲۰۲۶-۰۲-۰۱"],
            _ => ["2026-01-02", "2026-01-03", "2026-02-01"],
        };
        for day in days {
            assert!(text.contains(day), "{language:?} without {day}");
        }
        let amplitude = match language {
            Language::English => "Amplitude of the acceleration",
            Language::Italian => "Ampiezza dell",
            Language::Persian => "دامنهٔ شتاب",
        };
        assert!(text.contains(amplitude) && outcome.xml().contains(amplitude));
        let number = &outcome.results().tables[0].columns[0].numbers[0].value;
        assert_eq!(
            text.contains(number.as_str()),
            language != Language::Persian,
            "{number}"
        );
        assert!(
            outcome.xml().contains(number.as_str()),
            "digits of XML are those of XML"
        );
        assert!(texts.insert(sheet["title"].to_string()));
        // A draft of the same says so on every page and has no number.
        let draft = evaluated(&job(language, &result), &result);
        let sheet: serde_json::Value =
            serde_json::from_slice(&draft.whole_sheet().unwrap()).unwrap();
        assert!(sheet["watermark"].as_str().is_some_and(|w| !w.is_empty()));
    }
}

#[test]
fn refuses_a_certificate_that_lacks_something_and_lists_it() {
    let result = calibrations::shaker_single("shaker-single");
    let lacking = |change: &dyn Fn(&mut CertificateFile)| {
        let mut request = job(Language::English, &result);
        change(&mut request.file);
        let missing = evaluated(&request, &result).missing().to_vec();
        request.number = Some("C-1".into());
        let refused = request.evaluate(&CertificateData::new(&result), &Unwatched);
        assert_eq!(refused.is_err(), !missing.is_empty());
        if let Err(trouble) = refused {
            assert_eq!(trouble.place(), missing);
            assert!(
                trouble.to_string().contains("cannot be released"),
                "{trouble}"
            );
        }
        missing.join("\n")
    };
    assert_eq!(lacking(&|_| {}), "");
    type Change = dyn Fn(&mut CertificateFile);
    let cases: [(&str, &Change); 10] = [
        ("laboratory.name", &|f| f.laboratory = None),
        ("customer.name", &|f| f.customer = None),
        ("item.serial or item.customer_id", &|f| {
            f.item.as_mut().unwrap().serial = None
        }),
        ("item.condition", &|f| {
            f.item.as_mut().unwrap().condition = Some("  ".into())
        }),
        ("calibration.begin", &|f| {
            f.calibration.as_mut().unwrap().begin = None
        }),
        ("calibration.mounting", &|f| {
            f.calibration.as_mut().unwrap().mounting = Some("…".into())
        }),
        ("signatories", &|f| f.signatories.clear()),
        ("standards", &|f| f.standards.clear()),
        ("expired standard", &|f| {
            f.standards[0].valid_until = Some("2026-01-02".into())
        }),
        ("unknown standard", &|f| {
            f.standards[0].input = Some("other.csv".into())
        }),
    ];
    for (word, change) in cases {
        assert!(
            lacking(change).contains(word),
            "{word}: {}",
            lacking(change)
        );
    }
    assert!(
        lacking(&|f| f.calibration.as_mut().unwrap().received = Some("2026-01-04".into()))
            .contains("lies after")
    );
}

#[test]
fn refuses_a_k_or_a_probability_that_the_result_does_not_have() {
    let result = calibrations::shaker_single("shaker-single");
    for (statement, word) in [
        (r#"{"coverage_factor": 2}"#, "k = 2"),
        (r#"{"probability": 0.9545}"#, "0.9545"),
    ] {
        let mut request = job(Language::English, &result);
        request.file.statement = Some(serde_json::from_str(statement).unwrap());
        let trouble = request
            .evaluate(&CertificateData::new(&result), &Unwatched)
            .unwrap_err();
        assert!(trouble.to_string().contains(word), "{trouble}");
    }
    let mut request = job(Language::English, &result);
    request.file.statement = Some(serde_json::from_str(r#"{"probability": 0.95}"#).unwrap());
    assert!(
        request
            .evaluate(&CertificateData::new(&result), &Unwatched)
            .is_ok()
    );
}

#[test]
fn known_decisions_are_printed_with_their_rule_and_risk() {
    let result = calibrations::shaker_single("shaker-single");
    let outcome = evaluated(&job(Language::English, &result), &result);
    let column = &outcome.results().tables[0].columns[0];
    let value: f64 = column.numbers[0].value.parse().unwrap();
    let u: f64 = column.numbers[0].expanded.parse().unwrap();
    let decided = |rule: &str, upper: f64| {
        let mut request = job(Language::English, &result);
        let entry = format!(
            r#"[{{"quantity": "{}", "upper": {upper}, {rule}}}]"#,
            column.name
        );
        request.file.conformity = serde_json::from_str(&entry).unwrap();
        let outcome = request.evaluate(&CertificateData::new(&result), &Unwatched)?;
        let sheet: serde_json::Value =
            serde_json::from_slice(&outcome.whole_sheet().unwrap()).unwrap();
        Ok::<_, proofmass_jobs::Trouble>((sheet["blocks"].to_string(), outcome.xml().to_owned()))
    };
    // Half of U below the limit: inside of it, and inside of the guard band of U.
    let near = value + 0.5 * u;
    let (sheet, xml) = decided(r#""rule": "simple""#, near).unwrap();
    assert!(
        sheet.contains("simple acceptance") && sheet.contains("\"pass\""),
        "{sheet}"
    );
    assert!(
        xml.contains("<dcc:conformity>pass</dcc:conformity>"),
        "{xml}"
    );
    let (sheet, xml) = decided(r#""rule": "guard-band", "r": 1"#, near).unwrap();
    assert!(
        sheet.contains("guard band w = r·U with r = 1") && sheet.contains("\"fail\""),
        "{sheet}"
    );
    assert!(xml.contains("<dcc:conformity>fail</dcc:conformity>"));
    assert!(
        decided(r#""rule": "guard-band""#, near)
            .unwrap_err()
            .to_string()
            .contains("needs its r")
    );
    let mut request = job(Language::English, &result);
    request.file.conformity =
        serde_json::from_str(r#"[{"quantity": "S.modulu", "upper": 1, "rule": "simple"}]"#)
            .unwrap();
    let trouble = request
        .evaluate(&CertificateData::new(&result), &Unwatched)
        .unwrap_err();
    assert!(
        trouble.hint().unwrap().contains("did you mean `S.modulus`"),
        "{trouble}"
    );
}

/// Sheets of every kind are the test sheets of the typesetter, which is a workspace of its own: what is written here is accepted there.
#[test]
fn law_sheets_are_those_that_the_typesetter_is_tested_with() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/sheets");
    let languages = [
        (Language::English, false),
        (Language::Italian, false),
        (Language::Persian, false),
        (Language::Persian, true),
    ];
    let before = calibrations::multi_position_of("multi-position", "2025-12-01");
    for (i, result) in calibrated().iter().enumerate() {
        let (language, persian_digits) = languages[i % languages.len()];
        let mut request = job(language, result);
        request.persian_digits = persian_digits;
        if result.kind() == "shaker-single" {
            let limits = r#"[{"quantity": "S.modulus", "lower": 1, "upper": 1000, "rule": "guard-band", "r": 1, "source": "datasheet"}]"#;
            request.file.conformity = serde_json::from_str(limits).unwrap();
            request.number = Some("CAL-2026-0001".into());
        }
        let data = CertificateData {
            result,
            as_found: (result.kind() == "multi-position").then_some(&before),
            ..CertificateData::new(result)
        };
        let outcome = request.evaluate(&data, &Unwatched).expect("a certificate");
        let sheet = outcome.attachments(&record()).expect("files").remove(1).1;
        // The digest is that of a result with all its digits, which are those of one machine.
        let sheet = String::from_utf8(sheet).unwrap();
        let digest = sheet
            .split('"')
            .find(|t| t.len() == 64 && t.bytes().all(|b| b.is_ascii_hexdigit()));
        let sheet = sheet.replace(digest.expect("a digest"), &"0".repeat(64)) + "\n";
        let place = folder.join(format!("{}-{}.json", result.kind(), language.code()));
        if std::env::var_os("PROOFMASS_WRITE_SHEETS").is_some() {
            std::fs::write(&place, &sheet).unwrap();
        }
        let kept = std::fs::read_to_string(&place).unwrap_or_default();
        assert!(
            kept == sheet,
            "{} is not what is written now: look at the difference, and set PROOFMASS_WRITE_SHEETS to write it anew",
            place.display()
        );
    }
}
