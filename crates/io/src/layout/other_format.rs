//! Formats of recordings that are no tables of text, known by how they begin.

use crate::{Error, ErrorKind, Result};

/// How a file begins, what it is, and how its numbers become text.
const FORMATS: [(&[u8], &str, &str); 14] = [
    (
        b"TDSm",
        "a TDMS file of LabVIEW",
        "npTDMS or LabVIEW export it",
    ),
    (
        b"RIFF",
        "a WAV file",
        "or calibrate runs on a shaker from it, with `format = \"wav\"` in [recording] of a campaign (`proofmass init --kind shaker-single` writes one)",
    ),
    (
        b"RIFX",
        "a WAV file in big-endian order",
        "convert it to RIFF",
    ),
    (
        b"RF64",
        "a WAV file of more than 4 GiB (RF64)",
        "convert it to parts of RIFF",
    ),
    (
        b"\x89MCAP0",
        "an MCAP log of ROS",
        "`mcap` or rosbag tools export it",
    ),
    (b"\x89HDF", "an HDF5 file", "h5py exports it"),
    (
        b"MATLAB ",
        "a MATLAB file",
        "`writematrix` in MATLAB or scipy.io exports it",
    ),
    (b"PAR1", "a Parquet file", "pyarrow exports it"),
    (
        b"ULog\x01\x12\x35",
        "a ULog of PX4",
        "`ulog2csv` exports it",
    ),
    (
        b"\x1A\x45\xDF\xA3",
        "a file of an enDAQ recorder (IDE)",
        "idelib exports it",
    ),
    (
        b"MD\xFC\x03",
        "a recording of an Axivity logger (CWA)",
        "OmGui or `cwa-convert` export it",
    ),
    (
        b"PK\x03\x04",
        "a ZIP archive, as ActiGraph's .gt3x are",
        "unpack it, or export it with ActiLife or pygt3x",
    ),
    (
        b"Device Identity",
        "a recording of a GENEActiv logger",
        "its own program or GGIRread export it",
    ),
    (
        b"<?xml",
        "an XML document",
        "a certificate (DCC) is no recording",
    ),
];

/// Refuses what is known to be another format; a universal file of modal analysis would pass for a table.
pub(super) fn refuse(head: &[u8]) -> Result<()> {
    let known = FORMATS.iter().find(|(mark, ..)| head.starts_with(mark));
    let (what, how) = match known {
        Some((_, what, how)) => (*what, *how),
        None if universal(head) => (
            "a universal file of modal analysis (UFF)",
            "pyuff or the program that wrote it export it",
        ),
        None => return Ok(()),
    };
    Err(Error::new(
        ErrorKind::Format,
        format!("is {what}, which is not read here"),
    )
    .with_hint(format!(
        "export the recording as delimited text (CSV): {how}"
    )))
}

/// A line of −1 in columns 5 and 6, and the number of a data set in the next.
fn universal(head: &[u8]) -> bool {
    let mut lines = head.split(|b| *b == b'\n').map(<[u8]>::trim_ascii_end);
    let number = |line: &[u8]| {
        let word = line.trim_ascii_start();
        let digits = word.iter().take_while(|b| b.is_ascii_digit()).count();
        (1..=4).contains(&digits) && line.len() > word.len()
    };
    lines.next() == Some(b"    -1") && lines.next().is_some_and(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_other_formats_by_name_and_no_table() {
        let said = |head: &[u8]| refuse(head).map_err(|e| e.to_string()).err();
        let universal = b"    -1\r\n    58\r\nrecord 1\r\n";
        assert!(said(universal).is_some_and(|s| s.contains("UFF")));
        assert!(said(b"TDSm\x0e\0\0\0").is_some_and(|s| s.contains("TDMS")));
        for table in [
            &b"    -1    2    3\n    58    1    2\n"[..],
            b"-1\n58\n",
            b"t,x\n",
            b"",
        ] {
            assert_eq!(said(table), None);
        }
    }
}
