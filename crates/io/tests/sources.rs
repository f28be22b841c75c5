//! Every source is read once, from front to end, whatever it is, and gives the same numbers and digest.

use proofmass_io::{
    ErrorKind, LARGEST_DOCUMENT, Layout, LayoutOptions, Recording, RecordingOptions, RowReader,
    Source, inspect_source,
};
use std::fmt::Write as _;
use std::io::{Read, Write as _};
use std::path::Path;

fn table(rows: u32) -> String {
    let mut text = String::from("time_s,acc_x_g\n");
    for i in 0..rows {
        let x = f64::from(i.wrapping_mul(2_654_435_761) >> 12) * 1e-6;
        let _ = writeln!(text, "{:.3},{x:.6}", f64::from(i) * 1e-3);
    }
    text
}

fn options() -> RecordingOptions {
    RecordingOptions {
        columns: vec!["acc_x".into()],
        ..RecordingOptions::default()
    }
}

/// Gives one to seven bytes at a time, as a slow pipe does.
struct Drip(Vec<u8>, usize);

impl Read for Drip {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let n = (1 + self.1 % 7)
            .min(self.0.len() - self.1)
            .min(buffer.len());
        buffer[..n].copy_from_slice(&self.0[self.1..self.1 + n]);
        self.1 += n;
        Ok(n)
    }
}

fn gzip(text: &[u8]) -> Vec<u8> {
    let mut to = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    to.write_all(text).unwrap();
    to.finish().unwrap()
}

fn zstd(text: &[u8]) -> Vec<u8> {
    ruzstd::encoding::compress_to_vec(text, ruzstd::encoding::CompressionLevel::Fastest)
}

#[test]
fn law_every_source_of_the_same_bytes_gives_the_same_recording() {
    // More than the head that is looked at and less than a chunk; then several chunks.
    for rows in [9_000, 200_000] {
        let text = table(rows).into_bytes();
        let whole =
            Recording::from_source(Source::from_bytes("a", text.clone()).unwrap(), &options())
                .unwrap();
        assert_eq!(whole.samples(), rows as usize);
        let drip = Source::new("a", Drip(text.clone(), 0)).unwrap();
        assert_eq!(Recording::from_source(drip, &options()).unwrap(), whole);
        for packed in [gzip(&text), zstd(&text)] {
            let source = Source::from_bytes("a", packed.clone()).unwrap();
            let unpacked = Recording::from_source(source, &options()).unwrap();
            assert_eq!(unpacked.columns, whole.columns);
            assert_eq!(unpacked.time, whole.time);
            // The digest is that of the file as it stands.
            let mut plain = Source::new("a", Drip(packed, 0)).unwrap();
            let mut unpacked_again = Vec::new();
            plain.read_to_end(&mut unpacked_again).unwrap();
            assert!(unpacked_again == text);
            assert_eq!(plain.finish().unwrap().sha256, unpacked.file.sha256);
            assert_ne!(unpacked.file.sha256, whole.file.sha256);
        }
    }
}

#[test]
fn law_packed_files_may_be_joined() {
    let (a, b) = (table(40), table(3).replace("time_s,acc_x_g\n", ""));
    let both = format!("{a}{b}").into_bytes();
    // A frame that is to be skipped, between two others.
    let skipped = [&[0x50, 0x2A, 0x4D, 0x18, 3, 0, 0, 0][..], b"xyz"].concat();
    for packed in [
        [gzip(a.as_bytes()), gzip(b.as_bytes())].concat(),
        [zstd(a.as_bytes()), skipped.clone(), zstd(b.as_bytes())].concat(),
        [skipped, zstd(&both)].concat(),
    ] {
        let source = Source::from_bytes("joined", packed).unwrap();
        let (bytes, _) = source.into_bytes(1 << 20).unwrap();
        assert!(bytes == both);
    }
}

#[test]
fn refuses_packed_files_that_are_cut_or_damaged() {
    let text = table(20_000).into_bytes();
    for packed in [gzip(&text), zstd(&text)] {
        for cut in [5, packed.len() / 2, packed.len() - 1] {
            let source = Source::from_bytes("cut.csv.gz", &packed[..cut]).unwrap();
            let error = Recording::from_source(source, &options()).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Format, "{error}");
            assert!(error.to_string().contains("cut.csv.gz"), "{error}");
        }
    }
    let mut damaged = gzip(&text);
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    let source = Source::from_bytes("damaged", damaged).unwrap();
    assert!(Recording::from_source(source, &options()).is_err());
}

/// A reading that came before must not be taken for the whole.
#[test]
fn refuses_a_reader_that_fails_half_way() {
    struct Broken(std::io::Cursor<Vec<u8>>);
    impl Read for Broken {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            match self.0.read(buffer)? {
                0 => Err(std::io::Error::other("the line went dead")),
                n => Ok(n),
            }
        }
    }
    let broken = Broken(std::io::Cursor::new(table(150_000).into_bytes()));
    let error =
        Recording::from_source(Source::new("radio", broken).unwrap(), &options()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Access);
    assert!(error.to_string().contains("the line went dead"), "{error}");
}

#[cfg(unix)]
#[test]
fn regress_a_named_pipe_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.is_ok_and(|s| s.success()), "mkfifo");
    let text = table(100_000);
    let writer = std::thread::spawn({
        let (pipe, text) = (pipe.clone(), text.clone());
        move || {
            // Once, and a second time only for a reader that comes again.
            let mut to = std::fs::File::options().write(true).open(pipe).unwrap();
            to.write_all(text.as_bytes()).unwrap();
        }
    });
    let inspection = inspect_source(
        Source::open(&pipe).unwrap(),
        &RecordingOptions::default(),
        100,
    )
    .unwrap();
    writer.join().unwrap();
    assert_eq!(inspection.rows, 100_000);
    let whole = Source::from_bytes("a", text).unwrap().finish().unwrap();
    assert_eq!(inspection.sha256, whole.sha256);
    // What would open it twice refuses it.
    let error = Layout::sniff(&pipe).unwrap_err();
    assert!(error.to_string().contains("only once"), "{error}");
}

#[test]
fn refuses_a_document_that_never_ends() {
    let endless = Source::new("/dev/zero", std::io::repeat(b' ')).unwrap();
    let error = endless.into_bytes(LARGEST_DOCUMENT).unwrap_err();
    assert!(error.to_string().contains("64 MiB"), "{error}");
    let source = Source::new("endless line", std::io::repeat(b'1')).unwrap();
    let error = Recording::from_source(source, &options()).unwrap_err();
    assert!(error.to_string().contains("first line"), "{error}");
    assert!(Source::open(Path::new("/")).is_err());
}

#[test]
fn known_a_header_of_thousands_of_columns_is_one() {
    let n = 30_000;
    let names: Vec<String> = (0..n).map(|i| format!("a_channel_{i}")).collect();
    let row: Vec<String> = (0..n).map(|i| i.to_string()).collect();
    let text = format!("{}\n{1}\n{1}\n", names.join(","), row.join(","));
    let mut source = Source::from_bytes("wide", text).unwrap();
    let layout = Layout::of(&mut source, &LayoutOptions::default()).unwrap();
    assert_eq!((layout.columns, layout.first_data_line), (n, 2));
    let mut reader = RowReader::new(source, layout, &[n - 1]).unwrap();
    let block = reader.next_block().unwrap().unwrap();
    assert_eq!(block.column(0), [29_999.0, 29_999.0]);
}

/// 1 000 healthy tables without a final line end, and the same cut inside the last number.
#[test]
fn coverage_a_file_cut_inside_its_last_number_is_told() {
    let warned = |text: &str| -> Option<bool> {
        let source = Source::from_bytes("a", text).unwrap();
        let found = Recording::from_source(source, &options()).unwrap();
        let finding = found
            .findings()
            .iter()
            .find(|f| f.code() == "last-row-open");
        finding.map(|f| f.severity() > proofmass_uncertainty::Severity::Note)
    };
    let complete = table(200);
    assert_eq!(warned(&complete), None);
    assert_eq!(warned(complete.trim_end()), Some(false));
    assert_eq!(warned(&complete[..complete.len() - 3]), Some(true));
    // Free widths: a healthy last row is the shortest of 51 with a probability of at most 1/51.
    let (mut alarms, runs) = (0, 1000);
    let mut state = 88_172_645_463_325_252_u64;
    for _ in 0..runs {
        let mut text = String::from("time_s,acc_x_g\n");
        for i in 0..60 {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let scale = 10_f64.powi((state % 7) as i32);
            let _ = writeln!(
                text,
                "{:.3},{}",
                1.0 + f64::from(i) * 1e-3,
                (state >> 40) as f64 / scale
            );
        }
        alarms += u32::from(warned(text.trim_end()) == Some(true));
    }
    // Binomial, p = 1/51, n = 1000: mean 19.6, and 35 is exceeded with a probability below 1e-3.
    assert!(alarms <= 35, "{alarms} of {runs}");
}
