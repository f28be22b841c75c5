//! `proofmass explain`: what a finding or an error means, what a word of the field means here.

use crate::{Failure, Outcome, console, glossary};
use proofmass::jobs::{ErrorCode, error_codes, findings};

/// Explain a finding or an error by its code, or a word of the field.
///
/// Without a word, the codes of all findings are listed.
#[derive(clap::Args)]
pub(crate) struct Explain {
    /// Code of a finding, as results show it (`gaps-in-record`), or of an error (`column`), or a word (`bias-instability`, VRW, SRS)
    #[arg(value_name = "WORD")]
    code: Option<String>,
    /// What follows the first word of a term of several
    #[arg(hide = true)]
    more: Vec<String>,
    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
}

/// Says where the findings of a room are those of a command that this build does not have.
fn say_absent(room: &str) -> Result<(), Failure> {
    match room == "records" && !cfg!(feature = "records") {
        true => console::print("(command `records`, not in this build)\n"),
        false => Ok(()),
    }
}

impl Explain {
    pub(crate) fn run(mut self) -> Result<Outcome, Failure> {
        if let Some(word) = &mut self.code {
            *word = [std::slice::from_ref(word), &self.more[..]]
                .concat()
                .join(" ");
        }
        let found = match self.code.as_deref() {
            None => findings::explanations(),
            Some(word) => match findings::explain(word) {
                Ok(one) => vec![one],
                Err(_) => return self.show(word),
            },
        };
        if self.json {
            match (&self.code, found.first()) {
                (Some(_), Some(one)) => print_json(one)?,
                _ => print_json(&found)?,
            }
        } else if self.code.is_some() {
            for one in &found {
                console::print(&one.to_string())?;
                say_absent(one.room)?;
            }
        } else {
            let width = found.iter().map(|one| one.code.len()).max().unwrap_or(0);
            let mut room = "";
            for one in &found {
                if one.room != room {
                    room = one.room;
                    say_absent(room)?;
                }
                console::print(&format!("{:width$}  {}\n", one.code, one.what))?;
            }
        }
        Ok(Outcome::Done)
    }

    /// What is no finding: the error of that code, and rows of the glossary.
    fn show(&self, word: &str) -> Result<Outcome, Failure> {
        let errors: Vec<&ErrorCode> = error_codes().iter().filter(|e| e.code == word).collect();
        let entries = glossary::explain(word);
        if errors.is_empty() && entries.is_empty() {
            return Err(unknown(word));
        }
        if self.json {
            match &errors[..] {
                [] => print_json(&entries)?,
                errors => print_json(&serde_json::json!({"errors": errors, "words": entries}))?,
            }
        } else {
            let errors = errors.iter().map(ToString::to_string);
            let texts: Vec<String> = errors
                .chain(entries.iter().map(ToString::to_string))
                .collect();
            console::print(&texts.join("\n"))?;
        }
        Ok(Outcome::Done)
    }
}

/// Neither a code nor a word; the nearest of both.
fn unknown(word: &str) -> Failure {
    let codes = findings::catalogue();
    let codes = codes.into_iter().map(|(_, kind)| kind.code.to_owned());
    let codes = codes.chain(error_codes().iter().map(|e| e.code.to_owned()));
    let all: Vec<String> = codes
        .chain(glossary::entries().flat_map(|entry| entry.words))
        .collect();
    let near = proofmass::io::spelling::nearest(word, all.iter().map(String::as_str));
    let what =
        format!("`{word}` is neither the code of a finding or an error nor a word of the glossary");
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
