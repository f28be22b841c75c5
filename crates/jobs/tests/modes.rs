//! The job `modes`: from a file to a result and back, a mesh from elsewhere, a campaign that names the result.

use proofmass_fixture::{Fineness, WedgeMesh};
use proofmass_jobs::campaign::CampaignFile;
use proofmass_jobs::modes::{Body, ModesFile, ModesOutcome, fixture_findings, read_fixtures};
use proofmass_jobs::{Job, Memory, Outcome, StoredResult, Unwatched};
use std::fmt::Write;
use std::sync::Arc;

const WEDGE: &str = "
[wedge]
angle_deg = 55
length_mm = 70
width_mm = 50
toe_mm = 8
height_mm = 80
gluing_mm = -3
[accelerometer]
mass_g = 10
height_mm = 5
[modes]
count = 4
unknowns = 12000
accuracy = 0.05
size_mm = 40
[transfer]
frequencies_Hz = [100, 1000, 3000]
[uncertainty]
young_percent = 2
width_mm = 0.1
";

fn open(files: &[(&str, String)]) -> Result<ModesFile, proofmass_io::Error> {
    let store = files.iter().fold(Memory::new(), |store, (name, text)| {
        store.file(*name, text.clone())
    });
    ModesFile::of(CampaignFile::read(Arc::new(store), files[0].0)?)
}

fn evaluate(file: &ModesFile) -> ModesOutcome {
    file.job.evaluate(&file.data(), &Unwatched).unwrap()
}

#[test]
fn law_a_result_read_back_is_the_same_and_looks_the_same() {
    let file = open(&[("wedge.toml", WEDGE.to_owned())]).unwrap();
    let record = file.record(Some("2026-11-21".into()));
    let filed = StoredResult::new(record, &evaluate(&file)).unwrap();
    let bytes = filed.to_json().unwrap();
    let again = StoredResult::from_json(&bytes).unwrap();
    assert_eq!(filed.files().unwrap(), again.files().unwrap());
    // Request as data, both ways.
    let text = serde_json::to_string(&file.job).unwrap();
    let job: proofmass_jobs::modes::ModesJob = serde_json::from_str(&text).unwrap();
    assert_eq!(job, file.job);
    let html = filed.html().unwrap();
    assert!(html.contains("mode 1: ") && html.contains("Spurious motion over frequency"));
    let names: Vec<String> = filed.files().unwrap().into_iter().map(|f| f.0).collect();
    for name in ["modes.csv", "spurious.csv", "slope.csv", "modes.vtu"] {
        assert!(names.iter().any(|n| n == name), "{names:?}");
    }
}

/// A wedge by its dimensions, and its coarsest mesh as a Gmsh file with a named base: the same frequencies on the same mesh.
#[test]
fn crosscheck_a_mesh_file_against_the_dimensions() {
    let file = open(&[("wedge.toml", WEDGE.to_owned())]).unwrap();
    let Body::Wedge(design) = &file.job.body else {
        panic!("a wedge")
    };
    let fineness = Fineness {
        size: 0.040,
        parts: 1,
    };
    let mesh = WedgeMesh::new(&design.wedge, fineness).unwrap();
    let (nodes, elements) = (mesh.fixture.mesh.nodes(), mesh.fixture.mesh.elements());
    let mut text = String::from(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 \"on the table\"\n3 2 \"wedge\"\n$EndPhysicalNames\n$Nodes\n",
    );
    writeln!(text, "{}", nodes.len()).unwrap();
    for (i, x) in nodes.iter().enumerate() {
        writeln!(
            text,
            "{} {:?} {:?} {:?}",
            i + 1,
            1e3 * x[0],
            1e3 * x[1],
            1e3 * x[2]
        )
        .unwrap();
    }
    let base = &mesh.fixture.base;
    write!(
        text,
        "$EndNodes\n$Elements\n{}\n",
        elements.len() + base.len()
    )
    .unwrap();
    for (i, f) in base.iter().enumerate() {
        writeln!(
            text,
            "{} 9 2 1 1 {}",
            i + 1,
            f.map(|n| (n + 1).to_string()).join(" ")
        )
        .unwrap();
    }
    for (i, e) in elements.iter().enumerate() {
        let mut e = *e;
        e.swap(8, 9);
        let words = e.map(|n| (n + 1).to_string()).join(" ");
        writeln!(text, "{} 11 2 2 1 {words}", base.len() + i + 1).unwrap();
    }
    text.push_str("$EndElements\n");
    let point = mesh.fixture.seat.point.map(|c| 1e3 * c);
    let toml = format!(
        "[mesh]\nfile = \"w.msh\"\nbase = \"on the table\"\ngluing_point_mm = {point:?}\n[materials.wedge]\npreset = \"aluminium\"\n\
         [accelerometer]\nmass_g = 10\nheight_mm = 5\n[modes]\ncount = 4\naccuracy = 0.2\nunknowns = 40000\n[uncertainty]\nsize_percent = 0.1\n"
    );
    let meshed = open(&[("m.toml", toml.clone()), ("w.msh", text.clone())]).unwrap();
    let (a, b) = (evaluate(&file), evaluate(&meshed));
    // First level of both: the same mesh.
    let (a, b) = (&a.levels()[0].frequencies, &b.levels()[0].frequencies);
    for m in 0..4 {
        let (f, g) = (a[m], b[m]);
        assert!((f / g - 1.0).abs() < 1e-6, "{f} {g}");
    }
    let wrong = toml.replace("on the table", "floor");
    let wrong = open(&[("m.toml", wrong), ("w.msh", text)]).unwrap();
    let trouble = wrong.job.evaluate(&wrong.data(), &Unwatched).unwrap_err();
    assert!(trouble.to_string().contains("`floor`"), "{trouble}");
    assert!(trouble.hint().unwrap().contains("on the table"));
}

#[test]
fn known_findings_of_a_campaign_that_names_the_wedge() {
    let file = open(&[("wedge.toml", WEDGE.to_owned())]).unwrap();
    let filed = StoredResult::new(file.record(None), &evaluate(&file)).unwrap();
    let store = Memory::new()
        .file("campaign.toml", "kind = \"shaker-triaxial\"\n")
        .file("w/result.json", filed.to_json().unwrap());
    let campaign = CampaignFile::read(Arc::new(store), "campaign.toml").unwrap();
    let fixtures = read_fixtures(&campaign, &["w/result.json".to_owned()]).unwrap();
    let alpha = 55f64.to_radians();
    let resonance = fixtures[0]
        .resonances
        .iter()
        .find(|r| r[2] >= 0.01)
        .unwrap()[0];
    let codes = |points: &[(f64, f64)]| -> Vec<String> {
        fixture_findings(&fixtures, points)
            .iter()
            .map(|f| f.code().to_owned())
            .collect()
    };
    assert!(codes(&[(alpha, 20.0), (alpha, 100.0)]).is_empty());
    let both = codes(&[(alpha, 20.0), (alpha, resonance)]);
    for code in ["fixture-resonance", "fixture-beyond-its-range"] {
        assert!(both.iter().any(|c| c == code), "{both:?}");
    }
    // Another wedge is another matter.
    assert!(codes(&[(0.3, resonance)]).is_empty());
    assert!(read_fixtures(&campaign, &["campaign.toml".to_owned()]).is_err());
    assert!(read_fixtures(&campaign, &["none.json".to_owned()]).is_err());
}

#[test]
fn refuses_files_that_describe_no_fixture() {
    let refusal = |text: &str| {
        let error = open(&[("wedge.toml", text.to_owned())]).err().unwrap();
        error.to_string()
    };
    assert!(refusal("title = \"x\"\n").contains("describes no fixture"));
    assert!(refusal(&WEDGE.replace("width_mm = 50", "widht_mm = 50")).contains("widht_mm"));
    assert!(
        refusal(&WEDGE.replace("width_mm = 50", "width_mm = -5"))
            .contains("must be a positive number")
    );
    assert!(refusal(&WEDGE.replace("young_percent", "joung_percent")).contains("is not known"));
    assert!(
        refusal(&WEDGE.replace(
            "width_mm = 0.1",
            "bore_depth_mm = 0.1\nsides_young_percent = 1"
        ))
        .contains("no such thing")
    );
    assert!(refusal(&format!("{WEDGE}[search.vary]\nwide_mm = [1, 2]\n")).contains("no dimension"));
    assert!(refusal(&format!("{WEDGE}[material]\npreset = \"mithril\"\n")).contains("mithril"));
    let free = open(&[(
        "wedge.toml",
        format!("{WEDGE}[support]\nkind = \"elastic\"\n"),
    )]);
    assert!(free.err().unwrap().to_string().contains("normal_N_per_m"));
}

/// What is asked above the last mode is answered without the modes above; below it, all that matter are there.
#[test]
fn known_transfer_beyond_the_last_mode_is_told() {
    let missing = |frequencies: &str| {
        let text = WEDGE.replace("100, 1000, 3000", frequencies);
        let outcome = evaluate(&open(&[("wedge.toml", text)]).unwrap());
        let last = outcome.modes()[3].frequency;
        let findings = outcome.findings();
        let found = findings.iter().find(|f| f.code() == "modes-missing");
        (found.map(|f| f.evidence_text().to_owned()), last)
    };
    assert_eq!(missing("100, 1000, 3000").0, None);
    let (found, last) = missing("100, 1000, 50000");
    assert_eq!(found, Some(format!("last mode {last:.0} Hz")));
}

/// Bending along and across has one frequency where the wedge is about as wide as it is long.
#[test]
fn known_modes_that_may_change_places() {
    let found = |width: u32| {
        let text = WEDGE
            .replace("width_mm = 50", &format!("width_mm = {width}"))
            .replace("unknowns = 12000", "unknowns = 6000")
            .replace("accuracy = 0.05", "accuracy = 0.2")
            .replace("width_mm = 0.1", "width_mm = 1");
        let outcome = evaluate(&open(&[("wedge.toml", text)]).unwrap());
        let gap = outcome.modes()[1].frequency - outcome.modes()[0].frequency;
        (outcome.findings().to_vec(), gap)
    };
    let (told, gap) = found(70);
    let close = told.iter().find(|f| f.code() == "close-modes").unwrap();
    let evidence = close.evidence_text();
    assert!(
        evidence.starts_with(&format!("{gap:.1} Hz apart")),
        "{evidence}"
    );
    assert!(close.to_string().contains("modes 1 and 2"), "{close}");
    assert!(found(50).0.is_empty());
}

/// A cube on an adhesive of which modulus and thickness are known to a factor.
const GLUED: &str = "
[device]
size_mm = [12, 12, 12]
material.preset = \"steel\"
[device.layer]
thickness_mm = [0.1, 0.4]
young_GPa = [0.05, 0.2]
poisson = 0.38
";

fn without_accelerometer(text: &str) -> String {
    text.replace("[accelerometer]\nmass_g = 10\nheight_mm = 5\n", "")
}

fn file_of(filed: &StoredResult, name: &str) -> String {
    let files = filed.files().unwrap();
    let bytes = files
        .into_iter()
        .find(|f| f.0 == name)
        .unwrap_or_else(|| panic!("{name}"))
        .1;
    String::from_utf8(bytes).unwrap()
}

/// The bounds of a layer give an interval of every frequency, which is part of U, and the two ends enclose what a layer between them gives.
#[test]
fn law_a_layer_with_bounds_gives_intervals() {
    let text = without_accelerometer(WEDGE);
    let file = open(&[("wedge.toml", format!("{text}{GLUED}"))]).unwrap();
    let outcome = evaluate(&file);
    let [soft, stiff] = outcome.layer_ends().unwrap();
    // M/t at both ends: E/t differs by 16.
    assert!((stiff.stiffness.normal / soft.stiffness.normal / 16.0 - 1.0).abs() < 1e-9);
    let quantities = outcome.quantities();
    for (m, mode) in outcome.modes().iter().enumerate() {
        let [low, high] = [soft.frequencies[m], stiff.frequencies[m]];
        assert!(
            low <= mode.frequency && mode.frequency <= high,
            "{low} {high}"
        );
        // A rectangular distribution over the farther end, and 2 % of Young's modulus.
        let half = (high / mode.frequency).max(mode.frequency / low).ln();
        assert!(quantities[m].u.unwrap() >= half / 3f64.sqrt() * mode.frequency * (1.0 - 1e-9));
    }
    assert!(soft.frequencies[0] < 0.8 * stiff.frequencies[0]);
    // A layer that lies between.
    let between = GLUED
        .replace("[0.1, 0.4]", "0.15")
        .replace("[0.05, 0.2]", "0.12");
    let between = evaluate(&open(&[("wedge.toml", format!("{text}{between}"))]).unwrap());
    assert!(between.layer_ends().is_none());
    for (m, mode) in between.modes().iter().enumerate() {
        assert!(soft.frequencies[m] <= mode.frequency && mode.frequency <= stiff.frequencies[m]);
    }
    // Device and gluing point move otherwise; the wedge under the device is usable further.
    let below = outcome.below().unwrap();
    assert!(outcome.usable().unwrap() < below.usable.unwrap_or(f64::INFINITY));
    let filed = StoredResult::new(file.record(None), &outcome).unwrap();
    assert!(file_of(&filed, "layer.csv").starts_with("mode,softest_Hz,middle_Hz,stiffest_Hz"));
    let spurious = file_of(&filed, "spurious.csv");
    assert_ne!(spurious, file_of(&filed, "gluing.csv"));
    let again = StoredResult::from_json(&filed.to_json().unwrap()).unwrap();
    assert_eq!(filed.files().unwrap(), again.files().unwrap());
}

/// A measured resonance takes most of what the layer leaves open away.
#[test]
fn law_a_measured_resonance_tells_the_layer() {
    let text = without_accelerometer(WEDGE);
    let open_layer = evaluate(&open(&[("wedge.toml", format!("{text}{GLUED}"))]).unwrap());
    let f = open_layer.modes()[0].frequency;
    let measured = format!(
        "{text}{GLUED}[[measured]]\nmode = 1\nfrequency_Hz = {}\nu_Hz = 5\n",
        1.05 * f
    );
    let outcome = evaluate(&open(&[("wedge.toml", measured)]).unwrap());
    let (before, after) = (open_layer.quantities(), outcome.quantities());
    assert!((after[0].value - 1.05 * f).abs() < 10.0);
    let u = |of: &[proofmass_documents::StatedQuantity], m: usize| of[m].u.unwrap();
    assert!(u(&after, 0) < 0.1 * u(&before, 0) && u(&after, 1) < 0.7 * u(&before, 1));
}

#[test]
fn known_a_layer_that_bulges_is_told() {
    let text = without_accelerometer(WEDGE);
    let thick = "[device]\nsize_mm = [10, 10, 10]\nmass_g = 8\n[device.layer]\nthickness_mm = 3\nyoung_GPa = 0.5\npoisson = 0.45\n";
    let outcome = evaluate(&open(&[("wedge.toml", format!("{text}{thick}"))]).unwrap());
    assert!(
        outcome
            .findings()
            .iter()
            .any(|f| f.code() == "layer-bulges")
    );
}

/// Two fixtures in one report: their own frequencies, and the same two answers as each alone.
#[test]
fn law_two_fixtures_stand_side_by_side() {
    let low = format!("title = \"low\"\n{WEDGE}").replace("height_mm = 80", "height_mm = 60");
    let tall = format!("title = \"tall\"\n{WEDGE}");
    let [first, second] = [&tall, &low].map(|t| open(&[("wedge.toml", t.clone())]).unwrap());
    let alone = evaluate(&second);
    let both = first.beside(second);
    let outcome = evaluate(&both);
    let beside = outcome.beside().unwrap();
    assert_eq!(beside.names, ["tall", "low"]);
    assert_eq!(beside.other.modes(), alone.modes());
    let filed = StoredResult::new(both.record(None), &outcome).unwrap();
    let table = file_of(&filed, "beside.csv");
    assert!(table.starts_with(
        "mode,first_Hz,first_U_Hz,first_k,first_weight,second_Hz,second_U_Hz,second_k,second_weight"
    ));
    assert_eq!(table.lines().count(), 5);
    let motion = file_of(&filed, "beside-motion.csv");
    assert_eq!(motion.lines().count(), 4);
    assert!(filed.html().unwrap().contains("Side by side"));
    let text = serde_json::to_string(&both.job).unwrap();
    let job: proofmass_jobs::modes::ModesJob = serde_json::from_str(&text).unwrap();
    assert_eq!(job, both.job);
}

#[test]
fn known_search_for_least_motion_from_a_file() {
    let search = "[search]\ngoal = \"least-motion\"\nup_to_Hz = 1500\ntrials = 5\n[search.vary]\nheight_mm = [60, 100]\n";
    let file = open(&[("wedge.toml", format!("{WEDGE}{search}"))]).unwrap();
    let outcome = evaluate(&file);
    let found = outcome.search().unwrap();
    let motion = |t: &proofmass_fixture::Trial| t.motion.unwrap();
    assert!(motion(found.best_trial().unwrap()) <= motion(&found.trials[0]));
    let filed = StoredResult::new(file.record(None), &outcome).unwrap();
    assert!(
        filed
            .html()
            .unwrap()
            .contains("largest spurious motion up to 1.50 kHz")
    );
    assert!(file_of(&filed, "search.csv").contains("largest_motion"));
}

#[test]
fn refuses_devices_layers_and_goals_that_are_not_told_whole() {
    let text = without_accelerometer(WEDGE);
    for (more, word) in [
        ("[device]\nsize_mm = [12, 12, 0]\n", "height of the device"),
        (
            "[device]\nsize_mm = [12, 12, 12]\n[device.layer]\nthickness_mm = 0.1\npoisson = 0.3\n",
            "young_GPa",
        ),
        (
            "[device]\nsize_mm = [12, 12, 12]\n[device.layer]\nthickness_mm = [0.2, 0.1]\nyoung_GPa = 1\npoisson = 0.3\n",
            "[least, largest]",
        ),
        (
            "[device]\nsize_mm = [12, 12, 12]\n[device.layer]\nthickness_mm = 0.1\nnormal_N_per_m3 = 1e12\ntangential_N_per_m3 = 1e12\n",
            "not by both",
        ),
        (
            "[device]\nsize_mm = [12, 12, 12]\n[device.layer]\nnormal_N_per_m3 = 1e12\n",
            "tangential_N_per_m3",
        ),
        (
            "[search]\ngoal = \"least-motion\"\n[search.vary]\ntoe_mm = [5, 10]\n",
            "end of the band",
        ),
        (
            "[search]\nup_to_Hz = 100\n[search.vary]\ntoe_mm = [5, 10]\n",
            "least-motion",
        ),
    ] {
        let error = open(&[("wedge.toml", format!("{text}{more}"))]).unwrap_err();
        let said = format!("{error} {:?}", error.hint());
        assert!(said.contains(word), "{word}: {said}");
    }
    let footprint = text.replace("[modes]", "footprint_mm = [5, 5]\n[modes]");
    let error = open(&[(
        "wedge.toml",
        format!("{footprint}[device]\nsize_mm = [9, 9, 9]\n"),
    )])
    .unwrap_err();
    assert!(error.to_string().contains("that of the device"), "{error}");
}
