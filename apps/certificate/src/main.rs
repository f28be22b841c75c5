//! `proofmass-certificate`: typesets a sheet, a certificate as data, as PDF/A-3a.

mod document;
mod drawing;
mod error;
mod fonts;
mod mathematics;
mod output;
mod overflow;
mod place;
mod sheet;
mod world;

use std::ffi::OsString;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use document::Document;
use error::{Error, Result};
use sheet::Sheet;

const USAGE: &str = "\
Typesets a certificate, as `proofmass certificate` writes it, as PDF/A-3a with its attachments.

Usage: proofmass-certificate SHEET.json -o FILE.pdf [--png FOLDER]

  SHEET.json     the sheet; - reads it from standard input
  -o FILE.pdf    where the certificate goes
  --png FOLDER   also each page as a picture: page-1.png and so on
  -h, --help     this text
  -V, --version  the version

The exit code is 0, or 2 when something is wrong; nothing is written then.";

#[derive(Default)]
struct Arguments {
    sheet: Option<PathBuf>,
    pdf: Option<PathBuf>,
    png: Option<PathBuf>,
}

impl Arguments {
    fn read(words: impl IntoIterator<Item = OsString>) -> Result<Self> {
        let mut read = Self::default();
        let mut words = words.into_iter();
        while let Some(word) = words.next() {
            let place = match word.to_str() {
                Some("-o") => &mut read.pdf,
                Some("--png") => &mut read.png,
                Some(option) if option.starts_with('-') && option != "-" => {
                    return Err(misused(&format!("the option {option} is not known")));
                }
                _ => &mut read.sheet,
            };
            let value = match word.to_str() {
                Some(option @ ("-o" | "--png")) => words
                    .next()
                    .ok_or_else(|| misused(&format!("{option} needs a place")))?,
                _ => word,
            };
            if place.replace(value.into()).is_some() {
                return Err(misused("a sheet, -o or --png is given twice"));
            }
        }
        Ok(read)
    }
}

fn misused(what: &str) -> Error {
    Error::new(
        what,
        "proofmass-certificate SHEET.json -o FILE.pdf [--png FOLDER]",
    )
}

fn main() -> ExitCode {
    let words: Vec<OsString> = std::env::args_os().skip(1).collect();
    let asks = |names: [&str; 2]| {
        words
            .iter()
            .any(|word| names.iter().any(|name| word == name))
    };
    if asks(["-h", "--help"]) {
        println!("{USAGE}");
        return ExitCode::SUCCESS;
    }
    if asks(["-V", "--version"]) {
        println!("proofmass-certificate {}", env!("CARGO_PKG_VERSION"));
        return ExitCode::SUCCESS;
    }
    match Arguments::read(words).and_then(|arguments| run(&arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let path = arguments
        .sheet
        .as_deref()
        .ok_or_else(|| misused("the sheet is missing"))?;
    let pdf = arguments
        .pdf
        .clone()
        .ok_or_else(|| misused("-o FILE.pdf is missing"))?;
    let name = if path == Path::new("-") {
        "standard input".to_owned()
    } else {
        path.display().to_string()
    };
    let json = read(path).map_err(|e| {
        Error::new(
            format!("the sheet cannot be read: {e}"),
            "name the file that `proofmass certificate` wrote",
        )
        .at(&name)
    })?;
    let document = Sheet::read(&json)
        .and_then(|sheet| Document::new(&sheet))
        .map_err(|e| e.at(&name))?;
    let mut files = vec![(pdf, document.pdf().map_err(|e| e.at(&name))?)];
    if let Some(folder) = &arguments.png {
        files.extend(output::pictures(folder, document.pictures()?)?);
    }
    output::write_all(&files)
}

fn read(path: &Path) -> io::Result<Vec<u8>> {
    if path == Path::new("-") {
        let mut bytes = Vec::new();
        io::stdin().lock().read_to_end(&mut bytes)?;
        Ok(bytes)
    } else {
        std::fs::read(path)
    }
}
