//! `proofmass explain`: what a finding means, what a word of the field means here.

use crate::{Failure, Outcome, console, glossary};
use proofmass::jobs::findings;

/// Explain a finding by its code, or a word of the field.
///
/// Without a word, the codes of all findings are listed.
#[derive(clap::Args)]
pub(crate) struct Explain {
    /// Code of a finding, as results show it (`gaps-in-record`), or a word (`bias-instability`, VRW, SRS)
    #[arg(value_name = "WORD")]
    code: Option<String>,
    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
}

impl Explain {
    pub(crate) fn run(self) -> Result<Outcome, Failure> {
        let words = self.code.as_deref().map(glossary::explain);
        if let Some(entries) = words.filter(|entries| !entries.is_empty())
            && !self.is_a_finding()
        {
            return self.show(&entries);
        }
        let found = match &self.code {
            Some(code) => vec![findings::explain(code).map_err(|_| unknown(code))?],
            None => findings::explanations(),
        };
        if self.json {
            match (&self.code, found.first()) {
                (Some(_), Some(one)) => print_json(one)?,
                _ => print_json(&found)?,
            }
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

    /// Whether the word is the code of a finding.
    fn is_a_finding(&self) -> bool {
        let code = self.code.as_deref();
        code.is_some_and(|code| findings::explain(code).is_ok())
    }

    /// Rows of the glossary.
    fn show(&self, entries: &[glossary::Entry]) -> Result<Outcome, Failure> {
        if self.json {
            print_json(&entries)?;
        } else {
            let texts: Vec<String> = entries.iter().map(ToString::to_string).collect();
            console::print(&texts.join("\n"))?;
        }
        Ok(Outcome::Done)
    }
}

/// Neither a code nor a word; the nearest of both.
fn unknown(word: &str) -> Failure {
    let codes = findings::catalogue();
    let codes = codes.into_iter().map(|(_, kind)| kind.code.to_owned());
    let all: Vec<String> = codes
        .chain(glossary::entries().flat_map(|entry| entry.words))
        .collect();
    let near = proofmass::io::spelling::nearest(word, all.iter().map(String::as_str));
    let what = format!("`{word}` is neither the code of a finding nor a word of the glossary");
    Failure::new(what).hint(match near {
        Some(near) => format!("did you mean `{near}`?"),
        None => "`proofmass explain` without a word lists all codes".to_owned(),
    })
}

fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let json = serde_json::to_vec_pretty(value);
    let json = json.map_err(|e| Failure::new(format!("the text cannot be written: {e}")))?;
    console::print_json(&json)
}
