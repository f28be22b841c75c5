//! Tables of standstills given by hand.

use proofmass_io::{ErrorKind, Recording, RecordingOptions, Result, SegmentRow};

/// A hundred samples at 10 Hz, the first at 5 s.
fn recording(folder: &std::path::Path) -> Recording {
    let path = folder.join("r.csv");
    let rows: String = (0..100)
        .map(|i| format!("{:.1},{i},0,1\n", 5.0 + f64::from(i) * 0.1))
        .collect();
    std::fs::write(&path, format!("time_s,x,y,z\n{rows}")).unwrap();
    let options = RecordingOptions {
        columns: vec!["x".into(), "y".into(), "z".into()],
        ..RecordingOptions::default()
    };
    Recording::read(&path, &options).unwrap()
}

fn segments(table: impl AsRef<[u8]>) -> Result<Vec<SegmentRow>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("segments.csv");
    std::fs::write(&path, table).unwrap();
    SegmentRow::read(&path, &recording(folder.path()))
}

fn ranges(table: &str) -> Vec<(usize, usize)> {
    let segments = segments(table).unwrap_or_else(|e| panic!("{table}: {e}"));
    segments.iter().map(|s| (s.start, s.end)).collect()
}

#[test]
fn samples_and_seconds() {
    assert_eq!(ranges("start,end\n0,10\n10,100\n"), [(0, 10), (10, 100)]);
    // The order of the table is kept, and other separators and comments are understood.
    assert_eq!(
        ranges("\u{FEFF}# by hand\nend;start\n\n90;50\n# early\n20;0\n"),
        [(50, 90), (0, 20)]
    );
    assert_eq!(ranges("start\tend\r\n3\t7\r\n"), [(3, 7)]);
    // 5.0 s is sample 0; the end, 6.0 s, is sample 10, which is not included.
    assert_eq!(
        ranges("start_s,end_s\n5.0,6.0\n6,15\n"),
        [(0, 10), (10, 100)]
    );
    // Between two samples the later one counts, at both ends.
    assert_eq!(ranges("start_s,end_s\n5.05,5.95\n"), [(1, 10)]);
}

#[test]
fn attitudes_and_labels() {
    let table = "start,end,direction,label\n0,10,+x,flat\n10,20,-Z,\n20,30,y,\"a, b\"\n30,40,,\n40,50,−y,\n";
    let s = segments(table).unwrap();
    let attitudes: Vec<_> = s.iter().map(|s| s.attitude).collect();
    assert_eq!(
        attitudes,
        [
            Some([1.0, 0.0, 0.0]),
            Some([0.0, 0.0, -1.0]),
            Some([0.0, 1.0, 0.0]),
            None,
            Some([0.0, -1.0, 0.0])
        ]
    );
    let labels: Vec<_> = s.iter().map(|s| s.label.as_deref()).collect();
    assert_eq!(labels, [Some("flat"), None, Some("a, b"), None, None]);

    // Three typed digits are scaled to length one: (0.6, 0, 0.801) / sqrt(0.36 + 0.641601).
    let s = segments("start,end,up_x,up_y,up_z\n0,10,0.6,0,0.801\n10,20,,,\n").unwrap();
    let up = s[0].attitude.unwrap();
    let length = 1.001601_f64.sqrt();
    for (u, expected) in up.into_iter().zip([0.6 / length, 0.0, 0.801 / length]) {
        assert!((u - expected).abs() < 1e-15, "{up:?}");
    }
    assert_eq!(s[1].attitude, None);
}

#[test]
fn law_every_form_of_an_attitude_is_the_same() {
    let word = "start,end,direction\n0,10,-x+z\n10,20,+y\n";
    let vector = "start,end,up_x,up_y,up_z\n0,10,-0.7071068,0,0.7071068\n10,20,0,1,0\n";
    let angles = "start,end,roll_deg,pitch_deg\n0,10,0,45\n10,20,90,0\n";
    let truth = "start,end,a_true_x_g,a_true_y_g,a_true_z_g,u_a_true_m/s2\n0,10,-0.5,0,0.5,0.01\n10,20,0,1,0,\n";
    let half = 0.5_f64.sqrt();
    for table in [word, vector, angles, truth] {
        let s = segments(table).unwrap_or_else(|e| panic!("{table}: {e}"));
        for (segment, expected) in s.iter().zip([[-half, 0.0, half], [0.0, 1.0, 0.0]]) {
            let up = segment.attitude.unwrap();
            for (u, e) in up.into_iter().zip(expected) {
                assert!((u - e).abs() < 1e-15, "{table}: {up:?}");
            }
        }
        let known = s[0].acceleration.and_then(|a| a.standard_uncertainty);
        assert_eq!(known.is_some(), table == truth);
        assert!(
            s[1].acceleration
                .is_none_or(|a| a.standard_uncertainty.is_none())
        );
    }
}

#[test]
fn refuses_by_line_column_and_remedy() {
    use ErrorKind::{Column, Field, Format, Row};
    for (table, kind, line, column, word) in [
        ("", Format, None, None, "empty"),
        ("start,end\n", Format, None, None, "no rows"),
        ("start\n1\n", Column, Some(1), None, "missing or mixed"),
        (
            "start,end_s\n1,2\n",
            Column,
            Some(1),
            None,
            "missing or mixed",
        ),
        (
            "# note\nstart,edn\n1,2\n",
            Column,
            Some(2),
            Some("edn"),
            "no such column",
        ),
        (
            "start,end,end\n1,2,3\n",
            Column,
            Some(1),
            Some("end"),
            "twice",
        ),
        (
            "start,end,up_x,up_y\n1,2,0,1\n",
            Column,
            Some(1),
            None,
            "some are missing",
        ),
        (
            "start,end,up_x,up_y,up_z,direction\n1,2,0,1,0,x\n",
            Column,
            Some(1),
            None,
            "exclude",
        ),
        ("start,end\n1,2\n5\n", Row, Some(3), None, "1 fields"),
        (
            "start,end\n1,2\n# note\n\n8,5\n",
            Row,
            Some(5),
            None,
            "ends at 5",
        ),
        ("start,end\n1,2\n8,8\n", Row, Some(3), None, "ends at 8"),
        ("start_s,end_s\n7,6\n", Row, Some(2), None, "ends at 6 s"),
        ("start,end\n0,101\n", Row, Some(2), Some("end"), "0 to 99"),
        (
            "start,end\n-1,5\n",
            Row,
            Some(2),
            Some("start"),
            "-1 is not a sample",
        ),
        (
            "start,end\n0.5,5\n",
            Row,
            Some(2),
            Some("start"),
            "0.5 is not a sample",
        ),
        (
            "start_s,end_s\n4,6\n",
            Row,
            Some(2),
            Some("start_s"),
            "outside the recording",
        ),
        (
            "start_s,end_s\n5,15.2\n",
            Row,
            Some(2),
            Some("end_s"),
            "outside the recording",
        ),
        ("start,end\n0,ten\n", Field, Some(2), Some("end"), "\"ten\""),
        (
            "start,end\n0,nan\n",
            Field,
            Some(2),
            Some("end"),
            "not a finite number",
        ),
        (
            "start,end,direction\n0,9,x\n9,20,up\n",
            Field,
            Some(3),
            Some("direction"),
            "\"up\"",
        ),
        (
            "start,end,up_x,up_y,up_z\n0,9,1,1,0\n",
            Row,
            Some(2),
            Some("up_x"),
            "1.4142",
        ),
        (
            "start,end,up_x,up_y,up_z\n0,9,1,,0\n",
            Field,
            Some(2),
            Some("up_y"),
            "empty",
        ),
        (
            "start,end,direction\n0,9,+x+x\n",
            Field,
            Some(2),
            Some("direction"),
            "names x twice",
        ),
        (
            "start,end,a_true_x,a_true_y,a_true_z\n0,9,0,0,1\n",
            Column,
            Some(1),
            Some("a_true_x"),
            "does not say the unit",
        ),
        (
            "start,end,a_true_x_V,a_true_y_V,a_true_z_V\n0,9,0,0,1\n",
            Column,
            Some(1),
            Some("a_true_x_V"),
            "no column of a true acceleration",
        ),
        (
            "start,end,a_true_x_g,a_true_z_g\n0,9,0,1\n",
            Column,
            Some(1),
            None,
            "some are missing",
        ),
        (
            "start,end,direction,u_a_true_g\n0,9,x,0.001\n",
            Column,
            Some(1),
            None,
            "stands without",
        ),
        (
            "start,end,a_true_x_g,a_true_y_g,a_true_z_g\n0,9,0,0,0\n",
            Row,
            Some(2),
            Some("a_true_x_g"),
            "length zero",
        ),
        (
            "start,end,direction,a_true_x_g,a_true_y_g,a_true_z_g\n0,9,-z,0,0,1\n",
            Row,
            Some(2),
            Some("a_true_x_g"),
            "180.0° apart",
        ),
        (
            "start,end,roll_deg,pitch_deg\n0,9,0,400\n",
            Row,
            Some(2),
            Some("roll_deg"),
            "more than a turn",
        ),
        (
            "start,end,roll_deg,pitch_deg,direction\n0,9,0,40,x\n",
            Column,
            Some(1),
            None,
            "exclude",
        ),
        // The later row overlaps the earlier one, in whatever order they stand.
        (
            "start,end\n0,10\n9,20\n",
            Row,
            Some(3),
            None,
            "overlaps that of line 2",
        ),
        (
            "start,end\n30,40\n0,31\n",
            Row,
            Some(2),
            None,
            "overlaps that of line 3",
        ),
    ] {
        let error = segments(table).expect_err(table);
        assert_eq!(
            (error.kind(), error.line_number(), error.field()),
            (kind, line, column),
            "{table:?}: {error}"
        );
        assert!(error.to_string().contains(word), "{table:?}: {error}");
        assert!(error.path().unwrap().ends_with("segments.csv"), "{error}");
        assert!(error.hint().is_some(), "{error}");
    }
}
