//! What the author of a wrong model file is told.

use proofmass_io::read_model;
use proofmass_uncertainty::Refusal;

#[test]
fn refuses_wrong_files_with_line_and_field() {
    let good = include_str!("../../../examples/uncertainty/mass.toml");
    for (from, to, line, word) in [
        ("u = 0.020", "u = \"much\"", 15, "much"),
        ("u = 0.020", "v = 0.020", 15, "`v`"),
        (
            "kind = \"rectangular\", lower = 1.10",
            "kind = \"square\", lower = 1.10",
            21,
            "square",
        ),
        ("lower = 1.10", "lower = 1.50", 21, "rho_a: upper = 1.3"),
        ("1 / rho_W", "1 / rho_V", 38, "rho_V"),
        (
            "unit = \"mg\"\ndescription = \"small",
            "units = \"mg\"\ndescription = \"small",
            13,
            "units",
        ),
        ("name = \"dm_R\"", "name = \"sin\"", 12, "means a function"),
        ("name = \"dm_R\"", "name = \"d-m\"", 12, "must be a letter"),
        (
            "name = \"dm_R\"",
            "name = \"m_R\"",
            12,
            "m_R is defined twice",
        ),
    ] {
        assert!(good.contains(from), "{from}");
        match read_model(&good.replacen(from, to, 1)) {
            Err(Refusal::File { line: got, reason }) => {
                assert!(reason.contains(word), "{to}: {reason}");
                assert_eq!(got, Some(line), "{to}: {reason}");
            }
            other => panic!("{to}: {other:?}"),
        }
    }
}
