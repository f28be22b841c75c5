//! The file of a data sheet: what its limits mean, its units, and what is refused with its place.

use proofmass_jobs::Trouble;
use proofmass_jobs::data_sheet::{ReadLimit, sheet, unit_ratio};

fn read(text: &str) -> Result<Vec<ReadLimit>, Trouble> {
    sheet(text)?
        .limit
        .iter()
        .map(|limit| limit.read())
        .collect()
}

/// One limit, in the words of a file.
fn one(lines: &str) -> ReadLimit {
    read(&format!("[[limit]]\n{lines}\n"))
        .unwrap_or_else(|e| panic!("{lines}: {e}"))
        .remove(0)
}

#[test]
fn known_forms_of_a_limit() {
    let both = |l: &ReadLimit| (l.limits.lower, l.limits.upper);
    let bias = one("characteristic = \"zero-g offset\"\nmost = 50\nunit = \"mg\"");
    assert_eq!(both(&bias), (Some(-50.0), Some(50.0)));
    assert_eq!(bias.words(), "± 50 mg");
    // 660 mV/g ± 3 %.
    let scale = one(
        "characteristic = \"sensitivity\"\nnominal = 660\n\"tolerance_%\" = 3\nunit = \"mV/g\"",
    );
    let (Some(low), Some(high)) = both(&scale) else {
        panic!("{scale:?}");
    };
    assert!((low - 640.2).abs() < 1e-9 && (high - 679.8).abs() < 1e-9);
    assert_eq!(scale.words(), "640.2 to 679.8 mV/g");
    let resonance = one("characteristic = \"resonance\"\nlower = 2.4\nunit = \"kHz\"");
    assert_eq!(both(&resonance), (Some(2.4), None));
    // What has no sign has no lower limit.
    let across = one("characteristic = \"transverse\"\nmost = 5\nunit = \"%\"");
    assert_eq!(both(&across), (None, Some(5.0)));
    let noise = one("term = \"N\"\nmost = 25\nunit = \"µg/√Hz\"");
    assert_eq!(
        noise,
        one("characteristic = \"N\"\nmost = 25\nunit = \"µg/√Hz\"")
    );
    assert_eq!(noise.noise().expect("a limit of noise").most, 25.0);
}

/// Factors by the definitions of the units; g is 9.80665 m/s².
#[test]
fn known_units_of_data_sheets() {
    for (from, to, factor) in [
        ("m/s²", "mg", 1e3 / 9.80665),
        ("V/(m/s²)", "mV/g", 9806.65),
        ("count/(m/s²)", "LSB/g", 9.80665),
        ("rad", "%", 100.0),
        ("rad", "°", 180.0 / std::f64::consts::PI),
        ("m/s²/K", "mg/°C", 1e3 / 9.80665),
        ("1/K", "ppm/°C", 1e6),
        ("1/(m/s²)", "µg/g²", 9.80665e6),
        ("Hz", "kHz", 1e-3),
        ("m/s²/month", "mg/year", 12e3 / 9.80665),
    ] {
        let got = unit_ratio(from, to).unwrap_or_else(|| panic!("{from} to {to}"));
        assert!((got / factor - 1.0).abs() < 1e-12, "{from} to {to}: {got}");
    }
    // A count is no number, a decibel no ratio, a month no second.
    for (from, to) in [
        ("count", "1"),
        ("1", "dB"),
        ("m/s²/month", "m/s²/s"),
        ("V", "mg"),
        ("m/s²", "furlong"),
    ] {
        assert_eq!(unit_ratio(from, to), None, "{from} to {to}");
    }
}

#[test]
fn refuses_a_sheet_that_contradicts_itself_and_says_the_line() {
    let bias = "[[limit]]\ncharacteristic = \"bias\"\nmost = 50\nunit = \"mg\"\n";
    for (text, what, place) in [
        ("", "there is no [[limit]]", ""),
        ("[device]\nmodel = 3\n", "a string is needed", "line 2"),
        (
            "[device]\n\n[calibration]\n",
            "unknown section [calibration]",
            "line 3",
        ),
        (
            "[[limit]]\ncharacteristic = \"bais\"\nmost = 1\nunit = \"mg\"\n",
            "no characteristic",
            "line 1",
        ),
        (
            &format!("{bias}\n[[limit]]\ncharacteristic = \"bias\"\nmost = 0.4\nunit = \"m/s²\"\n"),
            "two limits of bias",
            "line 1",
        ),
        (
            &format!(
                "{bias}\n[[limit]]\ncharacteristic = \"resonance\"\nlower = 1\nunit = \"mg\"\n"
            ),
            "\"mg\" is no unit of resonance",
            "line 6",
        ),
        (
            &format!("{bias}[[limit]]\nmost = 1\nunit = \"mg\"\n"),
            "does not say what it is of",
            "line 5",
        ),
        (
            "[[limit]]\ncharacteristic = \"bias\"\nmost = inf\nunit = \"mg\"\n",
            "no finite number",
            "limit 1",
        ),
        (
            "[[limit]]\ncharacteristic = \"bias\"\nmost = 1\nlower = 0\nunit = \"mg\"\n",
            "more than one kind of value",
            "limit 1",
        ),
        (
            "[[limit]]\ncharacteristic = \"scale\"\nnominal = 0\n\"tolerance_%\" = 1\nunit = \"1\"\n",
            "not positive",
            "",
        ),
        (
            "[[limit]]\ncharacteristic = \"bias\"\nlower = 2\nupper = 1\nunit = \"mg\"\n",
            "not below its upper limit",
            "",
        ),
        (
            "[[limit]]\ncharacteristic = \"bias\"\nmost = 1\nunit = \"mg\"\nfrequency_Hz = [9, 1]\n",
            "is no range",
            "",
        ),
        (
            "[[limit]]\ncharacteristic = \"bias\"\nmost = 1\nunit = \"mg\"\nmeaning = \"floor\"\n",
            "which only noise has",
            "",
        ),
        (
            "[[limit]]\ncharacteristic = \"N\"\nupper = 1\nunit = \"µg/√Hz\"\n",
            "no largest value",
            "",
        ),
        (
            "[[limit]]\nterm = \"N\"\nmost = 1\nunit = \"µg/√Hz\"\nfrequency_Hz = [1, 2]\n",
            "has no frequency",
            "",
        ),
        (
            "[[limit]]\nterm = \"N\"\ncharacteristic = \"bias\"\nmost = 1\nunit = \"µg/√Hz\"\n",
            "at once",
            "",
        ),
        (
            &format!("[decision]\nr = -1\n{bias}"),
            "r = -1 is not positive",
            "",
        ),
        (
            &format!("{bias}[[grade]]\nname = \"own\"\n"),
            "the grade own has no limit",
            "",
        ),
    ] {
        let trouble = sheet(text).expect_err(text);
        assert!(trouble.to_string().contains(what), "{text}: {trouble}");
        let said = trouble.place().join("; ");
        assert!(said.contains(place), "{text}: {said}");
        assert!(trouble.hint().is_some(), "{text}");
    }
    let near = sheet("[[limit]]\ncharacteristic = \"resonanc\"\nmost = 1\nunit = \"Hz\"\n");
    assert!(
        near.unwrap_err()
            .hint()
            .unwrap()
            .contains("did you mean `resonance`")
    );
    // Parted by axis or by band they are two.
    let parts = |key: [&str; 2]| {
        read(&format!(
            "[[limit]]\ncharacteristic = \"scale\"\nmost = 1\nunit = \"mV/g\"\n{}\n[[limit]]\ncharacteristic = \"scale\"\nmost = 2\nunit = \"mV/g\"\n{}\n",
            key[0], key[1]
        ))
    };
    assert!(parts(["channels = [\"x\"]", "channels = [\"y\"]"]).is_ok());
    assert!(parts(["frequency_Hz = [1, 5]", "frequency_Hz = [5, 9]"]).is_ok());
    assert!(parts(["frequency_Hz = [1, 6]", "frequency_Hz = [5, 9]"]).is_err());
}
