//! Which format a file is of, by how it begins: one table.

use crate::stream::{Contents, SeekRead};
use crate::{Error, Result, archive, cwa, lvm, mat, npy, tdms, uff, wav};

/// What makes the streams of a file of known size.
pub(crate) type Reader = fn(&mut dyn SeekRead, u64) -> Result<Contents>;

/// A format of recordings.
#[non_exhaustive]
pub struct Format {
    /// Short word for it.
    pub word: &'static str,
    /// What a file of it is called, with its article.
    pub name: &'static str,
    /// What is read of it and what is not; where nothing is, how its numbers become something that is.
    pub limits: &'static str,
    pub(crate) mark: Mark,
    pub(crate) reader: Option<Reader>,
}

impl Format {
    /// Whether it is read here.
    pub fn is_read(&self) -> bool {
        self.reader.is_some()
    }

    /// Whether recordings are written in it.
    pub fn is_written(&self) -> bool {
        WRITTEN.contains(&self.word)
    }

    /// Why a file of it is not read, and what to do about it.
    pub fn refusal(&self) -> Error {
        Error::new(format!("is {}, which is not read here", self.name)).with_hint(format!(
            "{}; `proofmass formats` lists what is read",
            self.limits
        ))
    }
}

/// Words of the formats whose heads and numbers [`write`](crate::write) makes.
const WRITTEN: [&str; 3] = ["wav", "npy", "uff"];

/// How a file begins.
pub(crate) enum Mark {
    /// With these bytes.
    Bytes(&'static [u8]),
    /// As this says.
    Test(fn(&[u8]) -> bool),
}

/// Every format that is known, in the order in which it is looked for.
pub const FORMATS: &[Format] = &[
    Format {
        word: "wav",
        name: "a WAV file",
        limits: "integers of 8 to 32 bits, floats of 32 and 64; RIFF, RIFX and RF64, cut files; no µ-law, A-law or ADPCM",
        mark: Mark::Test(wav::is_wav),
        reader: Some(wav::read),
    },
    Format {
        word: "tdms",
        name: "a TDMS file of LabVIEW",
        limits: "numbers of every kind, DAQmx, both byte orders; linear, polynomial and table scales; texts and times are passed over",
        mark: Mark::Bytes(b"TDSm"),
        reader: Some(tdms::read),
    },
    Format {
        word: "tdms_index",
        name: "an index of a TDMS file, without samples",
        limits: "name the .tdms file beside it",
        mark: Mark::Bytes(b"TDSh"),
        reader: None,
    },
    Format {
        word: "uff",
        name: "a universal file of modal analysis (UFF)",
        limits: "data sets 58 and 58b of all types, even and uneven; other data sets are passed over, floats of DEC and IBM refused",
        mark: Mark::Test(uff::is_universal),
        reader: Some(uff::read),
    },
    Format {
        word: "lvm",
        name: "a measurement file of LabVIEW (LVM)",
        limits: "segments and columns of different length and step; texts in the column Comment are passed over",
        mark: Mark::Bytes(b"LabVIEW Measurement"),
        reader: Some(lvm::read),
    },
    Format {
        word: "mat73",
        name: "a MATLAB file of version 7.3 (HDF5)",
        limits: "save it with `save -v7`, or export it as delimited text (CSV)",
        mark: Mark::Bytes(b"MATLAB 7.3"),
        reader: None,
    },
    Format {
        word: "mat",
        name: "a MATLAB file (level 5)",
        limits: "vectors, matrices and fields of structures, compressed too, held in memory; the longer side is the time; no rate is in it; cells, objects and sparse matrices are passed over",
        mark: Mark::Test(mat::is_level5),
        reader: Some(mat::read),
    },
    Format {
        word: "npy",
        name: "an array of numpy (npy)",
        limits: "one or two dimensions of any number, held in memory; the longer side is the time; no rate is in it; no records",
        mark: Mark::Bytes(b"\x93NUMPY"),
        reader: Some(npy::read),
    },
    Format {
        word: "cwa",
        name: "a recording of an Axivity logger (CWA)",
        limits: "AX3 and AX6, packed or not, with temperature; damaged blocks are gaps; light, battery and notes are passed over",
        mark: Mark::Bytes(b"MD\xFC\x03"),
        reader: Some(cwa::read),
    },
    Format {
        word: "zip",
        name: "a ZIP archive (.gt3x of ActiGraph, .npz of numpy)",
        limits: "gt3x: activity of both layouts, held in memory, sleep is a gap, damaged records too; npz: arrays as npy; other archives are refused",
        mark: Mark::Bytes(b"PK\x03\x04"),
        reader: Some(archive::read),
    },
    Format {
        word: "mcap",
        name: "an MCAP log of ROS",
        limits: "export it as delimited text (CSV): `mcap` or rosbag tools do",
        mark: Mark::Bytes(b"\x89MCAP0"),
        reader: None,
    },
    Format {
        word: "hdf5",
        name: "an HDF5 file",
        limits: "export it as delimited text (CSV): h5py does",
        mark: Mark::Bytes(b"\x89HDF"),
        reader: None,
    },
    Format {
        word: "parquet",
        name: "a Parquet file",
        limits: "export it as delimited text (CSV): pyarrow does",
        mark: Mark::Bytes(b"PAR1"),
        reader: None,
    },
    Format {
        word: "ulog",
        name: "a ULog of PX4",
        limits: "export it as delimited text (CSV): `ulog2csv` does",
        mark: Mark::Bytes(b"ULog\x01\x12\x35"),
        reader: None,
    },
    Format {
        word: "ide",
        name: "a file of an enDAQ recorder (IDE)",
        limits: "export it as delimited text (CSV): idelib does",
        mark: Mark::Bytes(b"\x1A\x45\xDF\xA3"),
        reader: None,
    },
    Format {
        word: "geneactiv",
        name: "a recording of a GENEActiv logger",
        limits: "export it as delimited text (CSV): its own program or GGIRread do",
        mark: Mark::Bytes(b"Device Identity"),
        reader: None,
    },
    Format {
        word: "mat4",
        name: "a MATLAB file (level 4)",
        limits: "vectors and matrices, held in memory; the longer side is the time; no rate is in it",
        mark: Mark::Test(mat::is_level4),
        reader: Some(mat::read_level4),
    },
    Format {
        word: "xml",
        name: "an XML document",
        limits: "a certificate (DCC) is no recording",
        mark: Mark::Bytes(b"<?xml"),
        reader: None,
    },
];

/// The format of a file by its first bytes, of which [`HEAD`](crate::HEAD) suffice; `None` where it may be a text.
pub fn recognise(head: &[u8]) -> Option<&'static Format> {
    FORMATS.iter().find(|format| match format.mark {
        Mark::Bytes(bytes) => head.starts_with(bytes),
        Mark::Test(test) => test(head),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_formats_by_name_and_no_table() {
        let said = |head: &[u8]| recognise(head).map(|f| f.word);
        assert_eq!(said(b"    -1\r\n    58\r\nrecord 1\r\n"), Some("uff"));
        assert_eq!(said(b"TDSm\x0e\0\0\0"), Some("tdms"));
        for table in [
            &b"    -1    2    3\n    58    1    2\n"[..],
            b"-1\n58\n",
            b"t,x\n",
            b"RIFF,a\n",
            b"",
        ] {
            assert_eq!(said(table), None);
        }
    }
}
