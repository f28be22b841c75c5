//! The whole command line in process: the first byte chooses the command, the rest is the file that it reads.

#![no_main]

use std::path::Path;

/// Arguments of every command; `@` is the folder, `@/f` the file of the fuzzer.
const COMMANDS: [&str; 48] = [
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
    "compare @/f @/calibration.json --json",
    "export @/f --c --number fixed --outputs 0,65535 -o @/out.h",
    "export @/f --rust -o @/out.rs",
    "import @/f --form magneto --unit count -o @/imported.json",
    "import @/f --form kalibr --unit m/s2 -o @/imported.json",
    "import @/f --form imu-tk --unit count -o @/imported.json",
    "test temperature @/f --temperature 2 --json",
    "test tilt @/f --output 2 --angle 1 --json",
    "test sensitivity @/f --output 2 --position 1 --json",
    "test linearity @/f --output 2 --acceleration 1 --json",
    "test centrifuge @/f --output 2 --speed 1 --radius 0.3 --json",
    "test zero-g @/f --json",
    "test orthogonality @/f --json",
    "test stability @/f @/calibration.json @/calibration.json --json",
    "test random @/f --input 1 --output-column 2 --rate 1000 --json",
    "test impact @/f --input 1 --output-column 2 --rate 1000 --json",
    "test sweep @/f --input 1 --output-column 2 --rate 1000 --json",
    "test steps @/f --input 1 --output-column 2 --rate 1000 --json",
    "test shock @/f --column 1 --rate 1000 --json",
    "test shock @/recording.csv --column 2 --required-spectrum @/f --json",
    "test step @/f --column 1 --rate 1000 --json",
    "test motion @/f --column 1 --unit m/s2 --rate 1000 --json",
    "test model @/f --json",
    "test levels @/f --level 1 --output-column 2 --output-u 3 --json",
    "test deconvolve @/f @/recording.csv --column 2 --json",
    "velocity map --encoder @/f --accelerometer @/f --json",
    "velocity tune --encoder @/f --accelerometer @/f --json",
    "velocity estimate --encoder @/recording.csv --accelerometer @/recording.csv --encoder-map @/f --json",
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
