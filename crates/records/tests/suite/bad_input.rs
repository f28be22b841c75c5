//! What damaged, foreign, half copied and hostile input gets.

use crate::places::{each, make};
use crate::recorded::*;
use proofmass_records::*;

fn refusal(place: &std::path::Path) -> String {
    let trouble = Records::open(place.to_str().unwrap())
        .err()
        .expect("a refusal");
    assert!(trouble.hint().is_some(), "{trouble}");
    trouble.to_string()
}

#[test]
fn refuses_what_is_no_file_of_records() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("lab.records");
    assert!(refusal(&place).contains("there are no records"));
    std::fs::write(
        &place,
        "some text that is longer than the head of a database, ".repeat(9),
    )
    .unwrap();
    assert!(refusal(&place).contains("no file of records"));
    std::fs::remove_file(&place).unwrap();
    {
        let other = rusqlite::Connection::open(&place).unwrap();
        other
            .execute_batch("CREATE TABLE a (b); PRAGMA user_version = 7")
            .unwrap();
    }
    assert!(refusal(&place).contains("another program"));
    {
        let other = rusqlite::Connection::open(&place).unwrap();
        other
            .execute_batch("PRAGMA application_id = 1886220901; PRAGMA user_version = 99")
            .unwrap();
    }
    assert!(refusal(&place).contains("version 99"));
}

#[test]
fn refuses_a_copy_that_did_not_end() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, half) = (folder.path().join("whole"), folder.path().join("half"));
    let mut records = make(folder.path().join("lab.records").to_str().unwrap());
    for k in 0..50 {
        file(
            &mut records,
            &candidate(&k.to_string(), "2026-01-01", 1.0, 0.01, 0.005),
            None,
        );
    }
    records.backup(&whole).unwrap();
    assert!(
        Records::open(whole.to_str().unwrap())
            .unwrap()
            .check()
            .unwrap()
            .is_whole()
    );
    let bytes = std::fs::read(&whole).unwrap();
    std::fs::write(&half, &bytes[..bytes.len() / 2]).unwrap();
    assert!(refusal(&half).contains("cut off"), "{}", refusal(&half));
}

#[test]
fn law_read_only_records_are_read_and_refuse_to_grow() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("lab.records");
    let mut records = make(place.to_str().unwrap());
    file(
        &mut records,
        &candidate("1", "2026-01-01", 1.0, 0.01, 0.005),
        None,
    );
    drop(records);
    let mut records = Records::open(place.to_str().unwrap()).unwrap();
    assert_eq!(records.devices(false).unwrap().len(), 1);
    let refused = records
        .add(TODAY, None, Content::Device(device("2")))
        .unwrap_err();
    assert!(
        refused.hint().unwrap().contains("cannot be written"),
        "{refused}: {:?}",
        refused.hint()
    );
}

#[test]
fn law_an_older_form_is_upgraded_when_asked_and_a_copy_is_kept() {
    each(|place, _| {
        drop(Records::make_of_version(place, 1).unwrap());
        let refused = Records::open(place).err().unwrap();
        assert!(refused.hint().unwrap().contains("records upgrade"));
        assert!(Records::open_or_make(place).is_err(), "never in silence");
        let copy = Records::upgrade(place).unwrap().expect("a copy");
        assert!(copy.contains("version"), "{copy}");
        assert_eq!(Records::upgrade(place).unwrap(), None);
        let mut records = Records::open_to_add(place).unwrap();
        records
            .add(TODAY, None, Content::Device(device("1")))
            .unwrap();
        assert!(records.check().unwrap().is_whole());
    });
}

#[test]
fn law_text_stays_text() {
    each(|place, _| {
        let mut records = make(place);
        let evil = "'); DROP TABLE entry; -- <script>alert(1)</script> =cmd|' /C calc'!A0 ?1 $1";
        let mut odd = candidate("3", "2026-01-01", 1.0, 0.01, 0.005);
        odd.device.serial = Some(evil.into());
        odd.device.manufacturer = Some("=1+1".into());
        file(&mut records, &odd, None);
        assert_eq!(records.device(evil).unwrap(), 1);
        let tables = proofmass_jobs::Gathered::default();
        records.export_csv(&tables).unwrap();
        let source = proofmass_jobs::Store::open(&tables.into_memory(), "devices.csv").unwrap();
        let (bytes, _) = source.into_bytes(1 << 20).unwrap();
        assert!(String::from_utf8(bytes).unwrap().contains("'=1+1"));
        let html = proofmass_report::html::render(&page::list(&mut records, false, TODAY).unwrap())
            .unwrap();
        assert!(!html.contains("<script>alert"));
        assert!(records.check().unwrap().is_whole());
    });
}

#[test]
fn law_a_serial_number_in_two_spellings_is_told() {
    each(|place, _| {
        let mut records = make(place);
        file(
            &mut records,
            &candidate("SN-0042", "2026-01-01", 1.0, 0.01, 0.005),
            None,
        );
        let other = file(
            &mut records,
            &candidate("sn 0042", "2026-02-01", 1.0, 0.01, 0.005),
            None,
        );
        assert!(codes(&other).contains(&"serial-spelled-otherwise".to_owned()));
        let filing = Filing {
            new_device: true,
            ..Default::default()
        };
        let sure = records
            .file_candidate(
                &candidate("SN0042", "2026-03-01", 1.0, 0.01, 0.005),
                &filing,
                TODAY,
            )
            .unwrap();
        assert!(!codes(&sure).contains(&"serial-spelled-otherwise".to_owned()));
    });
}

#[test]
fn refuses_entries_that_name_what_is_not_there_and_keeps_the_state_before() {
    each(|place, _| {
        let mut records = make(place);
        let check = |device| {
            Content::Event(FiledEvent {
                device,
                date: "2026-01-01".into(),
                event: EventKind::Drop,
                text: "table".into(),
            })
        };
        assert!(
            records
                .add(TODAY, None, check(5))
                .unwrap_err()
                .to_string()
                .contains("no device 5")
        );
        assert!(records.entries(1).unwrap().is_empty());
        records
            .add(TODAY, None, Content::Device(device("1")))
            .unwrap();
        let mut wrong = candidate("1", "2026-02-30", 1.0, 0.1, 0.0);
        assert!(
            records
                .file_candidate(&wrong, &Filing::default(), TODAY)
                .is_err()
        );
        wrong.date = "2026-02-01".into();
        let unknown = Filing {
            standard: vec!["nobody".into()],
            ..Default::default()
        };
        assert!(records.file_candidate(&wrong, &unknown, TODAY).is_err());
        assert_eq!(records.entries(1).unwrap().len(), 1);
        assert!(records.check().unwrap().is_whole());
    });
}

#[test]
fn refuses_a_result_that_was_changed() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path());
    let mut records = make(folder.path().join("lab.records").to_str().unwrap());
    let place = campaign.join("result/result.json");
    let text = std::fs::read_to_string(&place).unwrap();
    let report = campaign.join("result/report.html");
    let page = std::fs::read_to_string(&report).unwrap();
    std::fs::write(&report, page.replacen("2026", "2025", 1)).unwrap();
    let refused = records
        .add_result(&campaign.join("result"), &Filing::default(), TODAY)
        .unwrap_err();
    assert!(
        refused.to_string().contains("report.html was changed"),
        "{refused}"
    );
    std::fs::write(&report, page).unwrap();
    std::fs::write(&place, text.replacen("2026-05-01", "2026-05-02", 1)).unwrap();
    let refused = records
        .add_result(&campaign.join("result"), &Filing::default(), TODAY)
        .unwrap_err();
    assert!(refused.to_string().contains("changed"), "{refused}");
    assert!(records.entries(1).unwrap().is_empty());
}

#[test]
fn refuses_to_write_into_a_database_of_another_program() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("other.db");
    {
        let other = rusqlite::Connection::open(&place).unwrap();
        other.execute_batch("CREATE TABLE a (b)").unwrap();
    }
    let before = std::fs::read(&place).unwrap();
    let refused = Records::open_or_make(place.to_str().unwrap()).err();
    assert!(refused.is_some_and(|t| t.to_string().contains("another program")));
    assert!(
        std::fs::read(&place).unwrap() == before,
        "it was written to"
    );
}

#[test]
fn refuses_numbers_that_could_not_be_read_or_reckoned_with() {
    each(|place, _| {
        let mut records = make(place);
        let with = |change: &dyn Fn(&mut FiledQuantity)| {
            let mut c = candidate("1", "2026-01-01", 1.0, 0.01, 0.005);
            change(&mut c.quantities[0]);
            c
        };
        for bad in [
            with(&|q| q.value = f64::INFINITY),
            with(&|q| q.u = Some(-0.1)),
            with(&|q| q.u = Some(1e-200)),
            with(&|q| q.expanded = Some(f64::NAN)),
            with(&|q| q.k = Some(0.0)),
        ] {
            let refused = records.file_candidate(&bad, &Filing::default(), TODAY);
            assert!(refused.is_err_and(|t| t.hint().is_some()), "{bad:?}");
        }
        let check = FiledCheck {
            device: 1,
            date: TODAY.into(),
            quantity: "S".into(),
            unit: "1".into(),
            value: 1e308,
            u: 0.1,
            reference: -1e308,
            u_reference: 0.1,
            en: f64::INFINITY,
        };
        assert!(records.add(TODAY, None, Content::Check(check)).is_err());
        assert!(records.check().unwrap().is_whole());
        assert_eq!(records.devices(false).unwrap().len(), 0);
    });
}
