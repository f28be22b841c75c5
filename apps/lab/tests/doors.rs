//! Who may speak to the server, by requests as they go over the wire.

use crate::walk::{campaign, session, wait};
use proofmass_lab::server::Server;
use proofmass_lab::session::Session;
use proofmass_lab::simulated::Switch;
use proofmass_lab::status::Phase;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::Duration;
use tempfile::TempDir;

/// A server on a session, with the port and the token of its link.
struct Served {
    session: Arc<Session>,
    switch: Switch,
    port: u16,
    token: String,
    _folders: [TempDir; 2],
}

/// A session of a campaign with this title.
fn served(title: &str, confirm: bool) -> Served {
    let (plan, out) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    campaign(plan.path());
    let toml = plan.path().join("campaign.toml");
    let text = std::fs::read_to_string(&toml).unwrap();
    let own = "Triaxial accelerometer, simulated campaign on the shaker";
    assert!(text.contains(own));
    std::fs::write(&toml, text.replacen(own, title, 1)).unwrap();
    let (session, switch) = session(plan.path(), &out.path().join("m"), Some(1.0), confirm);
    let session = Arc::new(session);
    let server = Server::bind(0, session.clone(), Some(switch.clone())).unwrap();
    let link = server.link();
    let (host, token) = link
        .strip_prefix("http://")
        .unwrap()
        .split_once("/?token=")
        .unwrap();
    let (port, token) = (
        host.rsplit_once(':').unwrap().1.parse().unwrap(),
        token.to_owned(),
    );
    std::thread::spawn(move || server.serve());
    Served {
        session,
        switch,
        port,
        token,
        _folders: [plan, out],
    }
}

impl Served {
    fn own(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    fn cookie(&self) -> String {
        format!("proofmass-lab-{}={}", self.port, self.token)
    }

    /// The answer to a request with these headers.
    fn ask(&self, line: &str, headers: &[(&str, &str)], body: &str) -> String {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream
            .set_read_timeout(Some(Duration::from_secs(20)))
            .unwrap();
        let mut request = format!(
            "{line} HTTP/1.1\r\nConnection: close\r\nContent-Length: {}\r\n",
            body.len()
        );
        for (name, value) in headers {
            request += &format!("{name}: {value}\r\n");
        }
        if line.starts_with("POST") {
            request += "Content-Type: application/x-www-form-urlencoded\r\n";
        }
        stream
            .write_all(format!("{request}\r\n{body}").as_bytes())
            .unwrap();
        let mut answer = Vec::new();
        let mut piece = [0; 4096];
        // A stream of events has no end: its beginning is enough.
        while let Ok(n) = stream.read(&mut piece) {
            answer.extend_from_slice(&piece[..n]);
            if n == 0 || (line.contains("/events") && answer.windows(5).any(|w| w == b"data:")) {
                break;
            }
        }
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// The same from the page of the server itself.
    fn own_page(&self, line: &str, body: &str) -> String {
        let (host, cookie) = (self.own(), self.cookie());
        let origin = format!("http://{host}");
        self.ask(
            line,
            &[("Host", &host), ("Origin", &origin), ("Cookie", &cookie)],
            body,
        )
    }
}

fn status(answer: &str) -> u16 {
    let word = answer.split(' ').nth(1).unwrap_or_default();
    word.parse().unwrap_or(0)
}

#[test]
fn law_the_link_opens_the_page_once_and_leaves_a_cookie() {
    let served = served("A title", false);
    let host = served.own();
    let answer = served.ask(
        &format!("GET /?token={}", served.token),
        &[("Host", &host)],
        "",
    );
    assert_eq!(status(&answer), 303, "{answer}");
    let cookie = answer
        .lines()
        .find(|l| l.to_lowercase().starts_with("set-cookie:"))
        .unwrap();
    assert!(
        cookie.contains("HttpOnly") && cookie.contains("SameSite=Strict"),
        "{cookie}"
    );
    let page = served.own_page("GET /", "");
    assert_eq!(status(&page), 200);
    assert!(
        page.contains("content-security-policy: default-src 'none'"),
        "{page}"
    );
    for part in ["/lab.css", "/lab.js"] {
        assert_eq!(status(&served.own_page(&format!("GET {part}"), "")), 200);
    }
    let events = served.own_page("GET /events", "");
    assert!(
        events.contains("text/event-stream") && events.contains("\"phase\":\"ready\""),
        "{events}"
    );
    assert_eq!(status(&served.own_page("GET /report", "")), 404);
}

/// Every door, with what a browser of somebody else would send.
#[test]
fn refuses_strangers_at_every_door() {
    let served = served("A title", false);
    let (host, cookie) = (served.own(), served.cookie());
    let origin = format!("http://{host}");
    let rebound = format!("evil.example:{}", served.port);
    let same = format!("http://{rebound}");
    let mut forged = served.cookie();
    let last = if forged.ends_with('0') { "1" } else { "0" };
    forged.replace_range(forged.len() - 1.., last);
    let others = format!("http://127.0.0.1:{}", served.port.wrapping_add(1).max(1024));
    for (what, line, headers, wanted) in [
        ("no cookie", "GET /", vec![("Host", &host)], 403),
        (
            "a forged cookie",
            "GET /",
            vec![("Host", &host), ("Cookie", &forged)],
            403,
        ),
        (
            "a cookie of nothing",
            "GET /events",
            vec![("Host", &host)],
            403,
        ),
        // A name of a stranger that resolves to this machine: Origin and Host agree.
        (
            "a rebound name",
            "POST /start",
            vec![("Host", &rebound), ("Origin", &same), ("Cookie", &cookie)],
            421,
        ),
        (
            "a rebound read",
            "GET /",
            vec![("Host", &rebound), ("Cookie", &cookie)],
            421,
        ),
        (
            "two hosts",
            "GET /",
            vec![("Host", &host), ("Host", &rebound), ("Cookie", &cookie)],
            400,
        ),
        (
            "a cross-site post",
            "POST /start",
            vec![("Host", &host), ("Origin", &same), ("Cookie", &cookie)],
            403,
        ),
        (
            "a post of another port",
            "POST /start",
            vec![("Host", &host), ("Origin", &others), ("Cookie", &cookie)],
            403,
        ),
        (
            "a post without origin",
            "POST /start",
            vec![("Host", &host), ("Cookie", &cookie)],
            403,
        ),
        (
            "a stream of a foreign page",
            "GET /events",
            vec![("Host", &host), ("Origin", &same), ("Cookie", &cookie)],
            403,
        ),
        (
            "a token in a post",
            "POST /start?token=x",
            vec![("Host", &host), ("Origin", &origin)],
            403,
        ),
    ] {
        let headers: Vec<(&str, &str)> = headers.iter().map(|(n, v)| (*n, v.as_str())).collect();
        let answer = served.ask(line, &headers, "");
        let got = status(&answer);
        // Two hosts are refused by the parser or by the door.
        assert!(
            got == wanted || (wanted == 400 && got == 421),
            "{what}: {answer}"
        );
    }
    for wrong in ["", "x", &served.token[1..], &format!("{}0", served.token)] {
        let answer = served.ask(&format!("GET /?token={wrong}"), &[("Host", &host)], "");
        assert_eq!(status(&answer), 403, "token {wrong:?}");
    }
    assert_eq!(served.session.status.lock().phase, Phase::Ready);
    for path in [
        "/../campaign.toml",
        "/..%2fcampaign.toml",
        "/%2e%2e/%2e%2e/etc/passwd",
        "/lab.css/../../x",
        "/report/../runs.csv",
        "//etc/passwd",
    ] {
        let answer = served.own_page(&format!("GET {path}"), "");
        assert!([400, 404].contains(&status(&answer)), "{path}: {answer}");
    }
    let large = format!("page={}", "x".repeat(100_000));
    assert_eq!(status(&served.own_page("POST /start", &large)), 413);
    assert_eq!(status(&served.own_page("POST /fault", "fault=meteor")), 400);
    assert_eq!(status(&served.own_page("GET /start", "")), 405);
}

/// HTML in every text that a campaign brings.
#[test]
fn law_no_field_brings_html_into_the_page() {
    let served = served("<script>alert(1)</script><img src=x onerror='y'>", false);
    served.session.status.lock().reason = Some("</p><script>alert(2)</script>\\\"'".into());
    let page = served.own_page("GET /", "");
    assert_eq!(page.matches("<script").count(), 1, "{page}");
    assert!(page.contains("&lt;script&gt;alert(1)") && !page.contains("<img"));
    // The script of the page puts text into text alone.
    let script = served.own_page("GET /lab.js", "");
    assert!(!script.contains("innerHTML") && !script.contains("document.write"));
}

/// One page holds the bench; any may stop it; its silence brings the drive down.
#[test]
fn law_one_page_holds_the_bench_and_others_may_stop_it() {
    let served = served("A title", true);
    assert_eq!(status(&served.own_page("POST /start", "page=1")), 204);
    wait("the mounting", || {
        served.session.status.lock().phase == Phase::Mounting
    });
    assert_eq!(status(&served.own_page("POST /mounted", "page=2")), 409);
    assert_eq!(status(&served.own_page("POST /beat", "page=1")), 204);
    assert_eq!(status(&served.own_page("POST /mounted", "page=1")), 204);
    wait("a drive", || served.session.shared.driving());
    assert_eq!(
        status(&served.own_page("POST /fault", "fault=cable-off")),
        204
    );
    assert_eq!(
        served.switch.get(),
        proofmass_lab::simulated::Fault::CableOff
    );
    assert_eq!(status(&served.own_page("POST /stop", "page=2")), 204);
    wait("the pause", || {
        served.session.status.lock().phase == Phase::Paused
    });
    assert!(!served.session.shared.driving());
}

#[test]
fn refuses_a_port_in_use() {
    let served = served("A title", false);
    let second = Server::bind(served.port, served.session.clone(), None)
        .err()
        .unwrap();
    assert!(
        second.contains("in use") && second.contains("--port"),
        "{second}"
    );
}
