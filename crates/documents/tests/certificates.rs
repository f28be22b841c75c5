//! Digital calibration certificates: read in every form, refused with element and line.

use proofmass_documents::DigitalCertificate;
use proofmass_io::{Error, Source, Unit};
use std::path::PathBuf;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// A certificate around a result; `{}` in the head is the version.
fn certificate(version: &str, result: &str) -> String {
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<d:digitalCalibrationCertificate xmlns:d="https://ptb.de/dcc" xmlns:s="https://ptb.de/si" schemaVersion="{version}">
<d:administrativeData><d:coreData><d:usedLangCodeISO639_1>en</d:usedLangCodeISO639_1>
<d:uniqueIdentifier>N-17</d:uniqueIdentifier><d:beginPerformanceDate>2026-01-02</d:beginPerformanceDate>
<d:endPerformanceDate>2026-01-03</d:endPerformanceDate></d:coreData>
<d:items><d:item><d:name><d:content lang="de">Aufnehmer</d:content><d:content lang="en">Accelerometer</d:content></d:name>
<d:manufacturer><d:name><d:content>Maker</d:content></d:name></d:manufacturer><d:model>A-1</d:model>
<d:identifications><d:identification><d:issuer>customer</d:issuer><d:value>inv-3</d:value></d:identification>
<d:identification><d:issuer>manufacturer</d:issuer><d:value>4711</d:value></d:identification></d:identifications></d:item></d:items>
</d:administrativeData>
<d:measurementResults><d:measurementResult><d:results><d:result><d:name><d:content>Sensitivity</d:content></d:name><d:data>
{result}
</d:data></d:result></d:results></d:measurementResult></d:measurementResults>
</d:digitalCalibrationCertificate>
"#
    )
}

fn read(text: &str) -> Result<DigitalCertificate, Error> {
    DigitalCertificate::from_source(Source::from_bytes("c.xml", text.to_owned())?)
}

/// A list in the current form, with U given once where `u` is one number.
fn list(label: &str, values: &str, unit: &str, u: &str) -> String {
    let stated = match u {
        "" => String::new(),
        u => format!(
            "<s:measurementUncertaintyUnivariateXMLList><s:expandedMUXMLList>\n<s:valueExpandedMUXMLList>{u}</s:valueExpandedMUXMLList>\n\
             <s:coverageFactorXMLList>2</s:coverageFactorXMLList>\n<s:coverageProbabilityXMLList>0.95</s:coverageProbabilityXMLList>\n\
             <s:distributionXMLList>normal</s:distributionXMLList>\n</s:expandedMUXMLList></s:measurementUncertaintyUnivariateXMLList>"
        ),
    };
    format!(
        "<d:quantity><s:realListXMLList><s:labelXMLList>{label}</s:labelXMLList>\n<s:valueXMLList>{values}</s:valueXMLList>\n\
         <s:unitXMLList>{unit}</s:unitXMLList>\n{stated}</s:realListXMLList></d:quantity>\n"
    )
}

const MILLIVOLT: &str = "\\milli\\volt\\second\\tothe{2}\\metre\\tothe{-1}";

fn lists() -> String {
    let all = [
        list("frequency", "10 20 40", "\\hertz", ""),
        list(
            "sensitivity magnitude",
            "10.1 10.2 10.4",
            MILLIVOLT,
            "0.1 0.1 0.2",
        ),
        list("sensitivity phase", "-1 -2 -4", "\\degree", "0.5"),
    ];
    format!("<d:list>\n{}</d:list>", all.concat())
}

#[test]
fn known_lists_are_read_with_head_and_uncertainty() {
    let c = read(&certificate("3.3.0", &lists())).unwrap();
    assert_eq!(c.identifier.as_deref(), Some("N-17"));
    assert_eq!(c.item.line(), "Maker A-1 4711");
    assert_eq!(c.item.description.as_deref(), Some("Accelerometer"));
    assert_eq!(c.performed.as_ref().unwrap()[1], "2026-01-03");
    assert!(c.findings().is_empty());
    let s = c.sensitivity(None).unwrap();
    assert_eq!(s.output, Unit::Volt);
    let row = s.rows[2];
    assert_eq!((row.frequency, row.sensitivity), (40.0, 10.4 * 1e-3));
    assert_eq!(row.sensitivity_uncertainty, 0.2 * 1e-3 / 2.0);
    assert_eq!(row.phase, Some([-4.0 * DEGREE, 0.5 * DEGREE / 2.0]));
}

/// The forms say the same: deprecated lists, single values, rows, hybrids, standard uncertainty, a complex quantity, any prefix.
#[test]
fn law_every_form_gives_the_same_table() {
    let whole = certificate("3.3.0", &lists());
    let due = read(&whole).unwrap().sensitivity(None).unwrap();
    let single = |label: &str, value: &str, unit: &str, u: &str| {
        format!(
            "<s:real><s:label>{label}</s:label><s:value>{value}</s:value><s:unit>{unit}</s:unit><s:expandedUnc><s:uncertainty>{u}\
             </s:uncertainty><s:coverageFactor>2</s:coverageFactor><s:coverageProbability>0.95</s:coverageProbability>\
             </s:expandedUnc></s:real>"
        )
    };
    let row = |f: &str, m: &str, u: &str, p: &str| {
        [
            single("frequency", f, "\\hertz", "0.01"),
            single("sensitivity magnitude", m, MILLIVOLT, u),
            single("sensitivity phase", p, "\\degree", "0.5"),
        ]
        .concat()
    };
    let rows = [
        ("10", "10.1", "0.1", "-1"),
        ("20", "10.2", "0.1", "-2"),
        ("40", "10.4", "0.2", "-4"),
    ];
    let in_lists: String = rows
        .iter()
        .map(|r| {
            format!(
                "<s:realList><s:label>results</s:label>{}</s:realList>",
                row(r.0, r.1, r.2, r.3)
            )
        })
        .collect();
    let quantities: String = rows
        .iter()
        .map(|r| {
            row(r.0, r.1, r.2, r.3)
                .replace("<s:real>", "<d:quantity><s:real>")
                .replace("</s:real>", "</s:real></d:quantity>")
        })
        .collect();
    let deprecated = lists()
        .replace("<s:measurementUncertaintyUnivariateXMLList>", "")
        .replace("</s:measurementUncertaintyUnivariateXMLList>", "")
        .replace("expandedMUXMLList", "expandedUncXMLList")
        .replace("valueExpandedMUXMLList", "uncertaintyXMLList");
    let hybrid = lists()
        .replace(
            "<s:realListXMLList><s:labelXMLList>sensitivity phase",
            "<s:hybrid><s:realListXMLList><s:labelXMLList>sensitivity phase</s:labelXMLList><s:valueXMLList>-17.5 -34.9 -69.8</s:valueXMLList>\
             <s:unitXMLList>|mil</s:unitXMLList></s:realListXMLList><s:realListXMLList><s:labelXMLList>sensitivity phase",
        );
    let end = hybrid.rfind("</s:realListXMLList>").unwrap() + "</s:realListXMLList>".len();
    let hybrid = format!("{}</s:hybrid>{}", &hybrid[..end], &hybrid[end..]);
    for (version, text) in [
        ("3.3.0", certificate("3.3.0", &lists())),
        ("2.3.0", certificate("2.3.0", &quantities)),
        (
            "2.4.0",
            certificate(
                "2.4.0",
                &format!("<d:list><d:quantity>{in_lists}</d:quantity></d:list>"),
            ),
        ),
        ("3.1.2", certificate("3.1.2", &deprecated)),
        ("3.2.1", certificate("3.2.1", &hybrid)),
        (
            "3.3.0",
            whole
                .replace("<d:", "<")
                .replace("</d:", "</")
                .replace("xmlns:d=", "xmlns="),
        ),
        (
            "3.3.0",
            whole
                .replace("<s:", "<si:")
                .replace("</s:", "</si:")
                .replace("xmlns:s=", "xmlns:si="),
        ),
    ] {
        let c = read(&text).unwrap_or_else(|e| panic!("{version}: {e}"));
        assert_eq!(c.version.as_deref(), Some(version));
        let s = c
            .sensitivity(None)
            .unwrap_or_else(|e| panic!("{version}: {e}\n{text}"));
        assert_eq!(s.rows.len(), 3, "{version}");
        for (a, b) in s.rows.iter().zip(&due.rows) {
            assert_eq!(
                (
                    a.frequency,
                    a.sensitivity,
                    a.sensitivity_uncertainty,
                    a.phase
                ),
                (
                    b.frequency,
                    b.sensitivity,
                    b.sensitivity_uncertainty,
                    b.phase
                ),
                "{version}"
            );
        }
    }
}

#[test]
fn known_standard_uncertainties_and_complex_quantities() {
    let standard = lists()
        .replace("expandedMUXMLList", "standardMUXMLList")
        .replace("valueExpandedMUXMLList", "valueStandardMUXMLList");
    let cut = |text: String, name: &str| {
        let (open, close) = (format!("<s:{name}>"), format!("</s:{name}>"));
        let mut text = text;
        while let (Some(a), Some(b)) = (text.find(&open), text.find(&close)) {
            text.replace_range(a..b + close.len(), "");
        }
        text
    };
    let standard = cut(
        cut(standard, "coverageFactorXMLList"),
        "coverageProbabilityXMLList",
    );
    let standard = standard.replace("<s:valueExpandedMUXMLList", "<s:valueStandardMUXMLList");
    let s = read(&certificate("3.3.0", &standard))
        .unwrap()
        .sensitivity(None)
        .unwrap();
    assert_eq!(s.rows[0].sensitivity_uncertainty, 0.1 * 1e-3);

    let square = "\\milli\\volt\\tothe{2}\\second\\tothe{4}\\metre\\tothe{-2}";
    let mixed = &format!("{MILLIVOLT}\\radian");
    let cell = |v: &str, unit: &str| {
        format!(
            "<s:covarianceXMLList><s:valueXMLList>{v}</s:valueXMLList><s:unitXMLList>{unit}</s:unitXMLList></s:covarianceXMLList>"
        )
    };
    let units = |a: &str, b: &str, units: [&str; 2]| {
        format!(
            "<s:columnXMLList>{}{}</s:columnXMLList>",
            cell(a, units[0]),
            cell(b, units[1])
        )
    };
    let complex = |names: [&str; 2], first: &str, second: &str, phase: &str, a: &str, b: &str| {
        format!(
            "<d:list>{}<d:quantity><s:complexListXMLList><s:labelXMLList>sensitivity</s:labelXMLList>\
             <s:{n0}>{first}</s:{n0}><s:{n1}>{second}</s:{n1}><s:unitXMLList>{MILLIVOLT}</s:unitXMLList>{phase}\
             <s:measurementUncertaintyBivariateXMLList><s:ellipsoidalRegionMUXMLList><s:covarianceMatrixXMLList>{a}{b}\
             </s:covarianceMatrixXMLList><s:coverageFactorXMLList>2.45</s:coverageFactorXMLList><s:coverageProbabilityXMLList>0.95\
             </s:coverageProbabilityXMLList></s:ellipsoidalRegionMUXMLList></s:measurementUncertaintyBivariateXMLList>\
             </s:complexListXMLList></d:quantity></d:list>",
            list("frequency", "10 20", "\\hertz", ""),
            n0 = names[0],
            n1 = names[1],
        )
    };
    let polar = complex(
        ["valueMagnitudeXMLList", "valuePhaseXMLList"],
        "10 11",
        "0.5 0.6",
        "<s:unitPhaseXMLList>\\radian</s:unitPhaseXMLList>",
        &units("0.01 0.04", "0 0", [square, mixed]),
        &units("0 0", "0.0001 0.0004", [mixed, "\\radian\\tothe{2}"]),
    );
    let s = read(&certificate("3.3.0", &polar))
        .unwrap()
        .sensitivity(None)
        .unwrap();
    assert_eq!(
        (s.rows[1].sensitivity, s.rows[1].phase),
        (11.0 * 1e-3, Some([0.6, 0.02]))
    );
    assert_eq!(s.rows[1].sensitivity_uncertainty, 0.2 * 1e-3);
    // The same in real and imaginary parts: a circle of 0.1 about 10 at 30°.
    let (re, im) = (10.0 * (30.0 * DEGREE).cos(), 10.0 * (30.0 * DEGREE).sin());
    let cartesian = complex(
        ["valueRealXMLList", "valueImagXMLList"],
        &format!("{re} {re}"),
        &format!("{im} {im}"),
        "",
        &units("0.01", "0", [square, square]),
        &units("0", "0.01", [square, square]),
    );
    let s = read(&certificate("3.3.0", &cartesian))
        .unwrap()
        .sensitivity(None)
        .unwrap();
    let [phase, u] = s.rows[0].phase.unwrap();
    assert!((phase - 30.0 * DEGREE).abs() < 1e-15 && (u - 0.01).abs() < 1e-12);
    assert!((s.rows[0].sensitivity - 0.01).abs() < 1e-17);
    // Beside magnitudes and phases of the same values: as they are, rounded with U or another turn, and contradicting.
    let beside = |magnitude: &str, phase: &str| {
        let alone = format!(
            "{}{}",
            list("sensitivity magnitude", magnitude, MILLIVOLT, "0.2 0.4"),
            list("sensitivity phase", phase, "\\radian", "0.02 0.04")
        );
        let both = polar.replacen(
            "<d:quantity><s:complex",
            &format!("{alone}<d:quantity><s:complex"),
            1,
        );
        read(&certificate("3.3.0", &both))
            .unwrap()
            .sensitivity(None)
    };
    let s = beside("10 11", "0.5 0.6").unwrap();
    assert_eq!((s.rows.len(), s.rows[1].sensitivity), (2, 11.0 * 1e-3));
    assert!(beside("10.01 11", "-5.78 0.6").is_ok());
    for (magnitude, phase) in [
        ("10.2 11", "0.5 0.6"),
        ("10 11", "0.5 0.7"),
        ("10 11", "-0.5 0.6"),
    ] {
        let error = beside(magnitude, phase).unwrap_err();
        assert!(
            error.to_string().contains("a complex quantity states"),
            "{error}"
        );
        assert!(error.line_number().is_some());
    }
    // The same in volts, and in a unit that is none of a covariance.
    let other = |to: &str| cartesian.replace(square, to);
    let volts = "\\volt\\tothe{2}\\second\\tothe{4}\\metre\\tothe{-2}";
    let in_volts = other(volts).replace("<s:valueXMLList>0.01<", "<s:valueXMLList>1e-8<");
    let s = read(&certificate("3.3.0", &in_volts))
        .unwrap()
        .sensitivity(None)
        .unwrap();
    assert!((s.rows[0].phase.unwrap()[1] - 0.01).abs() < 1e-12);
    for no in ["\\volt", "\\one"] {
        let error = read(&certificate("3.3.0", &other(no))).unwrap_err();
        assert!(error.to_string().contains("a covariance in"), "{error}");
    }
    let split = list("frequency", "10 20", "\\hertz", "").replace("10 20", "1<s:x>5</s:x>0 20");
    assert!(
        read(&certificate("3.3.0", &split))
            .unwrap_err()
            .to_string()
            .contains("among numbers")
    );
    // A matrix that is no covariance.
    let wrong = polar.replace("0.01 0.04", "0.01 -0.04");
    assert!(
        read(&certificate("3.3.0", &wrong))
            .unwrap_err()
            .to_string()
            .contains("covariance matrix of value 2")
    );
}

#[test]
fn refuses_with_element_line_and_reason() {
    let list = lists();
    let whole = certificate("3.3.0", &list);
    let line = |text: &str, part: &str| {
        1 + text[..text.find(part).expect(part)].matches('\n').count() as u64
    };
    for (from, to, element, word) in [
        ("10.1 10.2 10.4", "10.1 10.2", "", "3 numbers for 2 values"),
        (
            "0.1 0.1 0.2",
            "0.1 0.1",
            "valueExpandedMUXMLList",
            "2 numbers for 3 values",
        ),
        (
            "10 20 40",
            "10 20 40 80",
            "sensitivity magnitude",
            "3 sensitivities for 4 frequencies",
        ),
        ("10 20 40", "10 20 20", "frequency", "stands twice"),
        (
            "10 20 40",
            "10 20 20.00000000001",
            "frequency",
            "stands twice",
        ),
        ("10 20 40", "0 20 40", "frequency", "out of range"),
        (
            MILLIVOLT,
            "\\pico\\coulomb\\second\\tothe{2}\\metre\\tothe{-1}",
            "sensitivity magnitude",
            "no unit of a sensitivity",
        ),
        (
            "10.1 10.2 10.4",
            "10.1 NaN 10.4",
            "valueXMLList",
            "not a finite number",
        ),
        (
            "10.1 10.2 10.4",
            "10.1 -10.2 10.4",
            "sensitivity magnitude",
            "out of range",
        ),
        ("10.1 10.2 10.4", "", "valueXMLList", "no number"),
        (
            "0.1 0.1 0.2",
            "0.1 INF 0.2",
            "valueExpandedMUXMLList",
            "not a finite number",
        ),
        (
            "0.1 0.1 0.2",
            "0.1 -0.1 0.2",
            "valueExpandedMUXMLList",
            "out of range",
        ),
        ("0.1 0.1 0.2", "6 6 6", "", ""),
        (
            "0.1 0.1 0.2",
            "60 60 60",
            "sensitivity magnitude",
            "more than half",
        ),
        (
            MILLIVOLT,
            "\\volt\\metre\\tothe{-1}",
            "sensitivity magnitude",
            "no unit of a sensitivity",
        ),
        (
            "\\degree",
            "\\kelvin",
            "sensitivity phase",
            "no unit of a phase",
        ),
        ("\\hertz", "\\second", "frequency", "no unit of a frequency"),
        (">2<", ">3<", "coverageFactorXMLList", "contradicts"),
        (">2<", ">0<", "coverageFactorXMLList", "out of range"),
        (
            ">2<",
            ">2 2<",
            "coverageFactorXMLList",
            "2 numbers for 3 values",
        ),
        (">0.95<", ">0.68<", "coverageFactorXMLList", "contradicts"),
        (
            ">0.95<",
            ">95<",
            "coverageProbabilityXMLList",
            "out of range",
        ),
        (
            "frequency<",
            "other<",
            "sensitivity magnitude",
            "without its frequencies",
        ),
        (
            "sensitivity magnitude",
            "gain",
            "",
            "no sensitivity over frequency",
        ),
    ] {
        let text = whole.replacen(from, to, 1);
        assert_ne!(text, whole, "{from}");
        let answer = read(&text).and_then(|c| c.sensitivity(None));
        if word.is_empty() {
            assert!(answer.is_ok());
            continue;
        }
        let error = answer.expect_err(word);
        let said = error.to_string();
        assert!(said.contains(word), "{word}: {said}");
        assert!(said.starts_with("c.xml:") || element.is_empty(), "{said}");
        if !element.is_empty() {
            assert_eq!(error.field(), Some(element), "{said}");
            let near = if element.ends_with("List") {
                to
            } else {
                "<s:realListXMLList>"
            };
            if element.ends_with("List")
                && text.contains(to)
                && !to.is_empty()
                && word != "contradicts"
            {
                assert_eq!(error.line_number(), Some(line(&text, near)), "{said}");
            }
            assert!(error.line_number().is_some(), "{said}");
        }
    }
    for (version, word) in [
        ("1.2.0", "1.2.0"),
        ("", "schemaVersion"),
        ("4.0.0", "4.0.0"),
        ("3.x", "3.x"),
    ] {
        let error = read(&certificate(version, &list)).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
    for no in [
        "<a/>",
        "<html xmlns='http://www.w3.org/1999/xhtml'><p/></html>",
    ] {
        assert!(
            read(no)
                .unwrap_err()
                .to_string()
                .contains("is no digital calibration certificate")
        );
    }
    let twice = list.replace("</s:realListXMLList>", "<s:expandedUncXMLList><s:uncertaintyXMLList>1</s:uncertaintyXMLList><s:coverageFactorXMLList>2</s:coverageFactorXMLList><s:coverageProbabilityXMLList>0.95</s:coverageProbabilityXMLList></s:expandedUncXMLList></s:realListXMLList>");
    assert!(
        read(&certificate("3.3.0", &twice))
            .unwrap_err()
            .to_string()
            .contains("stands twice")
    );
    let silent = lists().replace("expandedMUXMLList", "somethingElse");
    let error = read(&certificate("3.3.0", &silent))
        .unwrap()
        .sensitivity(None)
        .unwrap_err();
    assert!(error.to_string().contains("no uncertainty"), "{error}");
    let two = format!("{list}\n{list}");
    let error = read(&certificate("3.3.0", &two))
        .unwrap()
        .sensitivity(None)
        .unwrap_err();
    assert!(error.to_string().contains("2 sensitivities"), "{error}");
}

#[test]
fn known_doubts_of_phases_and_coverage_factors() {
    let codes = |text: &str| -> Vec<String> {
        let read = read(&certificate("3.3.0", text)).unwrap();
        let table = read.sensitivity(None).unwrap();
        let all = [read.findings(), table.findings].concat();
        all.iter().map(|f| f.code().to_owned()).collect()
    };
    let sound = lists();
    assert!(codes(&sound).is_empty());
    for (phases, unit) in [
        ("-0.1 -0.2 -0.4", "\\radian"),
        ("179 -178 176", "\\degree"),
        ("-60 -20 -3", "\\degree"),
    ] {
        let text = sound.replace("-1 -2 -4", phases).replace("\\degree", unit);
        assert_eq!(codes(&text), [""; 0], "{phases} {unit}");
    }
    for (phases, unit) in [
        ("-1.9 -2.0 -2.1", "\\radian"),
        ("-179 -178 -176", "\\radian"),
        ("-370 -2 -4", "\\degree"),
    ] {
        let text = sound.replace("-1 -2 -4", phases).replace("\\degree", unit);
        assert_eq!(codes(&text), ["phase-unlikely"], "{phases} {unit}");
    }
    // An interval that does not hold its value is doubted, and no standard.
    let interval = |low: &str| {
        let (before, rest) = sound.split_once("<s:expandedMUXMLList>").unwrap();
        let (_, after) = rest.split_once("</s:expandedMUXMLList>").unwrap();
        format!(
            "{before}<s:coverageIntervalMUXMLList><s:valueStandardMUXMLList>0.05</s:valueStandardMUXMLList>\
             <s:intervalMinXMLList>{low}</s:intervalMinXMLList><s:intervalMaxXMLList>10.2 10.3 10.7</s:intervalMaxXMLList>\
             <s:coverageProbabilityXMLList>0.95</s:coverageProbabilityXMLList></s:coverageIntervalMUXMLList>{after}"
        )
    };
    let text = |low: &str| certificate("3.3.0", &interval(low));
    let holds = read(&text("10 10.1 10.2")).unwrap();
    assert!(holds.findings().is_empty() && holds.sensitivity(None).is_ok());
    let not = read(&text("10 10.1 10.5")).unwrap();
    assert_eq!(not.findings()[0].code(), "value-outside-interval");
    let refused = not.sensitivity(None).unwrap_err().to_string();
    assert!(
        refused.contains("10.4 does not lie in its interval"),
        "{refused}"
    );
    // A standard uncertainty that is a hundredth of what its interval says, elements that stand twice or that D-SI does not know, a name
    // that is another's, and what was before an adjustment.
    let thin = text("10 10.1 10.2").replace(">0.05<", ">0.0005<");
    let twice = certificate(
        "3.3.0",
        &sound.replace(
            "<s:valueXMLList>10.1",
            "<s:valueXMLList>11 11 11</s:valueXMLList><s:valueXMLList>10.1",
        ),
    );
    let scaled = certificate(
        "3.3.0",
        &sound.replace(
            "<s:valueXMLList>10.1",
            "<s:scaleXMLList>1000</s:scaleXMLList><s:valueXMLList>10.1",
        ),
    );
    let per_cent = certificate(
        "3.3.0",
        &sound.replace(
            "<s:coverageFactorXMLList>",
            "<s:unitXMLList>\\percent</s:unitXMLList><s:coverageFactorXMLList>",
        ),
    );
    for (text, word) in [
        (&thin, "contradicts the interval"),
        (&twice, "stands twice"),
        (&scaled, "is no part of"),
        (&per_cent, "is no part of"),
    ] {
        let refused = read(text).unwrap_err().to_string();
        assert!(refused.contains(word), "{word}: {refused}");
    }
    let named = sound.replace("<d:quantity><s:realListXMLList><s:labelXMLList>sensitivity magnitude", "<d:quantity refType=\"vib_displacement\"><s:realListXMLList><s:labelXMLList>sensitivity magnitude");
    assert!(named != sound);
    let refused = read(&certificate("3.3.0", &named))
        .unwrap()
        .sensitivity(None)
        .unwrap_err();
    assert!(
        refused.to_string().contains("vib_displacement"),
        "{refused}"
    );
    let before = certificate("3.3.0", &sound).replace(
        "<d:result>",
        "<d:result refType=\"basic_beforeAdjustment\">",
    );
    assert!(read(&before).unwrap().sensitivity(None).is_err());
    // Nor is what calls itself a certificate and is one of another form.
    let foreign =
        certificate("3.3.0", &sound).replace("https://ptb.de/dcc", "https://example.org/dcc");
    assert!(
        read(&foreign)
            .unwrap_err()
            .to_string()
            .contains("another form")
    );
    // k of Student's t: with three degrees of freedom it is doubted, with five it is usual.
    let student = |k: &str| {
        let text = sound.replace(">2<", &format!(">{k}<"));
        text.replace("<s:distributionXMLList>normal</s:distributionXMLList>", "")
    };
    assert!(codes(&student("2.57")).is_empty());
    assert_eq!(codes(&student("3.18")), ["coverage-factor-large"]);
    let found = read(&certificate("3.3.0", &student("3.182")))
        .unwrap()
        .findings();
    assert!(
        found[0].evidence_text().contains("3.0 degrees"),
        "{:?}",
        found[0]
    );
}

#[test]
fn known_signature_is_found_and_never_valid() {
    let signed = certificate("3.3.0", &lists()).replace(
        "</d:digitalCalibrationCertificate>",
        "<x:Signature xmlns:x=\"http://www.w3.org/2000/09/xmldsig#\"/></d:digitalCalibrationCertificate>",
    );
    let c = read(&signed).unwrap();
    assert_eq!(c.signatures.len(), 1);
    let findings = c.findings();
    assert_eq!(findings[0].code(), "signature-not-checked");
    assert!(!findings[0].what().contains("valid"));
}

/// No damage makes it panic, take long or answer with another number of rows than there are.
#[test]
fn law_damage_is_refused_or_read_whole() {
    let whole = certificate("3.3.0", &lists());
    let mut seed = 1u64;
    let mut chance = |n: usize| {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % n
    };
    for _ in 0..2000 {
        let mut bytes = whole.clone().into_bytes();
        for _ in 0..=chance(3) {
            let at = chance(bytes.len());
            match chance(3) {
                0 => bytes[at] = b"<>/\"&;0 9.-NaeE\x00\xff{}\\"[chance(20)],
                1 => {
                    bytes.remove(at);
                }
                _ => bytes.truncate(at.max(1)),
            }
        }
        let source = Source::from_bytes("c.xml", bytes).unwrap();
        if let Ok(c) = DigitalCertificate::from_source(source)
            && let Ok(s) = c.sensitivity(None)
        {
            let sound =
                |r: &proofmass_documents::SensitivityRow| r.frequency > 0.0 && r.sensitivity > 0.0;
            assert!(!s.rows.is_empty() && s.rows.iter().all(sound));
        }
    }
}

fn data() -> PathBuf {
    let data = std::env::var_os("PROOFMASS_REFERENCE_DATA");
    PathBuf::from(
        data.expect("PROOFMASS_REFERENCE_DATA names the folder, see docs/reference-data.md"),
    )
}

#[test]
#[ignore = "needs PROOFMASS_REFERENCE_DATA, see docs/reference-data.md"]
fn published_certificates_and_examples_are_read() {
    let open = |name: &str| {
        let path = data().join(name);
        let c = DigitalCertificate::from_source(Source::open(&path).unwrap());
        c.unwrap_or_else(|e| panic!("{e}"))
    };
    for (name, version, quantities, signatures) in [
        ("dcc/valid-3.3.0.xml", Some("3.3.0"), 0, 0),
        ("dcc/dcc_gp_temperature_typical_v12.xml", None, 0, 0),
        ("dcc/si-acceleration-examples.xml", None, 20, 0),
        ("doors/dcc/siliziumkugel.xml", Some("2.3.0"), 8, 0),
        (
            "doors/dcc/dcc_gp_temperatur_resistance_v12.xml",
            Some("3.1.1"),
            0,
            0,
        ),
        (
            "doors/dcc/dcc_gp_temperature_typical_v12_v3.2.0_signed.xml",
            Some("3.2.0"),
            0,
            1,
        ),
        (
            "doors/dcc/2021-10-26-PLATINUM-examples-xmllists.xml",
            None,
            0,
            0,
        ),
        (
            "doors/dcc/2021-10-26-GOLD-examples-xmllists.xml",
            None,
            0,
            0,
        ),
    ] {
        let c = open(name);
        println!("{name}: {:?} {} quantities", c.version, c.quantities.len());
        if version.is_some() {
            assert_eq!(c.version.as_deref(), version, "{name}");
        }
        assert!(
            !c.quantities.is_empty() && c.quantities.len() >= quantities,
            "{name}"
        );
        assert_eq!(c.signatures.len(), signatures, "{name}");
    }
    let lists = open("doors/dcc/accelerometer_lists.xml")
        .sensitivity(None)
        .unwrap();
    let old = open("doors/dcc/accelerometer_lists_2021.xml")
        .sensitivity(None)
        .unwrap();
    assert_eq!(lists.rows.len(), 17);
    assert_eq!(lists.rows[16].sensitivity, 6.974195 * 1e-3);
    assert_eq!(
        lists.rows[0].sensitivity_uncertainty,
        0.0044199 * 1e-3 / 2.0
    );
    for (a, b) in lists.rows.iter().zip(&old.rows) {
        assert_eq!((a.frequency, a.sensitivity), (b.frequency, b.sensitivity));
        // The older one states the phase in radian with five decimals.
        assert!((a.phase.unwrap()[0] - b.phase.unwrap()[0]).abs() < 6e-6);
    }
    let wrong = data().join("doors/dcc/accelerometer_wrong_length.xml");
    let wrong = DigitalCertificate::from_source(Source::open(wrong).unwrap()).unwrap_err();
    assert!(
        wrong.to_string().contains("17 numbers for 16 values"),
        "{wrong}"
    );
    assert_eq!(wrong.line_number(), Some(279));
}
