//! Text at random: nothing panics, and what is written again is valid CSV.

use proofmass_io::{Layout, Rewriter, RowReader, inspect};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn law_any_text_is_read_or_refused_and_written_again_as_csv(
        text in "([0-9.,;+eE\"#% \tna°-]{0,12}[,; \t\n\r]){0,40}",
    ) {
        let folder = tempfile::tempdir().unwrap();
        let (input, output) = (folder.path().join("in.txt"), folder.path().join("out.csv"));
        std::fs::write(&input, &text).unwrap();
        let _ = inspect(&input);
        if let Ok(layout) = Layout::sniff(&input) {
            let columns = layout.columns;
            let mut reader = RowReader::open(&input, layout.clone(), &[0]).unwrap().keep_text();
            let new = [(0, "new".to_string())];
            let mut writer = Rewriter::create(&output, &layout, &new, &[&input]).unwrap();
            let mut rows = 0;
            let read = loop {
                match reader.next_block() {
                    Ok(Some(block)) => {
                        rows += block.rows();
                        writer.block(&block, &[block.column(0)]).unwrap();
                    }
                    Ok(None) => break true,
                    Err(_) => break false,
                }
            };
            if read {
                writer.commit().unwrap();
                let mut csv = csv::Reader::from_path(&output).unwrap();
                let records: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
                prop_assert_eq!(records.len(), rows);
                prop_assert!(records.iter().all(|r| r.len() == columns));
            }
        }
    }
}
