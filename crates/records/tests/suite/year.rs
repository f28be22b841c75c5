//! A year of a small laboratory: 40 devices, 3 standards, one of them wrong for two months.

use crate::places::{each, make};
use crate::recorded::*;
use proofmass_records::*;
use proofmass_static::static_test::RecalibrationRule;

#[test]
fn law_a_year_of_a_small_laboratory_ends_in_a_complete_recall() {
    each(|place, _| {
        let mut records = make(place);
        let standards: Vec<i64> = ["R1", "R2", "R3"]
            .map(|r| standard(&mut records, r))
            .to_vec();
        for s in &standards {
            certificate(
                &mut records,
                *s,
                &format!("C{s}"),
                ["2025-01-01", "2026-12-31"],
                0.0025,
            );
        }
        let rule = FiledRule {
            device: None,
            rule: RecalibrationRule::Fixed { months: 6.0 },
            tolerances: Vec::new(),
        };
        records.add(TODAY, None, Content::Rule(rule)).unwrap();
        let first = day_of("2025-01-06").unwrap();
        // R2 was dropped on 1 August and is 2 % off until a check on 1 October finds it.
        let (dropped, checked) = (day_of("2025-08-01").unwrap(), day_of("2025-10-01").unwrap());
        let mut wrong = Vec::new();
        for week in 0..50 {
            let day = first + 7 * week;
            for k in 0..2 {
                let device = (2 * week + k) % 40;
                let reference = (week + k) as usize % 3;
                let is_wrong = reference == 1 && (dropped..checked).contains(&day);
                let value = 0.01 * if is_wrong { 1.02 } else { 1.0 } * (1.0 + 1e-5 * week as f64);
                let c = candidate(&format!("D{device}"), &date_of(day), value, 3e-5, 2.5e-5);
                let filed = file(&mut records, &c, Some(["R1", "R2", "R3"][reference]));
                if is_wrong {
                    wrong.push(filed.number);
                }
            }
            if week % 10 == 0 {
                check(
                    &mut records,
                    standards[1],
                    day,
                    day < dropped || day >= checked,
                );
            }
        }
        check(&mut records, standards[1], checked, false);
        let recall = records
            .recall(standards[1], checked, None, Some(0.02))
            .unwrap();
        let listed: Vec<i64> = recall.results.iter().map(|r| r.result).collect();
        assert!(
            wrong.len() >= 5 && wrong.iter().all(|n| listed.contains(n)),
            "{wrong:?} {listed:?}"
        );
        // Everything since the last good check, and nothing of other standards.
        assert!(
            recall
                .results
                .iter()
                .all(|r| r.day >= recall.days[0] && r.day <= checked)
        );
        assert!(
            recall
                .results
                .iter()
                .all(|r| (r.effects[0].effect / -2e-4 - 1.0).abs() < 0.01)
        );
        let page = page::recall(&recall);
        assert!(
            proofmass_report::html::render(&page)
                .unwrap()
                .contains("largest effect")
        );
        assert!(
            !records
                .due(day_of("2026-06-01").unwrap())
                .unwrap()
                .is_empty()
        );
        assert!(records.check().unwrap().is_whole());
    });
}

fn check(records: &mut Records, device: i64, day: i64, good: bool) {
    let value = if good { 1.0 } else { 1.02 };
    let what = ("S.modulus".into(), "1".into());
    let check =
        FiledCheck::measured(device, date_of(day), what, [value, 0.002], [1.0, 0.002]).unwrap();
    records.add(TODAY, None, Content::Check(check)).unwrap();
}
