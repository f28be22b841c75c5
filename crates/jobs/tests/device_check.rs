//! Devices against their data sheet: verdicts computed by hand, how often they err, what is doubted and what is refused.

use proofmass_documents::{Device, ResultDocument};
use proofmass_io::Input;
use proofmass_jobs::data_sheet::{DataSheet, SheetLimit, sheet};
use proofmass_jobs::device_check::{
    DeviceCheckData, DeviceCheckJob, DeviceCheckOutcome, DeviceResult, JudgedLimit, SheetVerdict,
};
use proofmass_jobs::{Job, Outcome, Trouble, Unwatched};
use proofmass_uncertainty::{
    Component, Covariance, DegreesOfFreedom, Effect, Estimate, Evaluation, Influence, Quantity,
};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const G: f64 = 9.80665;

/// A result.json in a folder.
struct File<'a> {
    place: &'a str,
    kind: &'a str,
    serial: Option<&'a str>,
    model: Option<&'a str>,
}

/// One that states these quantities: name, unit, value, u.
fn stating(file: &File<'_>, quantities: &[(&str, &str, f64, f64)]) -> DeviceResult {
    let mut document = ResultDocument::new(file.kind).device(&device(file));
    for &(name, unit, value, u) in quantities {
        let quantity = Quantity {
            name: name.into(),
            unit: unit.into(),
            value,
            standard_uncertainty: u,
            dof: DegreesOfFreedom::INFINITE,
        };
        document = document.quantity(&quantity, 0.95);
    }
    read(file, &document).expect("a result")
}

fn device(file: &File<'_>) -> Device {
    Device {
        serial: file.serial.map(str::to_owned),
        model: file.model.map(str::to_owned),
        ..Device::default()
    }
}

fn read(file: &File<'_>, document: &ResultDocument) -> Result<DeviceResult, Trouble> {
    let folder = file.place.split('/').next().unwrap_or_default();
    let name = format!("{}/result.json", file.place);
    let input = Input {
        path: name.clone(),
        sha256: name.clone(),
        ..Input::default()
    };
    DeviceResult::from_json(folder, name, &document.to_json().expect("JSON"), input)
}

/// A calibration at rest of the device 7.
fn calibration(quantities: &[(&str, &str, f64, f64)]) -> DeviceResult {
    stating(&at("unit/calibration", "multi-position"), quantities)
}

fn at<'a>(place: &'a str, kind: &'a str) -> File<'a> {
    File {
        place,
        kind,
        serial: Some("7"),
        model: None,
    }
}

fn judge(text: &str, results: &[DeviceResult]) -> Result<DeviceCheckOutcome, Trouble> {
    let mut job = DeviceCheckJob::default();
    job.sheet = sheet(text)?;
    job.evaluate(&DeviceCheckData { results }, &Unwatched)
}

fn judged(text: &str, results: &[DeviceResult]) -> DeviceCheckOutcome {
    judge(text, results).unwrap_or_else(|e| panic!("{text}: {e} {:?}", e.place()))
}

/// The one limit of one device.
fn only(outcome: &DeviceCheckOutcome) -> &JudgedLimit {
    let [device] = outcome.devices() else {
        panic!("{:?}", outcome.devices());
    };
    let [row] = &device.limits[..] else {
        panic!("{:?}", device.limits);
    };
    row
}

fn found(outcome: &DeviceCheckOutcome, code: &str) -> bool {
    outcome.findings().iter().any(|f| f.code() == code)
}

fn limit(lines: &str) -> String {
    format!("[[limit]]\n{}\n", lines.replace("; ", "\n"))
}

/// The Zener diode of JCGM 106, 7.4, example 1, and 8.3.2: −5.47 V with u = 0.05 V against −5.40 V at most conforms with 92 %;
/// by its value it is accepted, with a guard band of U it is not.
#[test]
fn published_conformity_of_a_voltage() {
    let results = [calibration(&[("bias.x", "V", -5.47, 0.05)])];
    let text = limit("characteristic = \"bias\"; upper = -5.40; unit = \"V\"");
    let guarded = judged(&text, &results);
    let row = only(&guarded);
    let conforms = row.shown.as_ref().and_then(|s| s.conforms).unwrap();
    assert!((conforms - 0.92).abs() < 0.005, "{conforms}");
    assert_eq!(row.verdict, SheetVerdict::Undecided);
    assert!(found(&guarded, "limit-undecided"));
    let simple = judged(&format!("[decision]\nrule = \"simple\"\n{text}"), &results);
    assert_eq!(only(&simple).verdict, SheetVerdict::Pass);
    // A guard band of a half of U, 0.049 V: −5.421 V lies within the limit.
    let half = judged(&format!("[decision]\nr = 0.5\n{text}"), &results);
    assert_eq!(only(&half).verdict, SheetVerdict::Pass);
}

/// Verdicts and probabilities by hand: U = 1.96 u.
#[test]
fn known_verdicts_by_hand() {
    use SheetVerdict::{Fail, Pass, Undecided};
    for (lines, quantity, verdict, chance) in [
        // 0.40 ± 0.098 m/s² against 0.490 m/s²: Φ(1.8067).
        (
            "characteristic = \"bias\"; most = 50; unit = \"mg\"",
            ("bias.x", "m/s²", 0.40, 0.05),
            Undecided,
            0.964_60,
        ),
        // 0.30 + 0.098 lies within, −0.60 + 0.098 beyond.
        (
            "characteristic = \"bias\"; most = 50; unit = \"mg\"",
            ("bias.x", "m/s²", 0.30, 0.05),
            Pass,
            0.999_93,
        ),
        (
            "characteristic = \"bias\"; most = 50; unit = \"mg\"",
            ("bias.x", "m/s²", -0.60, 0.05),
            Fail,
            0.014_15,
        ),
        // 665 mV/g = 67.811 mV/(m/s²); 660 ± 3 % reaches to 679.8.
        (
            "characteristic = \"scale\"; nominal = 660; \"tolerance_%\" = 3; unit = \"mV/g\"",
            ("scale.x", "V/(m/s²)", 665e-3 / G, 4e-3 / G),
            Pass,
            0.999_89,
        ),
        (
            "characteristic = \"misalignment\"; most = 1; unit = \"%\"",
            ("misalignment.xy", "rad", 0.012, 0.000_5),
            Fail,
            0.000_03,
        ),
        (
            "characteristic = \"scale-temperature\"; most = 0.01; unit = \"%/K\"",
            ("scale.x.T1", "1/K", 9e-5, 1e-6),
            Pass,
            1.0,
        ),
    ] {
        let outcome = judged(&limit(lines), &[calibration(&[quantity])]);
        let row = only(&outcome);
        assert_eq!(row.verdict, verdict, "{lines} {quantity:?}");
        let conforms = row.shown.as_ref().and_then(|s| s.conforms).unwrap();
        assert!((conforms - chance).abs() < 2e-5, "{lines}: {conforms}");
        assert_eq!(found(&outcome, "beyond-limit"), verdict == Fail, "{lines}");
    }
}

/// A device exactly at its limit fails in 2.5 % of all measurements and passes in as many; one that lies U within it never
/// fails and passes in half; by its value alone it fails in half at the limit.
#[test]
fn coverage_of_the_decision_rule() {
    let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(21);
    let (u, n) = (0.01, 2000);
    let mut count = |rule: &str, truth: f64| -> [u32; 2] {
        let mut counts = [0; 2];
        let text = limit("characteristic = \"bias\"; upper = 1; unit = \"m/s²\"");
        for _ in 0..n {
            let z: f64 = StandardNormal.sample(&mut rng);
            let results = [calibration(&[("bias.x", "m/s²", truth + u * z, u)])];
            let outcome = judged(&format!("[decision]\nrule = \"{rule}\"\n{text}"), &results);
            match only(&outcome).verdict {
                SheetVerdict::Pass => counts[0] += 1,
                SheetVerdict::Fail => counts[1] += 1,
                _ => {}
            }
        }
        counts
    };
    // √(2000 · 0.025 · 0.975) = 7, √(2000/4) = 22: three and a half of them.
    let [pass, fail] = count("guard-band", 1.0);
    assert!(
        (26..=74).contains(&pass) && (26..=74).contains(&fail),
        "{pass} {fail}"
    );
    let [pass, fail] = count("guard-band", 1.0 - 1.96 * u);
    assert!((922..=1078).contains(&pass) && fail <= 2, "{pass} {fail}");
    let [pass, fail] = count("simple", 1.0);
    assert!(
        (922..=1078).contains(&pass) && pass + fail == n,
        "{pass} {fail}"
    );
}

/// A bias in counts against a limit in mg: b/S with the covariance of both, by hand.
#[test]
fn known_bias_of_a_raw_output_is_divided_by_the_scale() {
    let (b, s, ub, us, r) = (85.0, 415.0, 2.0, 1.5, 0.4);
    let rows = [ub * ub, r * ub * us, r * ub * us, us * us];
    let influence = Influence {
        key: "noise".into(),
        description: "noise".into(),
        evaluation: Evaluation::A,
        distribution: "normal".into(),
        dof: DegreesOfFreedom::INFINITE,
        effect: Effect::Joint {
            covariance: Covariance::try_from_rows(2, &rows).unwrap(),
        },
    };
    let components = vec![
        Component::new("bias.x", "count", b),
        Component::new("scale.x", "count/(m/s²)", s),
    ];
    let estimate = Estimate::new(components, vec![influence]).unwrap();
    let file = at("unit/calibration", "multi-position");
    let document = ResultDocument::new(file.kind)
        .device(&device(&file))
        .estimate(&estimate, 0.95);
    let results = [read(&file, &document).unwrap()];
    let text = limit("characteristic = \"bias\"; most = 25; unit = \"mg\"");
    let outcome = judged(&text, &results);
    let shown = only(&outcome).shown.clone().unwrap();
    let mg = 1e3 / G;
    let u2 = (ub / s).powi(2) + (b * us / (s * s)).powi(2) - 2.0 * r * ub * us * b / s.powi(3);
    let (value, half) = (b / s * mg, 1.959_964 * u2.sqrt() * mg);
    assert!((shown.value.unwrap() - value).abs() < 1e-9);
    assert!((shown.high - value - half).abs() < 1e-5, "{shown:?} {half}");
    assert_eq!(only(&outcome).verdict, SheetVerdict::Pass);
    // A device that gives 80 counts by design is 5 counts off.
    let designed = format!("[output]\nzero = 80\nunit = \"LSB\"\n{text}");
    let shown = only(&judged(&designed, &results)).shown.clone().unwrap();
    assert!((shown.value.unwrap() - 5.0 / s * mg).abs() < 1e-9);
    // Without a scale beside it nothing can be said.
    let alone = [calibration(&[("bias.x", "count", b, ub)])];
    let outcome = judged(&text, &alone);
    assert_eq!(only(&outcome).verdict, SheetVerdict::NotShown);
    assert!(found(&outcome, "limit-not-convertible"));
}

/// Over a band the gravest frequency decides; what lies outside does not count.
#[test]
fn known_limit_over_a_band() {
    let file = at("unit/shaker", "shaker-single");
    let at_frequency = |f: f64, value: f64| (format!("S.modulus[frequency={f}]"), value);
    let points = [
        at_frequency(10.0, 10.02),
        at_frequency(160.0, 10.0),
        at_frequency(800.0, 10.35),
        at_frequency(5000.0, 12.0),
    ];
    let all: Vec<(&str, &str, f64, f64)> = points
        .iter()
        .map(|(name, v)| (name.as_str(), "mV/(m/s²)", *v, 0.02))
        .collect();
    let results = [stating(&file, &all)];
    let text = |band: &str| {
        limit(&format!(
            "characteristic = \"scale\"; nominal = 10; \"tolerance_%\" = 3; unit = \"mV/(m/s²)\"; frequency_Hz = {band}"
        ))
    };
    let outcome = judged(&text("[10, 800]"), &results);
    let row = only(&outcome);
    assert_eq!(row.verdict, SheetVerdict::Fail);
    assert_eq!(row.shown.as_ref().unwrap().frequency, Some(800.0));
    assert!(
        !outcome
            .findings()
            .iter()
            .any(|f| f.code() == "limit-band-not-covered")
    );
    let outcome = judged(&text("[10, 500]"), &results);
    assert_eq!(only(&outcome).verdict, SheetVerdict::Pass);
    assert!(found(&outcome, "limit-band-not-covered"));
    let outcome = judged(&text("[6000, 9000]"), &results);
    assert_eq!(only(&outcome).verdict, SheetVerdict::NotShown);
}

#[test]
fn known_findings_of_results_that_do_not_suffice() {
    let bias = limit("characteristic = \"bias\"; most = 50; unit = \"mg\"");
    let first = calibration(&[("bias.x", "m/s²", 0.10, 0.01)]);
    let other = |value: f64, u: f64| {
        stating(
            &at("unit/zero-g", "static-test"),
            &[("bias.x", "m/s²", value, u)],
        )
    };
    // 0.10 and 0.16 with u = 0.01 each are 4.2 standard uncertainties apart.
    let outcome = judged(&bias, &[first.clone(), other(0.16, 0.01)]);
    assert_eq!(only(&outcome).verdict, SheetVerdict::Undecided);
    assert!(found(&outcome, "results-contradict"));
    // Of two that agree the better known one decides.
    let outcome = judged(&bias, &[first.clone(), other(0.13, 0.2)]);
    assert_eq!(only(&outcome).verdict, SheetVerdict::Pass);
    assert_eq!(outcome.findings(), []);
    // What nothing measures.
    let more = bias.clone() + &limit("characteristic = \"resonance\"; lower = 2; unit = \"kHz\"");
    let outcome = judged(&more, std::slice::from_ref(&first));
    assert_eq!(outcome.devices()[0].count(SheetVerdict::NotShown), 1);
    assert_eq!(outcome.devices()[0].verdict(), SheetVerdict::NotShown);
    assert!(found(&outcome, "limit-not-shown"));
    // An axis that nothing measures.
    let axes =
        limit("characteristic = \"bias\"; most = 50; unit = \"mg\"; channels = [\"x\", \"z\"]");
    let outcome = judged(&axes, std::slice::from_ref(&first));
    let verdicts: Vec<_> = outcome.devices()[0]
        .limits
        .iter()
        .map(|row| (row.axis.as_str(), row.verdict))
        .collect();
    assert_eq!(
        verdicts,
        [("x", SheetVerdict::Pass), ("z", SheetVerdict::NotShown)]
    );
    // ± 0.49 m/s² against U = 0.98 m/s².
    let outcome = judged(&bias, &[calibration(&[("bias.x", "m/s²", 0.0, 0.5)])]);
    assert_eq!(only(&outcome).verdict, SheetVerdict::Undecided);
    assert!(found(&outcome, "guard-band-too-wide"));
    // A result without a serial number belongs to the device beside it.
    let nameless = File {
        serial: None,
        ..at("unit/zero-g", "static-test")
    };
    let results = [first, stating(&nameless, &[("bias.x", "m/s²", 0.11, 0.01)])];
    let outcome = judged(&bias, &results);
    assert_eq!(outcome.devices()[0].name(), "7");
    assert!(found(&outcome, "device-from-folder"));
    // At another temperature, or an unknown one.
    let cold =
        limit("characteristic = \"bias\"; most = 50; unit = \"mg\"; temperature_degC = [-40, 0]");
    let outcome = judged(&cold, &results[..1]);
    assert_eq!(only(&outcome).verdict, SheetVerdict::NotShown);
    assert!(only(&outcome).why.contains("temperatures"));
}

#[test]
fn known_devices_of_one_call() {
    let bias = limit("characteristic = \"bias\"; most = 50; unit = \"mg\"");
    let unit = |place: &'static str, serial: Option<&'static str>, value: f64| {
        let file = File {
            place,
            kind: "multi-position",
            serial,
            model: None,
        };
        stating(
            &file,
            &[
                ("bias.x", "m/s²", value, 0.01),
                ("bias.y", "m/s²", 0.0, 0.01),
            ],
        )
    };
    let results = [
        unit("lab/a/calibration", Some("A"), 0.1),
        unit("lab/b/calibration", Some("B"), 0.9),
        // The dots of a form are no serial number.
        unit("other/calibration", Some("…"), 0.2),
    ];
    let outcome = judged(&bias, &results);
    let told: Vec<_> = outcome
        .devices()
        .iter()
        .map(|d| (d.name(), d.verdict()))
        .collect();
    assert_eq!(
        told,
        [
            ("A", SheetVerdict::Pass),
            ("B", SheetVerdict::Fail),
            ("other", SheetVerdict::Pass)
        ]
    );
    // In a folder with several serial numbers nobody knows whose it is.
    let results = [
        results[0].clone(),
        results[1].clone(),
        unit("lab/c/calibration", None, 0.1),
    ];
    let trouble = judge(&bias, &results).unwrap_err();
    assert!(
        trouble.to_string().contains("no serial number"),
        "{trouble}"
    );
    assert!(
        trouble.place()[0].contains("lab/c/calibration"),
        "{trouble:?}"
    );
}

/// Limits of 5 mg and 0.1 mg [ElSheimy2020, Table 1].
#[test]
fn published_limits_of_grades() {
    let bias = limit("characteristic = \"bias\"; most = 50; unit = \"mg\"");
    let verdicts = |value: f64| {
        let results = [calibration(&[("bias.x", "m/s²", value * 1e-3 * G, 1e-6)])];
        let outcome = judged(&bias, &results);
        let grades = &outcome.devices()[0].grades;
        let told: Vec<_> = grades.iter().map(|g| (g.name.clone(), g.verdict)).collect();
        assert_eq!(outcome.devices()[0].grade(), None, "the noise is not known");
        told
    };
    use SheetVerdict::{Fail, NotShown};
    let told = verdicts(7.0);
    let expected = [
        ("consumer", NotShown),
        ("industrial", NotShown),
        ("tactical", Fail),
        ("navigation", Fail),
    ];
    assert_eq!(told, expected.map(|(n, v)| (n.to_owned(), v)));
    assert_eq!(verdicts(0.5)[2].1, NotShown);
    assert_eq!(verdicts(0.5)[3].1, Fail);
    assert_eq!(verdicts(0.05)[3].1, NotShown);
    // Limits of one's own in their place.
    let own = "[[grade]]\nname = \"lab\"\nsource = \"house\"\n[[grade.limit]]\ncharacteristic = \"bias\"\nmost = 8\nunit = \"mg\"\n";
    let results = [calibration(&[("bias.x", "m/s²", 7e-3 * G, 1e-6)])];
    let outcome = judged(&format!("{bias}{own}"), &results);
    assert_eq!(outcome.devices()[0].grade(), Some("lab"));
}

#[test]
fn refuses_results_that_cannot_be_judged() {
    let bias = limit("characteristic = \"bias\"; most = 50; unit = \"mg\"");
    let stated = [("bias.x", "m/s²", 0.1, 0.01)];
    let refused = |text: &str, results: &[DeviceResult], what: &str, place: &str| {
        let trouble = judge(text, results).expect_err(what);
        assert!(trouble.to_string().contains(what), "{trouble}");
        assert!(trouble.place().join("; ").contains(place), "{trouble:?}");
        assert!(trouble.hint().is_some(), "{trouble}");
    };
    refused(&bias, &[], "no result", "");
    let other = File {
        model: Some("B-2"),
        ..at("unit/b", "multi-position")
    };
    let of_a_model = format!("[device]\nmodel = \"A-1\"\n{bias}");
    refused(
        &of_a_model,
        &[stating(&other, &stated)],
        "its model is B-2, that of the sheet A-1",
        "unit/b/result.json, device.model",
    );
    let of_a_serial = format!("[device]\nserial = \"8\"\n{bias}");
    refused(
        &of_a_serial,
        &[calibration(&stated)],
        "its serial number is 7",
        "device.serial",
    );
    let same = calibration(&stated);
    refused(
        &bias,
        &[same.clone(), same.clone()],
        "given twice",
        "unit/calibration",
    );
    let budget = stating(
        &at("unit/budget", "uncertainty"),
        &[("bias", "m/s²", 0.1, 0.01)],
    );
    refused(
        &bias,
        &[budget],
        "measures anything of a device",
        "uncertainty",
    );
    // Numbers that are none of a quantity.
    let file = at("unit/changed", "multi-position");
    let mut document = ResultDocument::new(file.kind).device(&device(&file));
    let quantity = |u: f64| Quantity {
        name: "bias.x".into(),
        unit: "m/s²".into(),
        value: 0.1,
        standard_uncertainty: u,
        dof: DegreesOfFreedom::INFINITE,
    };
    document = document.quantity(&quantity(0.01), 0.95);
    document.quantities[0].expanded = -1.0;
    let trouble = read(&file, &document).unwrap_err();
    assert!(trouble.to_string().contains("states bias.x"), "{trouble}");
    let mut sheet = DataSheet::default();
    sheet.limit = vec![SheetLimit::most("bias", 50.0, "mg")];
    let mut job = DeviceCheckJob::default();
    (job.sheet, job.false_alarm_rate) = (sheet, 1.5);
    let results = [same];
    let refused = job.evaluate(&DeviceCheckData { results: &results }, &Unwatched);
    assert!(refused.unwrap_err().to_string().contains("no probability"));
}
