//! The same sheet gives the same bytes; pictures are whole.

use std::fs;

use crate::typesetter::{path, program, run, sheet, typeset};

#[test]
fn law_same_sheet_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["one-page-en", "certificate-fa"] {
        let first = fs::read(typeset(name, folder.path())).unwrap();
        // From elsewhere, later, in another zone and with the members of the sheet in another order.
        let other = folder.path().join("other.pdf");
        let text = serde_json::to_vec(&sheet(name)).unwrap();
        let output = run(&text, &["-o", other.to_str().unwrap()]);
        assert!(output.status.success());
        assert!(first == fs::read(&other).unwrap(), "{name}");
    }
}

#[test]
fn another_sheet_is_another_document() {
    let folder = tempfile::tempdir().unwrap();
    let first = fs::read(typeset("one-page-en", folder.path())).unwrap();
    let mut changed = sheet("one-page-en");
    changed["attachments"][1]["base64"] = "e30K".into();
    let pdf = folder.path().join("changed.pdf");
    assert!(
        run(
            changed.to_string().as_bytes(),
            &["-o", pdf.to_str().unwrap()]
        )
        .status
        .success()
    );
    assert!(first != fs::read(pdf).unwrap());
}

#[test]
fn pages_become_pictures_and_no_older_page_stays_among_them() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = folder.path().join("pictures");
    let typeset = || {
        let mut command = program();
        command
            .arg(path("one-page-en"))
            .arg("-o")
            .arg(folder.path().join("c.pdf"))
            .arg("--png")
            .arg(&pictures);
        command.output().unwrap()
    };
    assert!(typeset().status.success());
    let picture = fs::read(pictures.join("page-1.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
    // A4 with 144 points per inch.
    assert_eq!(picture[16..24], [0, 0, 4, 167, 0, 0, 6, 148]);
    assert_eq!(fs::read_dir(&pictures).unwrap().count(), 1);

    fs::remove_file(folder.path().join("c.pdf")).unwrap();
    fs::write(pictures.join("page-2.png"), b"of another certificate").unwrap();
    let refused = typeset();
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("page-2.png"));
    assert!(!folder.path().join("c.pdf").exists());
}
