//! Memory does not grow with the file. Alone in its file, so that it runs in a process of its own.

use proofmass_io::{Layout, Rewriter, RowReader, inspect};
use std::io::Write;

/// Largest resident memory of this process so far, MB.
fn peak_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1.024e-3)
}

#[test]
fn law_memory_is_bounded_whatever_the_size_of_the_file() {
    let Some(before) = peak_mb() else {
        println!("skipped: this system does not tell the peak memory of a process");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("in.csv"), folder.path().join("out.csv"));
    let mut file = std::io::BufWriter::new(std::fs::File::create(&input).unwrap());
    writeln!(file, "t_s,acc_x,acc_y,acc_z").unwrap();
    let rows = 1_800_000_u32;
    for i in 0..rows {
        let (t, v) = (f64::from(i) * 1e-3, i.wrapping_mul(2_654_435_761) >> 12);
        writeln!(file, "{t:.3},{v},-{v},{v}.123456").unwrap();
    }
    drop(file);
    let size = std::fs::metadata(&input).unwrap().len() as f64 * 1e-6;
    assert!(size > 60.0, "{size} MB");

    assert_eq!(inspect(&input).unwrap().rows, u64::from(rows));
    let layout = Layout::sniff(&input).unwrap();
    let mut reader = RowReader::open(&input, layout.clone(), &[0, 1, 2, 3])
        .unwrap()
        .keep_text();
    let new = [(1, "x".into()), (2, "y".into()), (3, "z".into())];
    let mut writer = Rewriter::create(&output, &layout, &new, &[&input]).unwrap();
    let mut sum = 0;
    while let Some(block) = reader.next_block().unwrap() {
        sum += block.rows();
        writer
            .block(&block, &[block.column(1), block.column(2), block.column(3)])
            .unwrap();
    }
    writer.commit().unwrap();
    assert_eq!(sum, rows as usize);
    let peak = peak_mb().unwrap_or(before);
    println!("{size:.0} MB of text, peak memory {peak:.0} MB ({before:.0} MB before)");
    // Blocks of 2 MiB as text, numbers and new text, and the distinct values of four columns; half the file is
    // far more than they need and far less than the file in memory would.
    assert!(peak < 0.5 * size, "{peak} MB");
}
