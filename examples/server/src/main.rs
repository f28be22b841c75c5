//! The handler of a calibration server: files of a campaign come in a request, result and report go out.
//!
//!     cargo run --release -p proofmass-example-server -- examples/hand-held
//!
//! reads a folder as if it had arrived over the network (or a file with a request as JSON) and answers as a server would. The handler knows nothing of
//! the file system: any web framework can call it with the parts of a multipart request.

use proofmass::jobs::campaign::Campaign;
use proofmass::jobs::{AnyData, AnyJob, Memory, Record, Result, TroubleKind, Watch};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a web framework turns into a response.
struct Response {
    status: u16,
    files: Vec<(String, Vec<u8>)>,
    message: String,
}

/// Stops a job whose client went away.
struct Client {
    gone: AtomicBool,
}

impl Watch for Client {
    fn progress(&self, _stage: &'static str, _done: u64, _of: u64) -> ControlFlow<()> {
        if self.gone.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// Evaluates the campaign among `parts`.
fn handle(parts: Vec<(String, Vec<u8>)>, date: &str, client: &Client) -> Response {
    respond(evaluate(parts, date, client))
}

fn respond(answered: Result<Vec<(String, Vec<u8>)>>) -> Response {
    match answered {
        Ok(files) => Response {
            status: 200,
            files,
            message: "answered".to_owned(),
        },
        Err(trouble) => Response {
            status: match trouble.kind() {
                TroubleKind::Request => 400,
                TroubleKind::Cancelled => 499,
                TroubleKind::Data => 422,
                _ => 500,
            },
            files: Vec::new(),
            message: match trouble.hint() {
                Some(hint) => format!("{trouble}; {hint}"),
                None => trouble.to_string(),
            },
        },
    }
}

fn evaluate(
    parts: Vec<(String, Vec<u8>)>,
    date: &str,
    client: &Client,
) -> Result<Vec<(String, Vec<u8>)>> {
    let store = parts
        .into_iter()
        .fold(Memory::new(), |store, (name, bytes)| {
            store.file(name, bytes)
        });
    let campaign = Campaign::read(Arc::new(store), "campaign.toml")?;
    campaign.evaluate(Some(date.to_owned()), client)?.files()
}

/// Evaluates a request as JSON that needs no data: a model of measurement, a plan, a wedge by its dimensions.
fn handle_request(body: &[u8], client: &Client) -> Response {
    let answered = AnyJob::from_json(body).and_then(|job| {
        let result = job.evaluate(&AnyData::None, Record::default(), client)?;
        Ok(vec![("result.json".to_owned(), result.to_json()?)])
    });
    respond(answered)
}

fn main() -> std::io::Result<()> {
    let folder = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "examples/hand-held".to_owned());
    let client = Client {
        gone: AtomicBool::new(false),
    };
    let response = if std::path::Path::new(&folder).is_file() {
        handle_request(&std::fs::read(folder)?, &client)
    } else {
        handle(parts_of(&folder)?, "2026-01-01", &client)
    };
    println!("{} {}", response.status, response.message);
    for (name, bytes) in &response.files {
        println!("  {name}: {} bytes", bytes.len());
    }
    Ok(())
}

/// The files of a folder, as the parts of a multipart request.
fn parts_of(folder: &str) -> std::io::Result<Vec<(String, Vec<u8>)>> {
    let mut parts = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if let (true, Some(name)) = (path.is_file(), path.file_name()) {
            parts.push((name.to_string_lossy().into_owned(), std::fs::read(&path)?));
        }
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proofmass::jobs::uncertainty::UncertaintyJob;

    #[test]
    fn known_answer_to_a_request_as_json() {
        let client = Client {
            gone: AtomicBool::new(false),
        };
        let text = std::fs::read_to_string(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../uncertainty/mass.toml"
        ));
        let job = UncertaintyJob {
            model: proofmass::documents::read_model(&text.unwrap()).unwrap(),
            ..UncertaintyJob::default()
        };
        let body = AnyJob::from(job).to_json().unwrap();
        let response = handle_request(body.as_bytes(), &client);
        assert_eq!(response.status, 200, "{}", response.message);
        assert_eq!(response.files[0].0, "result.json");
        let refused = handle_request(b"{\"job\": \"astrology\"}", &client);
        assert_eq!(refused.status, 400);
        assert!(
            refused.message.contains("multi-position"),
            "{}",
            refused.message
        );
    }

    fn example() -> Vec<(String, Vec<u8>)> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../hand-held/");
        ["campaign.toml", "recording.csv"]
            .map(|name| {
                (
                    name.to_owned(),
                    std::fs::read(format!("{folder}{name}")).unwrap(),
                )
            })
            .to_vec()
    }

    #[test]
    fn known_answers_of_the_handler() {
        let client = Client {
            gone: AtomicBool::new(false),
        };
        let response = handle(example(), "2026-01-01", &client);
        assert_eq!(response.status, 200, "{}", response.message);
        assert!(response.files.iter().any(|(name, _)| name == "report.html"));
        let mut parts = example();
        parts.pop();
        let refused = handle(parts, "2026-01-01", &client);
        assert_eq!(refused.status, 422, "{}", refused.message);
        assert!(refused.message.contains("recording.csv"));
        client.gone.store(true, Ordering::Relaxed);
        assert_eq!(handle(example(), "2026-01-01", &client).status, 499);
    }
}
