//! Parquet: files that are cut or damaged ask for neither time nor memory, and large ones are read in blocks.
#![cfg(feature = "parquet")]

use parquet::basic::Compression;
use parquet::data_type::{DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use proofmass_formats::{Container, Error, SeekRead};
use std::fs::File;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

const SEEDS: [&[u8]; 2] = [
    include_bytes!("seeds/nulls.parquet"),
    include_bytes!("seeds/nested.parquet"),
];

/// Largest memory that this process ever had, MB.
fn peak_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kb: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kb / 1024.0)
}

/// Numbers of a file, and the sum of those that are there.
fn read(file: Box<dyn SeekRead>) -> Result<(u64, f64), Error> {
    let container = Container::open(file)?;
    let all: Vec<usize> = (0..container.streams()[0].channels.len()).collect();
    let mut rows = container.rows(0, &all)?;
    let mut block = vec![Vec::new(); all.len()];
    let (mut count, mut sum) = (0, 0.0);
    while rows.next_block(&mut block)? > 0 {
        for v in block.iter().flatten() {
            count += 1;
            sum += if v.is_finite() { *v } else { 0.0 };
        }
    }
    Ok((count, sum))
}

/// A time in ms and a signal, in pages of 10 000 rows.
fn write(path: &Path, groups: i64, rows: i64, codec: Compression) {
    let schema = "message m { required int64 t (TIMESTAMP(MICROS, true)); required double a; }";
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let properties = WriterProperties::builder()
        .set_compression(codec)
        .set_data_page_row_count_limit(10_000)
        .set_dictionary_enabled(false);
    let file = File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties.build())).unwrap();
    for group in 0..groups {
        let numbers = || group * rows..(group + 1) * rows;
        let times: Vec<i64> = numbers().map(|i| i * 1000).collect();
        let signal: Vec<f64> = numbers().map(|i| (i as f64 * 0.37).sin()).collect();
        let mut row_group = writer.next_row_group().unwrap();
        let mut column = row_group.next_column().unwrap().unwrap();
        let typed = column.typed::<Int64Type>();
        typed.write_batch(&times, None, None).unwrap();
        column.close().unwrap();
        let mut column = row_group.next_column().unwrap().unwrap();
        let typed = column.typed::<DoubleType>();
        typed.write_batch(&signal, None, None).unwrap();
        column.close().unwrap();
        row_group.close().unwrap();
    }
    writer.close().unwrap();
}

#[test]
fn law_damage_costs_no_time_or_memory_and_a_file_is_read_in_blocks() {
    let before = peak_mb();
    let mut slowest = 0.0_f64;
    let mut refused = 0;
    let mut tried = |bytes: &[u8]| {
        let start = Instant::now();
        refused += usize::from(read(Box::new(Cursor::new(bytes.to_vec()))).is_err());
        slowest = slowest.max(start.elapsed().as_secs_f64());
    };
    for seed in SEEDS {
        for at in 0..seed.len() {
            tried(&seed[..at]);
            let mut changed = seed.to_vec();
            changed[at] ^= 0xFF;
            tried(&changed);
            for bit in 0..8 {
                changed[at] = seed[at] ^ 1 << bit;
                tried(&changed);
            }
        }
    }
    println!("{refused} refused, the slowest took {slowest} s");
    assert!(slowest < 2.0);
    let Some((before, after)) = before.zip(peak_mb()) else {
        println!("skipped: this system does not tell the peak memory of a process");
        return;
    };
    println!("{before} MB before, {after} MB after");
    assert!(
        after - before < 64.0,
        "{before} MB before, {after} MB after"
    );

    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("long.parquet");
    write(&path, 40, 100_000, Compression::SNAPPY);
    let size = std::fs::metadata(&path).unwrap().len() as f64 / 1e6;
    let before = peak_mb().unwrap_or(0.0);
    let (count, sum) = read(Box::new(File::open(&path).unwrap())).unwrap();
    let after = peak_mb().unwrap_or(0.0);
    std::fs::remove_file(&path).unwrap();
    println!("a file of {size} MB: {before} MB before, {after} MB after");
    assert_eq!(count, 8_000_000);
    let wanted: f64 = (0..4_000_000).map(|i| f64::from(i) / 1000.0).sum();
    assert!((sum - wanted).abs() < 1e-9 * wanted, "{sum}");
    assert!(size > 30.0 && after - before < 10.0);
}
