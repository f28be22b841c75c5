//! A file that is cut gives the samples before the cut as the whole file does, and says that it is cut.

use proofmass_formats::{Container, RemarkKind};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::PathBuf;

fn open(bytes: &[u8]) -> Result<Container, proofmass_formats::Error> {
    Container::open(Box::new(Cursor::new(bytes.to_vec())))
}

/// The numbers of every channel by its name; of a stream too where its name does not tell a length.
fn channels(bytes: &[u8]) -> Option<HashMap<String, Vec<f64>>> {
    let streams = open(bytes).ok()?.streams().len();
    let mut all = HashMap::new();
    for stream in 0..streams {
        // The calibration of an IDE file may stand behind its samples.
        let container = open(bytes).ok()?;
        let container = match container.format().word {
            "ide" => container.without_scaling(),
            _ => container,
        };
        let about = &container.streams()[stream];
        let of = match about.name.ends_with(" samples") {
            true => "",
            false => &about.name,
        };
        let names: Vec<String> = about
            .channels
            .iter()
            .map(|c| format!("{of}/{}", c.name))
            .collect();
        let chosen: Vec<usize> = (0..names.len()).collect();
        let mut columns = vec![Vec::new(); names.len()];
        let mut rows = container.rows(stream, &chosen).ok()?;
        let mut block = columns.clone();
        while rows.next_block(&mut block).ok()? > 0 {
            for (column, part) in columns.iter_mut().zip(&block) {
                column.extend(part);
            }
        }
        all.extend(names.into_iter().zip(columns));
    }
    Some(all)
}

/// What is wrong with a cut file.
fn wrong(whole: &HashMap<String, Vec<f64>>, bytes: &[u8], at_part: bool) -> Option<String> {
    let cut = channels(bytes)?;
    let same = |a: f64, b: f64| a == b || a.is_nan() && b.is_nan();
    for (name, numbers) in &cut {
        // A set of UFF that is shorter than the others is a stream of its own.
        let known = whole
            .get(name)
            .or_else(|| whole.get(&name.replace(" s 2/", " s/")));
        let Some(before) = known else {
            return Some(format!("{name} is new"));
        };
        // The time of the last block may hang on the next one.
        let close = |a: f64, b: f64| same(a, b) || name.ends_with("/time") && (a - b).abs() < 1.5;
        let first = numbers.iter().zip(before).position(|(a, b)| !close(*a, *b));
        if let Some(at) = first {
            return Some(format!(
                "{name}, sample {at}: {} for {}",
                numbers[at], before[at]
            ));
        }
        if numbers.len() > before.len() {
            return Some(format!("{name} is longer"));
        }
    }
    let fewer = |(name, before): (&String, &Vec<f64>)| {
        cut.get(name)
            .is_none_or(|numbers| numbers.len() < before.len())
    };
    let container = open(bytes).ok()?;
    let said = |r: &proofmass_formats::Remark| r.kind != RemarkKind::PassedOver;
    let lost = whole.iter().any(fewer);
    (lost && !at_part && !container.remarks().iter().any(said)).then(|| "is silent".to_owned())
}

#[test]
fn law_samples_before_a_cut_are_those_of_the_whole_file() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/seeds");
    let (mut read, mut all) = (0, Vec::new());
    for entry in std::fs::read_dir(folder).unwrap() {
        let path: PathBuf = entry.unwrap().path();
        if cfg!(not(feature = "parquet")) && path.extension().is_some_and(|e| e == "parquet") {
            continue;
        }
        let file = std::fs::read(&path).unwrap();
        let whole = channels(&file).unwrap();
        let mut bad = Vec::new();
        // Where a part ends and nothing says how many there are.
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let parts: &[usize] = match &*name {
            "two.ulg" => &[372, 412, 423],
            "two.ide" => &[624, 658, 685, 723],
            "plain.mat" => &[248],
            "packed.mat" => &[232],
            "level4.mat" => &[86],
            "three.cwa" => &[1536, 2048],
            "two.tdms" => &[486],
            _ => &[],
        };
        for at in 0..file.len() {
            if let Some(what) = wrong(&whole, &file[..at], parts.contains(&at)) {
                bad.push((at, what));
            }
            read += usize::from(open(&file[..at]).is_ok());
        }
        if let Some((at, what)) = bad.first() {
            all.push(format!(
                "{name} at {at} of {}: {what} {:?}",
                file.len(),
                bad.iter().map(|b| b.0).collect::<Vec<_>>()
            ));
        }
    }
    assert!(all.is_empty(), "{all:#?}");
    assert!(read > 3000, "{read}");
}
