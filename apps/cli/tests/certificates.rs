//! Calibration certificates: read, taken as standards, drafted and released.

mod support;

use std::fmt::Write as _;
use std::path::Path;
use support::*;

/// A certificate of a reference accelerometer: sensitivity and phase at five frequencies, U with k = 2.
fn dcc(
    sensitivity: &str,
    unit: &str,
    u: &str,
    phase: &str,
    phase_unit: &str,
    u_phase: &str,
    end: &str,
) -> String {
    let list = |label: &str, values: &str, unit: &str, u: &str| {
        let stated = match u {
            "" => String::new(),
            u => format!(
                "<si:measurementUncertaintyUnivariateXMLList><si:expandedMUXMLList><si:valueExpandedMUXMLList>{u}</si:valueExpandedMUXMLList>\
                 <si:coverageFactorXMLList>2</si:coverageFactorXMLList><si:coverageProbabilityXMLList>0.95</si:coverageProbabilityXMLList>\
                 <si:distributionXMLList>normal</si:distributionXMLList></si:expandedMUXMLList></si:measurementUncertaintyUnivariateXMLList>"
            ),
        };
        format!(
            "<dcc:quantity><si:realListXMLList><si:labelXMLList>{label}</si:labelXMLList><si:valueXMLList>{values}</si:valueXMLList>\
             <si:unitXMLList>{unit}</si:unitXMLList>{stated}</si:realListXMLList></dcc:quantity>\n"
        )
    };
    format!(
        "<dcc:digitalCalibrationCertificate xmlns:dcc=\"https://ptb.de/dcc\" xmlns:si=\"https://ptb.de/si\" schemaVersion=\"3.3.0\">\n\
         <dcc:administrativeData><dcc:coreData><dcc:uniqueIdentifier>PTB-17</dcc:uniqueIdentifier></dcc:coreData></dcc:administrativeData>\n\
         <dcc:measurementResults><dcc:measurementResult><dcc:results><dcc:result><dcc:data><dcc:list>\n{}{}{}</dcc:list></dcc:data>\
         </dcc:result></dcc:results></dcc:measurementResult></dcc:measurementResults>\n{end}</dcc:digitalCalibrationCertificate>\n",
        list("frequency", "10 40 80 160 1000", "\\hertz", ""),
        list("sensitivity magnitude", sensitivity, unit, u),
        list("sensitivity phase", phase, phase_unit, u_phase),
    )
}

const S: &str = "10.1317 10.1205 10.1190 10.1174 10.1139";
const U: &str = "0.0507 0.0304 0.0303 0.0303 0.0506";
const PHASE: &str = "-1.93 -2.01 -2.07 -2.11 -2.42";
const U_PHASE: &str = "0.5 0.3 0.3 0.3 0.6";
const MILLIVOLT: &str = "\\milli\\volt\\second\\tothe{2}\\metre\\tothe{-1}";
const SIGNATURE: &str = "<ds:Signature xmlns:ds=\"http://www.w3.org/2000/09/xmldsig#\"/>\n";

fn printed(list: &str, f: impl Fn(f64) -> String) -> String {
    let words: Vec<String> = list.split(' ').map(|w| f(w.parse().unwrap())).collect();
    words.join(" ")
}

/// A comparison of a device with a reference in volts; `reference` is the section about it.
fn comparison(folder: &Path, reference: &str) {
    campaign(
        folder,
        &format!(
            "kind = \"shaker-single\"\n[device]\nmanufacturer = \"Maker\"\nmodel = \"A-1\"\nserial = \"4711\"\n[runs]\nfile = \"runs.csv\"\n\
             [reading]\nu_relative = 0.001\nu_phase_deg = 0.1\n[reference]\n{reference}\n"
        ),
    );
    let mut runs =
        "run,frequency_Hz,transverse_%,reference_V,reference_phase_deg,output_V,output_phase_deg\n"
            .to_owned();
    for (i, f) in [12.5, 20.0, 63.0, 80.0, 315.0, 800.0].iter().enumerate() {
        for k in 0..3 {
            writeln!(runs, "r{i}{k},{f},2,0.1,3,0.0{}7{k},1.{k}", 96 + i).unwrap();
        }
    }
    std::fs::write(folder.join("runs.csv"), runs).unwrap();
}

/// What a command prints that succeeds.
fn says(arguments: &[&str]) -> String {
    String::from_utf8(succeed(arguments).stdout).unwrap()
}

/// What a result states, without the names and digests of the files it came from.
fn stated(folder: &Path) -> serde_json::Value {
    let result = json(&folder.join("result/result.json"));
    serde_json::json!([
        result["quantities"],
        result["covariance"],
        result["estimate"]
    ])
}

fn numbers(folder: &Path) -> Vec<f64> {
    let all = stated(folder);
    let quantities = all[0].as_array().unwrap();
    quantities
        .iter()
        .map(|q| q["value"].as_f64().unwrap())
        .collect()
}

#[test]
fn law_a_certificate_as_standard_gives_what_its_numbers_typed_in_give() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let columns: Vec<Vec<&str>> = ["10 40 80 160 1000", S, U, PHASE, U_PHASE]
        .iter()
        .map(|l| l.split(' ').collect())
        .collect();
    let mut table =
        "frequency_Hz,sensitivity_mV/(m/s2),U_sensitivity_mV/(m/s2),phase_deg,U_phase_deg\n"
            .to_owned();
    for i in 0..5 {
        let row: Vec<&str> = columns.iter().map(|c| c[i]).collect();
        writeln!(table, "{}", row.join(",")).unwrap();
    }
    std::fs::write(folder.join("reference.csv"), table).unwrap();
    comparison(folder, "file = \"reference.csv\"\nk = 2");
    succeed(&["calibrate", text(folder)]);
    let typed = stated(folder);
    let typed_numbers = numbers(folder);

    let write = |text: String| std::fs::write(folder.join("reference.xml"), text).unwrap();
    write(dcc(S, MILLIVOLT, U, PHASE, "\\degree", U_PHASE, ""));
    comparison(folder, "certificate = \"reference.xml\"");
    succeed(&["calibrate", text(folder)]);
    assert_eq!(stated(folder), typed, "bit for bit");
    let result = json(&folder.join("result/result.json"));
    assert!(result.to_string().contains("certificate PTB-17"));
    assert!(codes(&result).is_empty(), "{:?}", codes(&result));

    // In volts, the phase in radian: the same within the rounding of one product and one quotient.
    let radian = |list: &str| printed(list, |v| v.to_radians().to_string());
    let volt = |list: &str| printed(list, |v| format!("{v}e-3"));
    write(dcc(
        &volt(S),
        "\\volt\\second\\tothe{2}\\metre\\tothe{-1}",
        &volt(U),
        &radian(PHASE),
        "\\radian",
        &radian(U_PHASE),
        "",
    ));
    succeed(&["calibrate", text(folder)]);
    // Modulus and phase in turn; an error of the phase is one of S, relative to |S|.
    for (i, (a, b)) in numbers(folder).iter().zip(&typed_numbers).enumerate() {
        let near = match i % 2 {
            0 => a.to_bits().abs_diff(b.to_bits()) <= 4,
            _ => (a - b).abs() <= 4.0 * f64::EPSILON,
        };
        assert!(near, "{a} {b}");
    }
}

#[test]
fn refuses_a_signed_certificate_as_standard_unless_it_is_accepted_by_its_number() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // A foreign signature over a value that was changed.
    let signed = dcc(S, MILLIVOLT, U, PHASE, "\\degree", U_PHASE, SIGNATURE);
    std::fs::write(folder.join("reference.xml"), signed).unwrap();
    comparison(folder, "certificate = \"reference.xml\"");
    let said = refuse(&["calibrate", text(folder)]);
    assert!(
        said.contains("does not check") && said.contains("accept_unchecked_signature = \"PTB-17\""),
        "{said}"
    );
    assert!(!folder.join("result").exists());
    comparison(
        folder,
        "certificate = \"reference.xml\"\naccept_unchecked_signature = \"PTB-18\"",
    );
    assert!(refuse(&["calibrate", text(folder)]).contains("does not check"));
    comparison(
        folder,
        "certificate = \"reference.xml\"\naccept_unchecked_signature = \"PTB-17\"",
    );
    succeed(&["calibrate", text(folder)]);
    assert_eq!(
        codes(&json(&folder.join("result/result.json"))),
        ["signature-not-checked"]
    );
    let said = says(&["certificate", "read", text(&folder.join("reference.xml"))]);
    assert!(
        said.contains("not checked") && !said.contains("is valid"),
        "{said}"
    );
}

#[test]
fn known_certificate_is_read_as_a_table_and_as_json() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("c.xml");
    std::fs::write(&file, dcc(S, MILLIVOLT, U, PHASE, "\\degree", U_PHASE, "")).unwrap();
    let said = says(&["certificate", "read", text(&file)]);
    for part in [
        "PTB-17",
        "DCC 3.3.0",
        "mV·s²/m",
        "sensitivity phase",
        "1000",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let json: serde_json::Value =
        serde_json::from_str(&says(&["certificate", "read", text(&file), "--json"])).unwrap();
    assert_eq!(json["sensitivity"].as_array().unwrap().len(), 5);
    assert_eq!(json["sensitivity"][4]["sensitivity"], 10.1139 * 1e-3);
    // What cannot be a standard is read all the same, and says why.
    std::fs::write(
        &file,
        dcc(
            S,
            "\\volt\\metre\\tothe{-1}",
            U,
            PHASE,
            "\\degree",
            U_PHASE,
            "",
        ),
    )
    .unwrap();
    let said = says(&["certificate", "read", text(&file)]);
    assert!(
        said.contains("cannot be the standard") && said.contains("no unit of a sensitivity"),
        "{said}"
    );
    std::fs::write(
        &file,
        dcc("1 2 3 4 NaN", MILLIVOLT, U, PHASE, "\\degree", U_PHASE, ""),
    )
    .unwrap();
    assert!(refuse(&["certificate", "read", text(&file)]).contains("valueXMLList"));
    std::fs::write(
        &file,
        "<!DOCTYPE a [<!ENTITY x SYSTEM \"/etc/passwd\">]><a>&x;</a>",
    )
    .unwrap();
    assert!(refuse(&["certificate", "read", text(&file)]).contains("nothing outside of the file"));
}
