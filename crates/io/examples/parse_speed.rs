//! Megabytes of text per second that the reader turns into numbers: four columns, in release.

use proofmass_io::{Layout, RowReader};
use std::fmt::Write;
use std::time::Instant;

fn main() -> proofmass_io::Result<()> {
    let mut text = String::from("time_s,acc_x,acc_y,acc_z\n");
    for i in 0..3_000_000_u32 {
        let x = f64::from(i.wrapping_mul(2_654_435_761) >> 12) * 1e-5;
        let _ = writeln!(
            text,
            "{:.3},{:.5},{:.5},{:.5}",
            f64::from(i) * 1e-3,
            x,
            1.0 - x,
            9.8 + x
        );
    }
    let path =
        std::env::temp_dir().join(format!("proofmass-parse-speed-{}.csv", std::process::id()));
    std::fs::write(&path, &text).expect("temporary file");
    for run in 0..3 {
        let start = Instant::now();
        let mut reader = RowReader::open(&path, Layout::sniff(&path)?, &[0, 1, 2, 3])?;
        let mut rows = 0;
        while let Some(block) = reader.next_block()? {
            rows += block.rows();
        }
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "run {run}: {rows} rows, {:.0} MB/s",
            text.len() as f64 / 1e6 / seconds
        );
    }
    let _ = std::fs::remove_file(&path);
    Ok(())
}
