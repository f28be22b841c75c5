//! Readers of recordings, files of 256 MB (UFF and packed ones are smaller), beside Python programs, run in the same minutes.
//!
//! The Python interpreter is taken from the variable PROOFMASS_BENCH_PYTHON, else `python3`; it needs numpy, scipy, npTDMS, pyuff
//! and h5py. The peer writes the files (3 GB in the temporary folder) and reads them; every file was read once before, so that no
//! disk is measured. Ours reads every channel block by block on one core; the peer holds every channel as doubles, which
//! is what its libraries give. A copy is the file through a buffer of 1 MiB. Names after the program choose files.

mod peer;

use peer::{Peers, best};
use proofmass_formats::Container;
use std::fs::File;
use std::io::Read;
use std::path::Path;

const REPEATS: usize = 3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let peers = Peers::run("formats_peer.py", &[folder.path()])?;
    let chosen: Vec<String> = std::env::args().skip(1).collect();
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder.path())? {
        paths.push(entry?.path());
    }
    paths.sort();
    println!("every channel as doubles            GB/s of file   ratio to a copy   to the peer");
    for path in paths {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        if !chosen.is_empty() && !chosen.iter().any(|c| name.starts_with(c.as_str())) {
            continue;
        }
        let (theirs, figure) = peers.get(&name)?;
        let mut sum = 0.0;
        read(&path, |numbers| sum += numbers.iter().sum::<f64>())?;
        if (sum - figure).abs() > 1e-9 * figure.abs() {
            return Err(format!("{name}: the sum is {sum}, of the peer {figure}").into());
        }
        let copied = best(REPEATS, || assert!(copy(&path).is_ok()));
        let ours = best(REPEATS, || {
            let done = read(&path, |numbers| {
                std::hint::black_box(numbers);
            });
            assert!(done.is_ok());
        });
        let size = std::fs::metadata(&path)?.len() as f64;
        println!(
            "  {name:24} {:6.0} ms   {:7.2}   {:15.2}   {:11.1} ×   Σ = {sum:.9e}",
            1e3 * ours,
            1e-9 * size / ours,
            copied / ours,
            theirs / ours
        );
    }
    Ok(())
}

/// Gives the numbers of every channel of measured signals, block by block.
fn read(path: &Path, mut each: impl FnMut(&[f64])) -> proofmass_formats::Result<()> {
    let container = Container::open(Box::new(File::open(path)?))?;
    assert_eq!(container.streams().len(), 1);
    // What the peer does not make: times, and the temperature of loggers.
    let channels = container.streams()[0].channels.iter().enumerate();
    let signals = channels.filter(|(_, c)| !["time", "temperature"].contains(&c.name.as_str()));
    let chosen: Vec<usize> = signals.map(|(i, _)| i).collect();
    let mut block = vec![Vec::new(); chosen.len()];
    let mut rows = container.rows(0, &chosen)?;
    while rows.next_block(&mut block)? > 0 {
        block.iter().for_each(|numbers| each(numbers));
    }
    Ok(())
}

/// Reads a file into one buffer again and again.
fn copy(path: &Path) -> std::io::Result<()> {
    let mut file = File::open(path)?;
    let mut buffer = vec![0; 1 << 20];
    while file.read(&mut buffer)? > 0 {
        std::hint::black_box(&buffer);
    }
    Ok(())
}
