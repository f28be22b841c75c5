//! What every simulation of the shaker bench is told.

use std::path::PathBuf;

/// Options of every simulation of the shaker bench.
#[derive(clap::Args)]
pub(super) struct BenchArguments {
    /// Folder for the campaign
    #[arg(short, long, value_name = "FOLDER")]
    pub(super) output: PathBuf,
    /// The same seed makes the same campaign on every machine
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
    /// Drive frequencies, Hz
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "5,10,20,40,80,160,315,630,1000"
    )]
    pub(super) frequencies: Vec<f64>,
}
