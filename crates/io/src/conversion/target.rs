//! What a recording is written as, and what such a file can hold.

use proofmass_formats::write::WavForm;

/// What a recording is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TargetForm {
    /// Comma-separated text with headings, the time first.
    Csv,
    /// An array of numpy, a row for each sample, the time first.
    Npy,
    /// WAV.
    Wav(WavForm),
    /// Data sets 58b of a universal file, one for each signal.
    Uff,
    /// Columns of Parquet, the time first.
    Parquet,
}

impl TargetForm {
    /// How a file of it is called in a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::Csv => "a CSV file",
            Self::Npy => "an npy file",
            Self::Wav(_) => "a WAV file",
            Self::Uff => "a UFF 58b file",
            Self::Parquet => "a Parquet file",
        }
    }

    /// Whether every row has its time; else one steady rate holds for all.
    pub fn holds_times(self) -> bool {
        matches!(self, Self::Csv | Self::Npy | Self::Parquet)
    }

    /// Whether a sample may be absent.
    pub fn holds_absent(self) -> bool {
        self.holds_times()
    }

    /// Whether units stand in the file.
    pub fn holds_units(self) -> bool {
        matches!(self, Self::Csv | Self::Uff | Self::Parquet)
    }

    /// Whether names of signals stand in the file.
    pub fn holds_names(self) -> bool {
        self.holds_units()
    }

    /// The number as it is read again; `None` where it cannot be held.
    pub(crate) fn stored(self, number: f64) -> Option<f64> {
        match self {
            Self::Wav(form) => form.stored(number).filter(|v| v.is_finite()),
            _ => Some(number),
        }
    }

    /// Whether every number is held as it is.
    pub(crate) fn is_exact(self) -> bool {
        !matches!(self, Self::Wav(form) if form != WavForm::Float64)
    }
}
