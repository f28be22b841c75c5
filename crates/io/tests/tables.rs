//! Tables of results.

use proofmass_io::{Cell, ErrorKind, Table};

#[test]
fn numbers_read_back_and_text_is_quoted_where_it_must_be() {
    let mut table = Table::new(["name", "bias_m/s2", "n"]);
    let third = 1.0 / 3.0;
    let row = |name: &str, v: Option<f64>, n: usize| [Cell::from(name), v.into(), n.into()];
    table.push(row("x", Some(third), 3)).unwrap();
    table.push(row("a, \"b\"", None, 0)).unwrap();
    table.push(row("", Some(-5e-324), 1)).unwrap();
    let text = String::from_utf8(table.to_csv().unwrap()).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "name,bias_m/s2,n");
    assert_eq!(lines[1], "x,0.3333333333333333,3");
    assert_eq!(lines[2], "\"a, \"\"b\"\"\",,0");
    let smallest: f64 = lines[3].split(',').nth(1).unwrap().parse().unwrap();
    assert_eq!(smallest.to_bits(), (-5e-324_f64).to_bits());
}

#[test]
fn refuses_numbers_that_are_not_finite_and_rows_of_another_width() {
    let mut table = Table::new(["a", "b"]);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = table.push([1.0, bad]).unwrap_err();
        assert_eq!(
            (error.kind(), error.field()),
            (ErrorKind::Output, Some("b"))
        );
    }
    let error = table.push([1.0]).unwrap_err();
    assert!(error.to_string().contains("row 1"), "{error}");
    // What was refused left nothing behind.
    assert_eq!(table.to_csv().unwrap(), b"a,b\n");
}

#[test]
fn regress_a_label_is_no_formula_and_no_escape() {
    let mut table = Table::new(["label"]);
    for label in [
        "=HYPERLINK(\"http://evil\",\"x\")",
        "@SUM(1)",
        "+1+cmd",
        "-2+3|' /C calc'!A0",
        "\tx",
        "a\u{1b}[31m",
        "+x",
        "-z",
        "-0.25",
        "run 7",
        // Of full width, behind blanks and marks, a cell.
        "＝1+1",
        "＋1+1",
        "－1+1",
        "＠SUM(1)",
        " =1+1",
        "\u{feff}=1+1",
        "\r=1+1",
        "+A1",
        "-1e-3",
    ] {
        table.push([label]).unwrap();
    }
    let csv = String::from_utf8(table.to_csv().unwrap()).unwrap();
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let fields: Vec<String> = reader.records().map(|r| r.unwrap()[0].to_owned()).collect();
    assert_eq!(
        fields,
        [
            "'=HYPERLINK(\"http://evil\",\"x\")",
            "'@SUM(1)",
            "'+1+cmd",
            "'-2+3|' /C calc'!A0",
            "'\tx",
            r"a\u{1b}[31m",
            "+x",
            "-z",
            "-0.25",
            "run 7",
            "'＝1+1",
            "'＋1+1",
            "'－1+1",
            "'＠SUM(1)",
            "' =1+1",
            "'\u{feff}=1+1",
            r"'\u{d}=1+1",
            "'+A1",
            "-1e-3"
        ]
    );
}
