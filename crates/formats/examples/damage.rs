//! Cuts files and inverts bytes of them, at every byte up to 4 kB and at 2 000 places of larger ones, and reads every copy: prints
//! for each file its copies, the longest time, the most heap above the size of the file and the damage that did each, and every
//! panic. Fails where a copy panics, takes 2 s or 64 MB.

#[path = "../tests/support/damage.rs"]
mod damage;

use std::process::ExitCode;

fn main() -> std::io::Result<ExitCode> {
    let mut sound = true;
    for path in std::env::args().skip(1) {
        let file = std::fs::read(&path)?;
        let word = proofmass_formats::recognise(&file).map_or("text", |f| f.word);
        let worst = damage::damage(&file, None);
        let (seconds, heap) = (&worst.seconds, &worst.bytes);
        println!(
            "{word}\t{path}\t{} copies\t{:.3} s ({})\t{:.1} MB ({})\t{} panics",
            worst.copies,
            seconds.0,
            seconds.1,
            heap.0 as f64 / 1e6,
            heap.1,
            worst.panics.len()
        );
        worst
            .panics
            .iter()
            .for_each(|what| println!("\tpanic: {what}"));
        sound &= worst.panics.is_empty() && seconds.0 < 2.0 && heap.0 < 64_000_000;
    }
    Ok(match sound {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}
