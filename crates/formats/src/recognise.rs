//! Which format a file is of, by how it begins: one table.

use crate::stream::{Beside, Contents, SeekRead};
use crate::{
    Error, Result, archive, cwa, geneactiv, hdf5, ide, lvm, mat, mcap, npy, tdms, uff, ulog,
    unisens, wav,
};

/// Streams, and the file out of several that they are read from.
pub(crate) type Joint = (Contents, Box<dyn SeekRead>);

/// What makes the streams of a file of known size.
#[derive(Clone, Copy)]
pub(crate) enum Reader {
    /// Of the file alone.
    Alone(fn(&mut dyn SeekRead, u64) -> Result<Contents>),
    /// Of files beside it too; what it gives is read from all of them as one.
    WithOthers(fn(Box<dyn SeekRead>, u64, &mut Beside) -> Result<Joint>),
}

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

    /// The cargo feature without which it is not read.
    pub fn feature(&self) -> Option<&'static str> {
        (self.word == "parquet").then_some("parquet")
    }

    /// Whether recordings are written in it.
    pub fn is_written(&self) -> bool {
        WRITTEN.contains(&self.word) || (self.word == "parquet" && crate::write::PARQUET)
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

#[cfg(feature = "parquet")]
const PARQUET: Option<Reader> = Some(Reader::Alone(crate::parquet::read));
#[cfg(feature = "parquet")]
const PARQUET_LIMITS: &str = "numbers, bits, decimals and times, also in structures, plain or packed by snappy, zstd, gzip; nulls are absent samples, damaged pages too; texts, lists and dates are passed over";
#[cfg(not(feature = "parquet"))]
const PARQUET: Option<Reader> = None;
#[cfg(not(feature = "parquet"))]
const PARQUET_LIMITS: &str = "not in this build: build it from the source with the feature parquet, or export the file as CSV";

/// Every format that is known, in the order in which it is looked for.
pub const FORMATS: &[Format] = &[
    Format {
        word: "wav",
        name: "a WAV file",
        limits: "integers of 8 to 32 bits, floats of 32 and 64; RIFF, RIFX and RF64, cut files; no µ-law, A-law or ADPCM",
        mark: Mark::Test(wav::is_wav),
        reader: Some(Reader::Alone(wav::read)),
    },
    Format {
        word: "tdms",
        name: "a TDMS file of LabVIEW",
        limits: "numbers of every kind, DAQmx, both byte orders; linear, polynomial and table scales; texts and times are passed over",
        mark: Mark::Bytes(b"TDSm"),
        reader: Some(Reader::Alone(tdms::read)),
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
        limits: "data sets 58 and 58b of all types, even and uneven, written as 58b; other data sets are passed over, floats of DEC and IBM refused",
        mark: Mark::Test(uff::is_universal),
        reader: Some(Reader::Alone(uff::read)),
    },
    Format {
        word: "lvm",
        name: "a measurement file of LabVIEW (LVM)",
        limits: "segments and columns of different length and step; texts in the column Comment are passed over",
        mark: Mark::Bytes(b"LabVIEW Measurement"),
        reader: Some(Reader::Alone(lvm::read)),
    },
    Format {
        word: "mat73",
        name: "a MATLAB file of version 7.3 (HDF5)",
        limits: "as HDF5; fields of structures, complex numbers; texts, cells, objects, sparse matrices and arrays of structures are passed over",
        mark: Mark::Test(hdf5::is_mat73),
        reader: Some(Reader::Alone(hdf5::read_mat)),
    },
    Format {
        word: "mat",
        name: "a MATLAB file (level 5)",
        limits: "vectors, matrices and fields of structures, compressed too; what is compressed or complex is held in memory; the longer side is the time; no rate is in it; cells, objects and sparse matrices are passed over",
        mark: Mark::Test(mat::is_level5),
        reader: Some(Reader::Alone(mat::read)),
    },
    Format {
        word: "npy",
        name: "an array of numpy (npy)",
        limits: "one or two dimensions of any number; the longer side is the time; no rate is in it; no records",
        mark: Mark::Bytes(b"\x93NUMPY"),
        reader: Some(Reader::Alone(npy::read)),
    },
    Format {
        word: "cwa",
        name: "a recording of an Axivity logger (CWA)",
        limits: "AX3 and AX6, packed or not, with temperature; damaged blocks are gaps; light, battery and notes are passed over",
        mark: Mark::Bytes(b"MD\xFC\x03"),
        reader: Some(Reader::Alone(cwa::read)),
    },
    Format {
        word: "zip",
        name: "a ZIP archive (.gt3x of ActiGraph, .npz of numpy)",
        limits: "gt3x: activity of both layouts, held in memory, sleep is a gap, damaged records too; npz: arrays as npy; other archives are refused",
        mark: Mark::Bytes(b"PK\x03\x04"),
        reader: Some(Reader::Alone(archive::read)),
    },
    Format {
        word: "mcap",
        name: "an MCAP log of ROS",
        limits: "Imu and other stamped sensors of ROS 1 and 2 (ros1, cdr) by header.stamp, held in memory; zstd and lz4, no summary needed; damaged chunks are gaps; protobuf, JSON and other types are passed over",
        mark: Mark::Bytes(b"\x89MCAP0"),
        reader: Some(Reader::Alone(mcap::read)),
    },
    Format {
        word: "hdf5",
        name: "an HDF5 file",
        limits: "datasets of one or two dimensions of any number, and of records of numbers; the longer side is the time; no rate is in it; deflate, lzf, shuffle, fletcher32, other filters are named; damaged or missing chunks are gaps",
        mark: Mark::Test(hdf5::is_hdf5),
        reader: Some(Reader::Alone(hdf5::read)),
    },
    Format {
        word: "parquet",
        name: "a Parquet file",
        limits: PARQUET_LIMITS,
        mark: Mark::Bytes(b"PAR1"),
        reader: PARQUET,
    },
    Format {
        word: "ulog",
        name: "a ULog of PX4",
        limits: "accelerometers, gyroscopes, magnetometers, barometers and wheels, each instance a stream, held in memory; other topics are passed over",
        mark: Mark::Bytes(b"ULog\x01\x12\x35"),
        reader: Some(Reader::Alone(ulog::read)),
    },
    Format {
        word: "ide",
        name: "a file of an enDAQ recorder (IDE)",
        limits: "channels with their calibration, a temperature-dependent one at the mean temperature; times of the blocks; cut files; no NMEA, no files of old firmware without a description",
        mark: Mark::Test(ide::is_ide),
        reader: Some(Reader::Alone(ide::read)),
    },
    Format {
        word: "geneactiv",
        name: "a recording of a GENEActiv logger",
        limits: "accelerations, light, button and temperature; missing and damaged pages are gaps; battery and notes are passed over",
        mark: Mark::Bytes(b"Device Identity"),
        reader: Some(Reader::Alone(geneactiv::read)),
    },
    Format {
        word: "mat4",
        name: "a MATLAB file (level 4)",
        limits: "vectors and matrices, held in memory; the longer side is the time; no rate is in it",
        mark: Mark::Test(mat::is_level4),
        reader: Some(Reader::Alone(mat::read_level4)),
    },
    Format {
        word: "unisens",
        name: "a Unisens recording (unisens.xml)",
        limits: "the files of signals and values that it names, beside it, binary or text, held in memory as text; events are passed over; what is packed or comes through a pipe has no files beside it",
        mark: Mark::Test(is_unisens),
        reader: Some(Reader::WithOthers(unisens::read)),
    },
    Format {
        word: "xml",
        name: "an XML document",
        limits: "a certificate (DCC) is no recording",
        mark: Mark::Bytes(b"<?xml"),
        reader: None,
    },
];

/// An XML document of which Unisens is the outermost element, whatever its prefix is.
fn is_unisens(head: &[u8]) -> bool {
    let text = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head);
    let begins = text.starts_with(b"<?xml") || text.starts_with(b"<unisens");
    begins && text.windows(24).any(|w| w == b"http://www.unisens.org/u")
}

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
    #[cfg(not(feature = "parquet"))]
    fn refuses_with_the_feature_that_is_missing() {
        let parquet = recognise(b"PAR1\x15\x04").unwrap();
        assert!(!parquet.is_read());
        let refusal = parquet.refusal();
        assert!(refusal.to_string().contains("a Parquet file"));
        let hint = refusal.hint().unwrap();
        assert!(hint.contains("the feature parquet") && hint.contains("CSV"));
    }

    #[test]
    fn known_formats_by_name_and_no_table() {
        let said = |head: &[u8]| recognise(head).map(|f| f.word);
        assert_eq!(said(b"    -1\r\n    58\r\nrecord 1\r\n"), Some("uff"));
        assert_eq!(said(b"TDSm\x0e\0\0\0"), Some("tdms"));
        let space = "<unisens xmlns=\"http://www.unisens.org/unisens2.0\">";
        assert_eq!(said(space.as_bytes()), Some("unisens"));
        let declared = format!("<?xml version=\"1.0\"?>\n{space}");
        assert_eq!(said(declared.as_bytes()), Some("unisens"));
        assert_eq!(said(b"<?xml version=\"1.0\"?>\n<dcc>"), Some("xml"));
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
