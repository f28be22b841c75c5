//! `proofmass explain`: what a finding means.

use crate::{Failure, Outcome, console};
use proofmass::jobs::findings;

/// Explain a finding by its code, or list all codes.
#[derive(clap::Args)]
pub(crate) struct Explain {
    /// Code of a finding, as results show it: `gaps-in-record`; without it all codes are listed, a line each
    code: Option<String>,
    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
}

impl Explain {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let found = match &self.code {
            Some(code) => vec![findings::explain(code)?],
            None => findings::explanations(),
        };
        if self.json {
            let json = match (&self.code, found.first()) {
                (Some(_), Some(one)) => serde_json::to_vec_pretty(one),
                _ => serde_json::to_vec_pretty(&found),
            };
            let json =
                json.map_err(|e| Failure::new(format!("the catalogue cannot be written: {e}")))?;
            console::print_json(&json)?;
        } else if self.code.is_some() {
            found
                .iter()
                .try_for_each(|one| console::print(&one.to_string()))?;
        } else {
            let width = found.iter().map(|one| one.code.len()).max().unwrap_or(0);
            for one in &found {
                console::print(&format!("{:width$}  {}\n", one.code, one.what))?;
            }
        }
        Ok(Outcome::Done)
    }
}
