//! `proofmass modes` from its file to its results, and campaigns that use them.

use crate::support::{codes, json, quantity, refuse, succeed, text};
use std::fmt::Write;
use std::path::Path;

const WEDGE: &str = "
[wedge]
angle_deg = 55
length_mm = 70
width_mm = 50
toe_mm = 8
height_mm = 80
[accelerometer]
mass_g = 10
height_mm = 5
[modes]
count = 4
unknowns = 12000
accuracy = 0.05
size_mm = 40
";

/// Runs `modes` on a text and gives back the folder's result.
fn modes(folder: &Path, toml: &str) -> serde_json::Value {
    std::fs::create_dir_all(folder).expect("folder");
    let file = folder.join("wedge.toml");
    std::fs::write(&file, toml).expect("wedge.toml");
    let out = folder.join("result");
    succeed(&["modes", text(&file), "--output", text(&out)]);
    json(&out.join("result.json"))
}

fn column(path: &Path, heading: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(path).expect("a table");
    let mut lines = text.lines();
    let mut header = lines.next().expect("a header").split(',');
    let at = header.position(|h| h == heading).expect("the heading");
    lines
        .map(|l| {
            l.split(',')
                .nth(at)
                .expect("a field")
                .parse()
                .unwrap_or(f64::NAN)
        })
        .collect()
}

/// A softer base lowers every mode; a measured resonance then takes most of the stiffness's uncertainty away.
#[test]
fn law_elastic_base_and_measured_resonance() {
    let folder = tempfile::tempdir().expect("folder");
    let clamped = modes(&folder.path().join("clamped"), WEDGE);
    let bed = "[support]\nkind = \"elastic\"\nnormal_N_per_m = 3e9\ntangential_N_per_m = 3e9\n[uncertainty]\n\
               young_percent = 1\nnormal_stiffness_percent = 30\n";
    let elastic = modes(&folder.path().join("elastic"), &format!("{WEDGE}{bed}"));
    for m in 1..=4 {
        let name = format!("mode-{m}.frequency");
        let (hard, soft) = (quantity(&clamped, &name).0, quantity(&elastic, &name).0);
        assert!(soft < 0.98 * hard, "{name}: {soft} {hard}");
    }
    let (f, u, _) = quantity(&elastic, "mode-1.frequency");
    let measured = f - 0.5 * u;
    let more = format!("{bed}[[measured]]\nmode = 1\nfrequency_Hz = {measured}\nu_Hz = 5\n");
    let updated = modes(&folder.path().join("updated"), &format!("{WEDGE}{more}"));
    let (after, u_after, _) = quantity(&updated, "mode-1.frequency");
    assert!(
        (after - measured).abs() < 5.0 && u_after <= 5.0,
        "{after} ± {u_after}"
    );
    let other = |r| quantity(r, "mode-3.frequency").1;
    assert!(other(&updated) < other(&elastic));
    assert!(!codes(&updated).contains(&"model-disagrees".to_owned()));
    let far = format!(
        "{bed}[[measured]]\nmode = 1\nfrequency_Hz = {}\nu_Hz = 5\n",
        f - 6.0 * u
    );
    let wrong = modes(&folder.path().join("wrong"), &format!("{WEDGE}{far}"));
    assert!(codes(&wrong).contains(&"model-disagrees".to_owned()));
    let html = std::fs::read_to_string(folder.path().join("wrong/result/report.html"));
    assert!(
        html.expect("report")
            .contains("measured resonances lie outside")
    );
}

#[test]
fn law_search_stays_within_its_bounds_and_raises_the_first_mode() {
    let folder = tempfile::tempdir().expect("folder");
    let search = "[search]\nheaviest_g = 700\ntrials = 12\n[search.vary]\nwidth_mm = [40, 70]\nheight_mm = [60, 90]\n";
    modes(folder.path(), &format!("{WEDGE}{search}"));
    let table = folder.path().join("result/search.csv");
    let (matters, better) = (
        column(&table, "first_that_matters_Hz"),
        column(&table, "better"),
    );
    assert!(matters.len() > 4 && matters.len() <= 12, "{matters:?}");
    let last = better
        .iter()
        .rposition(|b| *b == 1.0)
        .expect("the first at least");
    assert!(matters[last] > 1.05 * matters[0], "{matters:?} {better:?}");
    for (heading, low, high) in [("width_m", 0.04, 0.07), ("height_m", 0.06, 0.09)] {
        let within = |v: &f64| (low - 1e-9..=high + 1e-9).contains(v);
        assert!(column(&table, heading).iter().all(within));
    }
    assert!(column(&table, "mass_kg")[last] <= 0.7);
}

/// A block of boxes cut into six tetrahedra each, as Gmsh writes it, in mm.
fn block(sides: [f64; 3], parts: [usize; 3]) -> String {
    let [nx, ny, nz] = parts;
    let node = |i: usize, j: usize, k: usize| 1 + i + (nx + 1) * (j + (ny + 1) * k);
    let mut nodes = String::new();
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                let at = |p: usize, n: usize, side: f64| side * p as f64 / n as f64;
                let (x, y, z) = (
                    at(i, nx, sides[0]),
                    at(j, ny, sides[1]),
                    at(k, nz, sides[2]),
                );
                writeln!(nodes, "{} {x} {y} {z}", node(i, j, k)).expect("text");
            }
        }
    }
    let mut elements = String::new();
    let mut count = 0;
    let mut put = |kind: u32, group: u32, corners: &[usize]| {
        count += 1;
        let words: Vec<String> = corners.iter().map(usize::to_string).collect();
        writeln!(elements, "{count} {kind} 2 {group} 1 {}", words.join(" ")).expect("text");
    };
    const WAYS: [[usize; 3]; 6] = [
        [0, 1, 2],
        [0, 2, 1],
        [1, 0, 2],
        [1, 2, 0],
        [2, 0, 1],
        [2, 1, 0],
    ];
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                for way in WAYS {
                    let mut at = [i, j, k];
                    let mut corners = vec![node(i, j, k)];
                    for axis in way {
                        at[axis] += 1;
                        corners.push(node(at[0], at[1], at[2]));
                    }
                    put(4, 2, &corners);
                }
                if k == 0 {
                    put(
                        2,
                        1,
                        &[node(i, j, 0), node(i + 1, j + 1, 0), node(i + 1, j, 0)],
                    );
                    put(
                        2,
                        1,
                        &[node(i, j, 0), node(i, j + 1, 0), node(i + 1, j + 1, 0)],
                    );
                }
            }
        }
    }
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 1 \"base\"\n3 2 \"body\"\n$EndPhysicalNames\n\
         $Nodes\n{}\n{nodes}$EndNodes\n$Elements\n{count}\n{elements}$EndElements\n",
        (nx + 1) * (ny + 1) * (nz + 1)
    )
}

const MESH: &str = "
[mesh]
file = \"block.msh\"
base = \"base\"
gluing_point_mm = [15, 15, 60]
[materials.body]
young_GPa = 70
poisson = 0.0
density_kg_per_m3 = 2700
[modes]
count = 8
unknowns = 40000
";

/// Without lateral contraction the axial mode of a clamped block is c/(4 l), whatever its section.
#[test]
fn known_axial_mode_of_an_imported_mesh() {
    let folder = tempfile::tempdir().expect("folder");
    let mesh = block([30.0, 30.0, 60.0], [3, 3, 6]);
    std::fs::write(folder.path().join("block.msh"), &mesh).expect("mesh");
    let result = modes(folder.path(), MESH);
    let exact = (70e9f64 / 2700.0).sqrt() / (4.0 * 0.060);
    let table = folder.path().join("result/modes.csv");
    let drive = column(&table, "participation_z_sqrt(kg)");
    let axial = (0..drive.len()).max_by(|&a, &b| drive[a].abs().total_cmp(&drive[b].abs()));
    let name = format!("mode-{}.frequency", axial.expect("a mode") + 1);
    let (f, _, expanded) = quantity(&result, &name);
    assert!((f / exact - 1.0).abs() < 1e-3, "{f} {exact}");
    assert!(
        (f - exact).abs() < expanded.max(1e-4 * exact),
        "{f} ± {expanded}, {exact}"
    );
    assert!(folder.path().join("result/modes.vtu").exists());

    let said = |toml: &str, mesh: &str| {
        std::fs::write(folder.path().join("block.msh"), mesh).expect("mesh");
        let file = folder.path().join("bad.toml");
        std::fs::write(&file, toml).expect("toml");
        refuse(&[
            "modes",
            text(&file),
            "--output",
            text(&folder.path().join("bad")),
        ])
    };
    let table = [
        (
            MESH.replace("\"base\"", "\"floor\""),
            mesh.clone(),
            "no group of triangles `floor`",
        ),
        (
            MESH.replace("materials.body", "materials.top"),
            mesh.clone(),
            "no such region",
        ),
        (
            MESH.replace("15, 15, 60", "15, 15, 600"),
            mesh.clone(),
            "off the nearest face",
        ),
        (
            MESH.replace("count = 8", "unit = 8\ncount = 8"),
            mesh.clone(),
            "unit",
        ),
        (
            MESH.to_owned(),
            mesh.replacen("\n1 0 0 0\n", "\n1 10 10 20\n", 1),
            "inverted or flat",
        ),
        (
            MESH.to_owned(),
            mesh.replace("2.2 0 8", "2.2 1 8"),
            "binary",
        ),
        (
            MESH.to_owned(),
            mesh[..mesh.len() / 2].to_owned(),
            "block.msh",
        ),
        (MESH.to_owned(), String::new(), "no Gmsh mesh"),
        (
            MESH.replace("40000", "2000"),
            mesh.clone(),
            "2000 are allowed",
        ),
    ];
    for (toml, mesh, due) in table {
        let said = said(&toml, &mesh);
        assert!(said.contains(due), "{due}: {said}");
    }
}

/// The model of the wedge as the bench has it: what a vibrometer finds there is the model and the table's own motion, and a
/// campaign that names the model is warned of its resonance, as is its plan.
#[test]
fn crosscheck_model_vibrometer_and_campaign() {
    let folder = tempfile::tempdir().expect("folder");
    let list = "[transfer]\ndamping = 0.005\nfrequencies_Hz = [160, 1000, 2000]\n";
    let result = modes(&folder.path().join("wedge"), &format!("{WEDGE}{list}"));
    assert!(quantity(&result, "mode-1.frequency").0 > 2000.0);
    let motion = folder.path().join("wedge/result/spurious.csv");
    let campaign = folder.path().join("vibrometer");
    let head = ["simulate", "spurious-motion", "--output", text(&campaign)];
    let tail = [
        "--frequencies",
        "160,1000,2000",
        "--wedge-motion",
        text(&motion),
    ];
    succeed(&[&head[..], &tail].concat());
    let file = campaign.join("campaign.toml");
    let toml = std::fs::read_to_string(&file).expect("campaign.toml");
    let model =
        "\n[[model]]\nlabel = \"finite elements\"\nfile = \"../wedge/result/spurious.csv\"\n";
    std::fs::write(&file, format!("{toml}{model}")).expect("campaign.toml");
    let out = campaign.join("result");
    succeed(&["calibrate", text(&campaign), "--output", text(&out)]);
    let table = std::fs::read_to_string(out.join("comparison.csv")).expect("comparison.csv");
    let rows: Vec<Vec<&str>> = table
        .lines()
        .skip(1)
        .map(|l| l.split(',').collect())
        .collect();
    assert_eq!(rows.len(), 9, "{table}");
    for row in rows {
        assert_eq!(row[1], "finite elements");
        let difference: f64 = row[5].parse().expect("a number");
        // The bench's own transverse motion is 1.0 % and 0.8 %; ten readings repeat to 0.2 % of the whole and 2·10⁻⁴.
        let due = match row[4] {
            "x" => 0.010,
            "y" => 0.008,
            _ => 0.0,
        };
        assert!(
            (difference - due).abs() < 4.0 * 0.002 / 10f64.sqrt() * 1.2 + 4e-4,
            "{row:?}"
        );
    }
    let codes_of = |out: &Path| codes(&json(&out.join("result.json")));
    assert!(codes_of(&out).contains(&"calculated-motion-disagrees".to_owned()));
    let place = folder.path().join("late");
    let late = [
        &head[..3],
        &[text(&place)],
        &["--frequencies", "3000"],
        &tail[2..],
    ]
    .concat();
    assert!(refuse(&late).contains("ends at 2000 Hz"));

    // On a soft base its bounce lies among the frequencies of a campaign.
    let bed = "[support]\nkind = \"elastic\"\nnormal_N_per_m = 4e7\ntangential_N_per_m = 4e7\n";
    modes(&folder.path().join("soft"), &format!("{WEDGE}{bed}"));
    let table = folder.path().join("soft/result/modes.csv");
    let drive = column(&table, "participation_z_sqrt(kg)");
    let most = (0..drive.len()).max_by(|&a, &b| drive[a].abs().total_cmp(&drive[b].abs()));
    let resonance = column(&table, "frequency_Hz")[most.expect("a mode")].round();
    assert!((800.0..2500.0).contains(&resonance), "{resonance}");
    let campaign = folder.path().join("triaxial");
    let with = format!("80,160,{resonance}");
    let head = [
        "simulate",
        "shaker",
        "--phasors",
        "--output",
        text(&campaign),
    ];
    succeed(
        &[
            &head[..],
            &["--configurations", "20", "--frequencies", &with],
        ]
        .concat(),
    );
    let file = campaign.join("campaign.toml");
    let toml = std::fs::read_to_string(&file).expect("campaign.toml");
    let named = "fixtures = [\"../soft/result/result.json\"]\n";
    std::fs::write(&file, format!("{named}{toml}")).expect("campaign.toml");
    let (out, plan) = (campaign.join("result"), campaign.join("plan"));
    succeed(&["calibrate", text(&campaign), "--output", text(&out)]);
    succeed(&["plan", text(&campaign), "--output", text(&plan)]);
    for place in [&out, &plan] {
        let found = codes_of(place);
        for code in ["fixture-resonance", "fixture-beyond-its-range"] {
            assert!(
                found.contains(&code.to_owned()),
                "{}: {found:?}",
                place.display()
            );
        }
    }
    std::fs::write(&file, format!("fixtures = [\"campaign.toml\"]\n{toml}"))
        .expect("campaign.toml");
    let said = refuse(&[
        "plan",
        text(&campaign),
        "--output",
        text(&folder.path().join("no")),
    ]);
    assert!(said.contains("result.json"), "{said}");
}

#[test]
fn refuses_what_is_no_fixture() {
    let folder = tempfile::tempdir().expect("folder");
    let file = folder.path().join("wedge.toml");
    let out = folder.path().join("result");
    let said = |toml: &str| {
        std::fs::write(&file, toml).expect("toml");
        let said = refuse(&["modes", text(&file), "--output", text(&out)]);
        assert!(!out.exists(), "{said}");
        said
    };
    let table = [
        (String::new(), "the file is empty"),
        ("title = \"x\"\n".into(), "describes no fixture"),
        ("[wedge".into(), "wedge.toml"),
        (
            WEDGE.replace("width_mm = 50", "width_mm = nan"),
            "positive number",
        ),
        (WEDGE.replace("width_mm = 50", "width_mm = 1e300"), "width"),
        (WEDGE.replace("width_mm", "width_cm"), "width_cm"),
        (WEDGE.replace("angle_deg = 55", "angle_deg = 95"), "angle"),
        (
            WEDGE.replace("mass_g = 10", "mass_g = -1"),
            "mass of the accelerometer",
        ),
        (
            WEDGE.replace("mass_g = 10", "mass_g = inf"),
            "mass of the accelerometer",
        ),
        (WEDGE.replace("count = 4", "count = 0"), "0 modes"),
        (WEDGE.replace("count = 4", "count = 4000"), "4000 modes"),
        (
            WEDGE.replace("accuracy = 0.05", "accuracy = nan"),
            "accuracy",
        ),
        (WEDGE.replace("size_mm = 40", "size_mm = 0"), "size"),
        (
            WEDGE.replace("size_mm = 40", "size_mm = 0.01"),
            "size of the elements",
        ),
        (
            WEDGE.replace("unknowns = 12000", "unknowns = 300"),
            "size of the elements",
        ),
        (
            format!("{WEDGE}[material]\npreset = \"aluminium\"\ndensity_kg_per_m3 = 0\n"),
            "density",
        ),
        (
            format!("{WEDGE}[material]\npreset = \"aluminium\"\npoisson = 0.5\n"),
            "Poisson",
        ),
        (
            format!("{WEDGE}[material]\nyoung_GPa = 70\n"),
            "not complete",
        ),
        (format!("{WEDGE}[support]\nkind = \"springy\"\n"), "springy"),
        (
            format!("{WEDGE}[transfer]\nfrequencies_Hz = [-1]\n"),
            "-1 Hz",
        ),
        (format!("{WEDGE}[transfer]\ndamping = 0\n"), "damping"),
        (
            format!("{WEDGE}[uncertainty]\nyoung_percent = nan\n"),
            "out of range",
        ),
        (
            format!("{WEDGE}[[measured]]\nmode = 9\nfrequency_Hz = 3000\nu_Hz = 1\n"),
            "was not calculated",
        ),
        (
            format!("{WEDGE}[[measured]]\nmode = 1\nfrequency_Hz = 3000\nu_Hz = 0\n"),
            "positive",
        ),
        (
            format!("{WEDGE}[search.vary]\nwidth_mm = [60, 70]\n"),
            "outside its own bounds",
        ),
        (
            format!("{WEDGE}[evaluation]\nprobability = 2\n"),
            "probability",
        ),
    ];
    for (toml, due) in table {
        let said = said(&toml);
        assert!(said.contains(due), "{due}: {said}");
    }
}
