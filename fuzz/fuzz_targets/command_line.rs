//! The whole command line in process: the first byte chooses the command, the rest is the file that it reads.

#![no_main]

use std::path::Path;

/// Arguments of every command; `@` is the folder, `@/f` the file of the fuzzer.
const COMMANDS: [&str; 20] = [
    "inspect @/f",
    "inspect @/f --json --damage",
    "noise @/f -o @/out --force",
    "noise @/f --columns 1 --rate 100 --unit m/s2 --json",
    "noise @/f --columns 1 --rate 100 --stream --json",
    "noise @/f --phase --columns 2 --rate 100 --json",
    "calibrate @/f --latitude 52 -o @/out --force",
    "calibrate @/f --free-living -o @/out --force",
    "calibrate @/campaign -o @/out --force",
    "plan @/campaign --json",
    "init @/f",
    "validate @/calibration.json @/f --json",
    "validate @/f @/recording.csv --json",
    "apply @/calibration.json @/f -o @/applied.csv --force",
    "apply @/f @/recording.csv -o @/applied.csv --force",
    "uncertainty @/f --trials 10000 -o @/out --force",
    "velocity estimate --encoder @/f --accelerometer @/f --json",
    "render @/f -o @/out --force",
    "verify @/f",
    "modes @/f --json",
];

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((&first, content)) = data.split_first() else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    std::fs::write(at("f"), content).expect("a file");
    std::fs::create_dir(at("campaign")).expect("a folder");
    std::fs::write(at("campaign/campaign.toml"), content).expect("a file");
    for (from, to) in [
        ("corpus/recording/rests.csv", "recording.csv"),
        ("corpus/recording/rests.csv", "campaign/recording.csv"),
        ("corpus/documents/calibration.json", "calibration.json"),
        ("../examples/published-triaxial/runs.csv", "campaign/runs.csv"),
        ("../examples/published-triaxial/reference.csv", "campaign/reference.csv"),
        ("../examples/published-triaxial/budget.toml", "campaign/budget.toml"),
        ("../examples/published-triaxial/plan.csv", "campaign/plan.csv"),
    ] {
        std::fs::copy(own.join(from), at(to)).expect("a file of the corpus");
    }
    let command = COMMANDS[usize::from(first) % COMMANDS.len()];
    let place = folder.path().to_str().expect("a path");
    let words = command.split(' ').map(|word| word.replace('@', place));
    let code = proofmass_cli::run(std::iter::once("proofmass".to_owned()).chain(words));
    assert!(matches!(code, 0..=3), "{code}");
});
