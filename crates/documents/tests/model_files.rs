//! What the author of a wrong model file is told.

use proofmass_documents::read_model;
use proofmass_uncertainty::Refusal;

#[test]
fn refuses_wrong_files_with_line_and_field() {
    let good = include_str!("models/mass.toml");
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

/// Readings and vectors that stand in a table.
#[test]
fn columns_of_a_table_are_inputs() {
    use proofmass_documents::{ColumnTrouble, fill_columns, parse_model};
    let folder = tempfile::tempdir().unwrap();
    let write = |text: &str| std::fs::write(folder.path().join("t.csv"), text).unwrap();
    let text = |input: &str| {
        format!(
            "[[input]]\nname = \"x\"\nunit = \"V\"\nfile = \"t.csv\"\n{input}\n[[output]]\nname = \"y\"\nunit = \"V\"\nexpression = \"sum(x)\"\n"
        )
    };
    let fill = |input: &str| {
        let mut model = parse_model(&text(input)).unwrap();
        fill_columns(&mut model, folder.path()).map(|inputs| (model, inputs))
    };
    write("# of Monday\nt_s;V;u\n0;1,5;0,1\n1;2,5;0,2\n");
    let (model, inputs) = fill("column = \"V\"").unwrap();
    assert_eq!(model.input[0].observations, Some(vec![1.5, 2.5]));
    assert_eq!(inputs.len(), 1);
    assert_eq!(inputs[0].sha256.len(), 64);
    let (model, _) = fill("column = \"V\"\nholds = \"values\"\nu_column = \"u\"").unwrap();
    assert_eq!(model.input[0].values, Some(vec![1.5, 2.5]));
    assert_eq!(model.input[0].u_of_each, Some(vec![0.1, 0.2]));
    model.prepared().unwrap();

    let said = |input: &str| match fill(input) {
        Ok(_) => panic!("accepted: {input}"),
        Err(ColumnTrouble::Table(error)) => error.to_string(),
        Err(ColumnTrouble::Entry(refusal)) => refusal.to_string(),
    };
    let missing = said("column = \"W\"");
    assert!(
        missing.contains("t.csv:2") && missing.contains('W'),
        "{missing}"
    );
    assert!(said("").contains("the heading of its `column`"));
    assert!(said("column = \"V\"\nvalue = 3").contains("more than once"));
    write("t_s;V\n0;1,5\n1;wide\n");
    let wrong = said("column = \"V\"");
    assert!(
        wrong.contains("t.csv:3") && wrong.contains("wide"),
        "{wrong}"
    );
}
