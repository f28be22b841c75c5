//! Odd files in every reader of recordings: where two readings are plausible and differ in the result, a refusal; else the
//! right numbers, with what was assumed in the line that tells how it was read.

mod files;
mod readers;

use files::{Due, Odd};
use proofmass_jobs::Trouble;
use readers::{READERS, Read, Said, Way};

fn said(trouble: &Trouble) -> String {
    format!(
        "{trouble} {:?} {}",
        trouble.place(),
        trouble.hint().unwrap_or_default()
    )
}

#[test]
fn law_every_reader_refuses_or_reads_right() {
    let mut wrong = Vec::new();
    for odd in Odd::all() {
        for (reader, way, read) in READERS {
            let due = match way {
                Way::Named => odd.named,
                Way::Alone => odd.alone.unwrap_or(odd.named),
                Way::All => odd.all.unwrap_or(odd.named),
                Way::Table => odd.table,
                // Where a table is read right, only the clock is odd.
                Way::Clockless => match odd.table {
                    Due::Right(_) => odd.table,
                    Due::Refused(_) => odd.named,
                },
            };
            let about = format!("{} in {reader}", odd.name);
            match (due, read(&odd, &Said::default())) {
                (Due::Refused(words), Err(trouble)) => {
                    let said = said(&trouble);
                    // A campaign says `unit = "g"` where a command says `--unit g`.
                    if !said.replace(" = \"", " ").contains(words) {
                        wrong.push(format!("{about}: refused without {words:?}: {said}"));
                    }
                    if trouble.hint().is_none() {
                        wrong.push(format!("{about}: no remedy: {said}"));
                    }
                }
                (Due::Right(words), Ok(Read { line, z })) => {
                    if !line.contains(words) {
                        wrong.push(format!("{about}: {words:?} is not told: {line}"));
                    }
                    // The wobble of z has no mean beyond 0.001 of it.
                    if z.is_some_and(|z| (z / 9.81 - 1.0).abs() > 1e-3) {
                        wrong.push(format!("{about}: z is {z:?}"));
                    }
                }
                (due, Err(trouble)) => {
                    wrong.push(format!("{about}: {due:?} is due: {}", said(&trouble)));
                }
                (due, Ok(Read { line, .. })) => {
                    wrong.push(format!("{about}: {due:?} is due, it was read: {line}"));
                }
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "{} cells:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

#[test]
fn a_look_tells_what_a_file_does_not_say() {
    use proofmass_jobs::inspect::{InspectData, InspectJob};
    use proofmass_jobs::{Job as _, Outcome as _, Unwatched};
    let look = |text: &str| {
        let source = proofmass_io::Source::from_bytes("r.csv", text.to_owned()).unwrap();
        let outcome = InspectJob::default().evaluate(&InspectData::new(source), &Unwatched);
        outcome.unwrap().findings().to_vec()
    };
    let rows = "0.00,0.1,0.2,9.8\n0.01,0.1,0.2,9.8\n0.02,0.1,0.3,9.8\n0.03,0.2,0.2,9.8\n";
    let silent = look(&format!("a,x,y,z\n{rows}"));
    assert_eq!(silent.len(), 1, "{silent:?}");
    assert_eq!(silent[0].code(), "file-does-not-say");
    assert!(
        silent[0].what().contains("the time of its rows"),
        "{silent:?}"
    );
    // Said in full, nothing is told.
    let said = look(&format!("t_s,x_m/s2,y_m/s2,z_m/s2\n{rows}"));
    assert!(
        said.iter().all(|f| f.code() != silent[0].code()),
        "{said:?}"
    );
}

#[test]
fn known_what_is_stated_makes_odd_files_right() {
    // Said by itself, each is enough.
    for (name, time_unit) in [("ms.csv", "ms"), ("us.csv", "us"), ("ns.csv", "ns")] {
        let all = Odd::all();
        let odd = all.iter().find(|odd| odd.name == name).unwrap();
        for (reader, line) in readers::stated(odd, |s| s.time_unit = time_unit.parse().ok()) {
            let words = format!("100 Hz by column 1 timestamp in {time_unit} as stated");
            assert!(line.contains(&words), "{reader}: {line}");
        }
    }
    for (name, unit) in [("g.csv", "g"), ("mg.csv", "mg")] {
        let all = Odd::all();
        let odd = all.iter().find(|odd| odd.name == name).unwrap();
        for (reader, line) in readers::stated(odd, |s| s.unit = unit.parse().ok()) {
            let words = format!("in {unit} as stated");
            assert!(line.contains(&words), "{reader}: {line}");
        }
    }
    let all = Odd::all();
    let odd = all.iter().find(|odd| odd.name == "seconds.csv").unwrap();
    for (reader, line) in readers::stated(odd, |s| s.between = Some([1.0, 3.0])) {
        assert!(line.contains("between 1 s and 3 s"), "{reader}: {line}");
    }
    for (reader, line) in readers::stated(odd, |s| s.rate = Some(50.0)) {
        assert!(line.contains("50 Hz as stated"), "{reader}: {line}");
    }
}

#[test]
fn refuses_a_recording_without_the_columns_of_the_calibration() {
    for refused in readers::without_columns_of_the_calibration() {
        let said = said(&refused);
        assert!(
            said.contains(r#"made with the columns "a", "b", "c", and"#),
            "{said}"
        );
        assert!(said.contains("--columns X,Y,Z"), "{said}");
    }
}
