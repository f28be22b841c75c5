//! Recordings written again with some columns replaced.

use proofmass_io::{
    ErrorKind, Layout, LayoutOptions, Recording, RecordingOptions, Result, Rewriter, RowReader,
};
use std::path::PathBuf;

/// Writes `text`, passes it through with the columns of `replaced` turned into `new(column, number)`.
fn rewritten(
    text: impl AsRef<[u8]>,
    options: &LayoutOptions,
    replaced: &[(usize, &str)],
    new: impl Fn(usize, f64) -> f64,
) -> (tempfile::TempDir, PathBuf, Result<()>) {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("in.txt"), folder.path().join("out.csv"));
    std::fs::write(&input, text).unwrap();
    let done = (|| {
        let layout = Layout::sniff_with(&input, options)?;
        let columns: Vec<usize> = replaced.iter().map(|r| r.0).collect();
        let named: Vec<_> = replaced.iter().map(|r| (r.0, r.1.to_string())).collect();
        let mut reader = RowReader::open(&input, layout.clone(), &columns)?.keep_text();
        let mut writer = Rewriter::create(&output, &layout, &named, &[&input])?;
        while let Some(block) = reader.next_block()? {
            let values: Vec<Vec<f64>> = (0..columns.len())
                .map(|i| block.column(i).iter().map(|&v| new(i, v)).collect())
                .collect();
            let slices: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
            writer.block(&block, &slices)?;
        }
        writer.commit()
    })();
    (folder, output, done)
}

fn text(
    source: impl AsRef<[u8]>,
    options: &LayoutOptions,
    replaced: &[(usize, &str)],
    new: impl Fn(usize, f64) -> f64,
) -> String {
    let (_folder, output, done) = rewritten(source, options, replaced, new);
    done.unwrap_or_else(|e| panic!("{e}"));
    std::fs::read_to_string(output).unwrap()
}

#[test]
fn law_numbers_read_back_and_the_rest_is_verbatim() {
    // Long enough for several blocks of the reader, with texts whose digits are not the shortest ones.
    let mut source = String::from("t_s,acc_x,acc_y,acc_z,note\n");
    for i in 0..150_000 {
        let x = f64::from(i) * 0.1;
        source.push_str(&format!("{x:.6},{x:.3},{:.3},+{:.3},n{i}\n", -x, 2.0 * x));
    }
    let new = |i: usize, v: f64| (v + i as f64) / 3.0;
    let replaced = [(3, "acc_z_m/s2"), (1, "acc_x_m/s2"), (2, "acc_y_m/s2")];
    let (_folder, output, done) = rewritten(&source, &LayoutOptions::default(), &replaced, new);
    done.unwrap();
    let written = std::fs::read_to_string(&output).unwrap();
    assert!(written.starts_with("t_s,acc_x_m/s2,acc_y_m/s2,acc_z_m/s2,note\n"));
    assert_eq!(written.lines().count(), source.lines().count());
    for (old, new) in source.lines().zip(written.lines()).skip(1) {
        let (old, new): (Vec<_>, Vec<_>) = (old.split(',').collect(), new.split(',').collect());
        assert_eq!((old[0], old[4]), (new[0], new[4]));
    }
    let options = RecordingOptions {
        columns: vec!["acc_z".into(), "acc_x".into(), "acc_y".into()],
        ..Default::default()
    };
    let recording = Recording::read(&output, &options).unwrap();
    assert_eq!(recording.columns[0].unit.unwrap().to_string(), "m/s²");
    for (i, old) in source.lines().skip(1).enumerate() {
        let old: Vec<&str> = old.split(',').collect();
        for (k, column) in [3, 1, 2].into_iter().enumerate() {
            let number: f64 = old[column].trim_start_matches('+').parse().unwrap();
            let expected = new(k, number);
            assert_eq!(recording.columns[k].data[i].to_bits(), expected.to_bits());
        }
    }
}

#[test]
fn other_shapes_of_text_become_valid_csv() {
    let half = |_: usize, v: f64| v / 2.0;
    let options = LayoutOptions::default();
    assert_eq!(
        text(
            "  0.00   414 1e0\n  0.01\t-3 2D0\n",
            &options,
            &[(1, "x_m/s2")],
            half
        ),
        "column_1,x_m/s2,column_3\n0.00,207.0,1e0\n0.01,-1.5,2D0\n"
    );
    assert_eq!(
        text(
            "t (s);\"a, b\";acc;note\n0,10;1,5;2;x\n# left out\n0,20;1,50;3;u, v\n0,30;1.000;-1e3;1,2\n",
            &options,
            &[(2, "acc_m/s2")],
            half
        ),
        "t (s),\"a, b\",acc_m/s2,note\n0.10,1.5,1.0,x\n0.20,1.50,1.5,\"u, v\"\n0.30,1.000,-500.0,\"1,2\"\n"
    );
    assert_eq!(
        text(
            "\"t\",acc,note,\n\"0.1\",1,\"say \"\"no\"\"\",\n0.2,2,5\"\" pipe,\n0.3,3,,\n",
            &options,
            &[(1, "acc_g")],
            half
        ),
        "t,acc_g,note\n\"0.1\",0.5,\"say \"\"no\"\"\"\n0.2,1.0,\"5\"\"\"\" pipe\"\n0.3,1.5,\n"
    );
    // A unit that stood in a line of its own is not lost.
    assert_eq!(
        text(
            "time,a,T\nms,g,-\n0,1,20\n10,1,21\n",
            &options,
            &[(1, "a_m/s2")],
            half
        ),
        "time (ms),a_m/s2,T\n0,0.5,20\n10,0.5,21\n"
    );
    // Latin-1 becomes UTF-8, in headings and fields alike.
    assert_eq!(
        text(
            b"T (\xB0C),a,place\n20,1,H\xF6he\n21,1,low\n",
            &options,
            &[(1, "a_g")],
            half
        ),
        "T (°C),a_g,place\n20,0.5,Höhe\n21,0.5,low\n"
    );
    // A field that would turn the row into a comment is quoted.
    let own = LayoutOptions {
        comment: Some(vec!["!".into()]),
        ..Default::default()
    };
    assert_eq!(
        text("id,a\n! no row\n#1,1\n#2,2\n", &own, &[(1, "a_g")], half),
        "id,a_g\n\"#1\",0.5\n\"#2\",1.0\n"
    );
}

#[test]
fn refuses_what_is_not_finite_with_the_line_of_the_recording() {
    let source = "t,a\n0,1\n# note\n1,0\n2,0\n";
    let (folder, output, done) = rewritten(
        source,
        &LayoutOptions::default(),
        &[(1, "a_m/s2")],
        |_, v| 0.0 / v,
    );
    let error = done.unwrap_err();
    assert_eq!(
        (error.kind(), error.line_number(), error.field()),
        (ErrorKind::Output, Some(4), Some("a_m/s2"))
    );
    assert!(error.path().unwrap().ends_with("in.txt"), "{error}");
    assert!(error.to_string().contains("NaN"), "{error}");
    assert!(!output.exists());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn refuses_columns_and_blocks_that_do_not_fit() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("in.csv"), folder.path().join("out.csv"));
    std::fs::write(&input, "t,a,b\n0,1,2\n1,1,2\n").unwrap();
    let layout = Layout::sniff(&input).unwrap();
    for (replaced, word) in [
        (vec![(3, "c")], "no column 4"),
        (vec![(1, "c"), (1, "d")], "twice"),
        (vec![(1, "b")], "column 3 of the file has this name"),
        (vec![(1, "c"), (2, "c")], "has this name"),
    ] {
        let named: Vec<_> = replaced
            .into_iter()
            .map(|(i, n)| (i, n.to_string()))
            .collect();
        let error = Rewriter::create(&output, &layout, &named, &[]).unwrap_err();
        assert!(error.to_string().contains(word), "{error}");
    }
    let named = [(1, "a_g".to_string())];
    let error = Rewriter::create(&input, &layout, &named, &[&input]).unwrap_err();
    assert!(error.to_string().contains("the input itself"), "{error}");

    let mut writer = Rewriter::create(&output, &layout, &named, &[&input]).unwrap();
    let mut reader = RowReader::open(&input, layout.clone(), &[1]).unwrap();
    let block = reader.next_block().unwrap().unwrap();
    assert!(writer.block(&block, &[&[1.0, 2.0]]).is_err());
    let mut reader = RowReader::open(&input, layout, &[1]).unwrap().keep_text();
    let block = reader.next_block().unwrap().unwrap();
    assert!(writer.block(&block, &[&[1.0]]).is_err());
    assert!(writer.block(&block, &[]).is_err());
    writer.block(&block, &[&[1.0, 2.0]]).unwrap();
    writer.commit().unwrap();
    let written = std::fs::read_to_string(&output).unwrap();
    assert_eq!(written, "t,a_g,b\n0,1.0,2\n1,2.0,2\n");
}
