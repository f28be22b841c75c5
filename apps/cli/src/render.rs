//! `proofmass render`: report and tables again from a result.json.

use crate::delivery::Delivery;
use crate::{Failure, Outcome, console};
use proofmass::io::{LARGEST_DOCUMENT, Source, unlisted};
use proofmass::jobs::StoredResult;
use std::path::PathBuf;

/// Show a result, or write its report and tables, from result.json alone.
///
/// The recordings are not needed: quantities, plots and findings stand in the result. The same version writes the same files,
/// byte by byte.
#[derive(clap::Args)]
pub(crate) struct Render {
    /// result.json, or the folder that holds it
    result: PathBuf,
    #[command(flatten)]
    delivery: Delivery,
}

impl Render {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let path = StoredResult::place(&self.result);
        let (bytes, input) = Source::open(&path)?.into_bytes(LARGEST_DOCUMENT)?;
        match (&input.doubt, &self.delivery.output) {
            (Some(doubt), Some(_)) => return Err(Failure::new(doubt).hint(
                "what is written from it would look like a result that nobody changed: look at it without -o, or evaluate it again",
            )),
            (Some(doubt), None) => console::note(format!("warning: {doubt}")),
            (None, _) => {}
        }
        let unlisted = unlisted(&path, &input);
        let nobody = unlisted.as_ref().map(|source| {
            format!(
                "no manifest.json beside {} says that it is as it was written",
                source.path
            )
        });
        if let (true, Some(nobody)) = (self.delivery.signs(), &nobody) {
            return Err(Failure::new(nobody.clone())
                .hint("write it without --sign, or sign the result where it is computed"));
        }
        let result = StoredResult::from_json(&bytes)
            .map_err(|trouble| Failure::from(trouble).detail(path.display().to_string()))?;
        // What stands beside it goes along.
        let result = match self.delivery.output {
            Some(_) => result.with_files_beside(|name| {
                Ok(Source::open(path.with_file_name(name))?
                    .into_bytes(LARGEST_DOCUMENT)?
                    .0)
            })?,
            None => result,
        };
        let mut folder = self.delivery.begin(result.kind(), &[&path])?;
        if let (Some(source), Some(nobody), Some(folder)) = (unlisted, nobody, &mut folder) {
            console::note(format!("warning: {nobody}; the new one says so"));
            folder.rendered_from(source);
        }
        self.delivery.deliver(folder, &result)
    }
}
