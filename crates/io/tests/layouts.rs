//! Shapes of text that must be read without a word from the user.

use proofmass_io::{
    ColumnRef, DecimalMark, Layout, Recording, RecordingOptions, Separator, Source,
};

fn read(bytes: &[u8], columns: &[usize]) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.txt");
    std::fs::write(&path, bytes).unwrap();
    let options = RecordingOptions {
        columns: columns.iter().map(|&i| ColumnRef::Index(i)).collect(),
        sampling_rate_hz: Some(10.0),
        ..RecordingOptions::default()
    };
    Recording::read(&path, &options)
        .unwrap_or_else(|e| panic!("{:?}: {e}", String::from_utf8_lossy(bytes)))
}

#[test]
fn shapes_of_text() {
    use DecimalMark::{Comma as DC, Point as DP};
    use Separator::*;
    let cases: &[(&[u8], Separator, DecimalMark, u64)] = &[
        (b"1.5,-2.5\n3,4\n", Comma, DP, 1),
        (b"1.5,-2.5\n3,4", Comma, DP, 1),
        (b"a,b\r\n1.5,-2.5\r\n3,4\r\n", Comma, DP, 2),
        (b"\xEF\xBB\xBFa,b\n1.5,-2.5\n3,4\n", Comma, DP, 2),
        (b"a;b\n1,5;-2,5\n3,0;4,0\n", Semicolon, DC, 2),
        (b"1,5\t-2,5\n3,0\t4,0\n", Tab, DC, 1),
        (b"1,5 -2,5\n3,0 4,0\n", Whitespace, DC, 1),
        (
            b"  1.5e+00   -2.5e+00  \n  3.0e+00   4.0e+00\n",
            Whitespace,
            DP,
            1,
        ),
        (b"a|b\n1.5|-2.5\n3|4\n", Pipe, DP, 2),
        (b"a,b,\n1.5,-2.5,\n3,4,\n", Comma, DP, 2),
        (
            b"# note\n% other\n// third\n\n1.5,-2.5\n# between\n3,4\n\n",
            Comma,
            DP,
            5,
        ),
        (
            b"Logger 7\nStart: noon, Monday, May\na,b\ns,g\n1.5,-2.5\n3,4\n",
            Comma,
            DP,
            5,
        ),
        (
            b"\"a, first\",\"b\"\n\"1.5\",\"-2.5\"\n\"3\",\"4\"\n",
            Comma,
            DP,
            2,
        ),
        (b"T (\xB0C),b\n+1.5,-2.5\n3,4\n", Comma, DP, 2),
        (b"1.5D0 -0.25D+1\n3D0 4D0\n", Whitespace, DP, 1),
        (b"1.5, -2.5\n3, 4\n", Comma, DP, 1),
    ];
    for (bytes, separator, decimal, first) in cases {
        let r = read(bytes, &[1, 2]);
        let shown = String::from_utf8_lossy(bytes);
        assert_eq!(
            (r.layout.separator, r.layout.decimal),
            (*separator, *decimal),
            "{shown}"
        );
        assert_eq!(r.columns[0].data, [1.5, 3.0], "{shown}");
        assert_eq!(r.columns[1].data, [-2.5, 4.0], "{shown}");
        assert_eq!(r.line(0), *first, "{shown}");
    }
}

#[test]
fn names_in_a_comment_and_units_in_a_second_line() {
    let r = read(b"# t x y\n0 1 2\n1 1 2\n", &[2, 3]);
    assert_eq!(r.columns[1].name, "y");
    let r = read(b"time,ax,ay\ns,g,g\n0,1,2\n1,1,2\n", &[2, 3]);
    assert_eq!(r.columns[0].unit.unwrap().to_string(), "g");
    let r = read(b"time,T (\xB0C)\n0,1\n1,1\n", &[2]);
    assert_eq!(r.columns[0].unit.unwrap().to_string(), "°C");
}

#[test]
fn all_zeros_and_lines_of_samples() {
    let r = read(b"0,0,0\n0,0,0\n# x\n\n0,0,0\n", &[1, 2, 3]);
    assert!(r.columns.iter().all(|c| c.data == [0.0; 3]));
    assert_eq!([r.line(0), r.line(1), r.line(2)], [1, 2, 5]);
}

#[test]
fn gaps_are_found_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("g.csv");
    std::fs::write(&path, "t (ms),x\n0,1\n10,1\n20,1\n50,1\n60,1\n").unwrap();
    let r = Recording::read(
        &path,
        &RecordingOptions {
            columns: vec!["x".into()],
            ..Default::default()
        },
    )
    .unwrap();
    assert!((r.time.rate_hz() - 100.0).abs() < 1e-9);
    assert_eq!(r.time.gaps().len(), 1);
    assert_eq!(
        (r.time.gaps()[0].after_sample, r.time.gaps()[0].line),
        (2, 4)
    );
    assert_eq!(r.findings()[0].code(), "gaps-in-record");
    assert!((r.duration_s() - 0.07).abs() < 1e-12);
}

#[test]
fn lines_that_were_passed_over_are_told() {
    // The first row lost its beginning; with its text it looks like a preamble.
    let r = read(b"2.5,still\n0.1,1,2,still\n0.2,1,2,still\n", &[1, 2]);
    assert_eq!(r.samples(), 2);
    let finding = &r.findings()[0];
    assert_eq!(finding.code(), "preamble-skipped");
    assert!(
        finding.to_string().contains("line 1, \"2.5,still\""),
        "{finding}"
    );
    assert_eq!(r.layout.passed_over, [(1, "2.5,still".to_string())]);
    // Several, among them a heading above the heading.
    let r = read(
        b"Logger 7\n# note\nleft,right\na,b\ng,g\n1,2\n3,4\n5,6\n7,8\n",
        &[1, 2],
    );
    assert_eq!(
        r.layout.passed_over,
        [(1, String::new()), (3, String::new())]
    );
    assert!(r.findings()[0].to_string().contains("1 more up to line 3"));
    // Comments, headings and units are no such lines, nor is what the user skips.
    for text in [
        "# note\n1,2\n3,4\n",
        "a,b\ns,g\n1,2\n3,4\n",
        "a,b,\n1,2,\n3,4,\n",
    ] {
        assert!(
            read(text.as_bytes(), &[1, 2]).findings().is_empty(),
            "{text}"
        );
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.csv");
    std::fs::write(&path, "Logger 7\n1,2\n3,4\n").unwrap();
    let options = proofmass_io::LayoutOptions {
        skip_lines: Some(1),
        ..Default::default()
    };
    let layout = Layout::sniff_with(&path, &options).unwrap();
    assert!(layout.findings().is_empty());
}

/// FIPS 180-4, the examples "abc" and the one of 448 bits as published by NIST; a million times "a" likewise.
#[test]
fn published_sha256_of_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("message");
    for (message, digest) in [
        (
            "abc".to_string(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad",
        ),
        (
            "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq".to_string(),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1",
        ),
        (
            "a".repeat(1_000_000),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0",
        ),
    ] {
        std::fs::write(&path, message).unwrap();
        assert_eq!(proofmass_io::Input::of(&path).unwrap().sha256, digest);
    }
}

/// The digest of the pass that reads the numbers covers preamble, several blocks and a last line without an end.
#[test]
fn crosscheck_sha256_of_the_reading_pass() {
    let rows: String = (0..300_000).map(|i| format!("{i},{}\n", i % 7)).collect();
    let text = format!("# note\na,b\n{}", rows.trim_end());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("h.csv");
    std::fs::write(&path, &text).unwrap();
    let r = read(text.as_bytes(), &[1, 2]);
    assert_eq!(r.samples(), 300_000);
    assert_eq!(
        r.file.sha256,
        proofmass_io::Input::of(&path).unwrap().sha256
    );
    assert_eq!(r.line(299_999), 300_002);
    let counts = r.columns[0].data.iter().enumerate();
    assert!(counts.into_iter().all(|(i, &v)| v == i as f64));
    assert_eq!(Layout::sniff(&path).unwrap().first_data_line, 3);
}

#[test]
fn known_times_beside_a_stated_rate_are_told() {
    let told = read(b"time,x\n0,1\n0.1,2\n0.2,4\n", &[2]);
    assert!(
        told.findings()
            .iter()
            .any(|f| f.code() == "time-column-unused"),
        "{:?}",
        told.findings()
    );
    let plain = read(b"y,x\n0,1\n0.1,2\n0.2,4\n", &[2]);
    assert!(plain.findings().is_empty(), "{:?}", plain.findings());
}

#[test]
fn refuses_patterns_where_each_column_is_one_signal() {
    let text = b"t_s,acc_x_g,acc_y_g\n0,1,2\n0.1,1,2\n0.2,1,2\n";
    let options = RecordingOptions {
        columns: vec!["acc_*".into(), "acc_y".into()],
        ..RecordingOptions::default()
    };
    let source = Source::from_bytes("r.csv", &text[..]).unwrap();
    let refusal = Recording::from_source(source, &options).unwrap_err();
    assert!(
        refusal.to_string().contains("there is no such column"),
        "{refusal}"
    );
}
