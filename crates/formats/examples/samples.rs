//! Prints what is in files: for each channel its stream, name, rows, first and last number and the CRC-32 of all as little-endian
//! doubles, which `.ci/formats` compares with what other readers give. `--as-stored` leaves the scaling of the file off.

use flate2::Crc;
use proofmass_formats::{Container, SeekRead};
use std::error::Error;
use std::fs::File;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let mut as_stored = false;
    for path in std::env::args().skip(1) {
        if path == "--as-stored" {
            as_stored = true;
            continue;
        }
        let open = || {
            let beside = &mut |name: &str| {
                let file = File::open(Path::new(&path).with_file_name(name));
                Ok(file.ok().map(|f| Box::new(f) as Box<dyn SeekRead>))
            };
            Container::open_beside(Box::new(File::open(&path)?), beside)
                .map_err(Box::<dyn Error>::from)
        };
        let container = match open() {
            Ok(container) => container,
            Err(error) => {
                println!("{path}\trefused\t{error}");
                continue;
            }
        };
        for remark in container.remarks() {
            println!("{path}\t{:?}\t{}", remark.kind, remark.text);
        }
        for stream in 0..container.streams().len() {
            let container = open()?;
            let container = match as_stored {
                true => container.without_scaling(),
                false => container,
            };
            let about = &container.streams()[stream];
            let (name, clock) = (about.name.clone(), about.clock);
            let channels = about.channels.clone();
            let all: Vec<usize> = (0..channels.len()).collect();
            let mut rows = container.rows(stream, &all)?;
            let mut block = vec![Vec::new(); all.len()];
            let mut sums: Vec<(Crc, Option<f64>, f64)> =
                all.iter().map(|_| (Crc::new(), None, 0.0)).collect();
            while rows.next_block(&mut block)? > 0 {
                for (column, (crc, first, last)) in block.iter().zip(&mut sums) {
                    let bytes: Vec<u8> = column.iter().flat_map(|v| v.to_le_bytes()).collect();
                    crc.update(&bytes);
                    *first = first.or(column.first().copied());
                    *last = column.last().copied().unwrap_or(*last);
                }
            }
            for (channel, (crc, first, last)) in channels.iter().zip(sums) {
                println!(
                    "{path}\tsamples\t{name}\t{}\t{}\t{}\t{:08x}\t{:?}\t{last:?}\t{clock:?}\t{:?}",
                    channel.name,
                    channel.unit.as_deref().unwrap_or("-"),
                    crc.amount() / 8,
                    crc.sum(),
                    first.unwrap_or(f64::NAN),
                    channel.scaling,
                );
            }
        }
    }
    Ok(())
}
