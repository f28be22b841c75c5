//! The page, as it stands before its script changes it; it works without.

use crate::session::Session;
use crate::simulated::Fault;
use crate::status::Phase;
use crate::view::View;
use proofmass::report::escape;

/// Its style.
pub const STYLE: &str = include_str!("page/lab.css");
/// Its script.
pub const SCRIPT: &str = include_str!("page/lab.js");

fn head(title: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{}</title>\n<link rel=\"stylesheet\" href=\"/lab.css\">\n",
        escape(title)
    )
}

/// A page that says one thing.
pub fn notice(title: &str, text: &str) -> String {
    format!(
        "{}</head>\n<body>\n<main class=\"notice\">\n<h1>{}</h1>\n<p>{}</p>\n</main>\n</body>\n</html>\n",
        head(title),
        escape(title),
        escape(text)
    )
}

/// What the walk does, in words.
pub fn phase(view: &View) -> &'static str {
    match (view.status.phase, view.doing) {
        (Phase::Ready, _) => "Ready",
        (Phase::Mounting, _) => "Mount the device",
        (Phase::Measuring, "recording") => "Recording",
        (Phase::Measuring, "fading") => "Fading",
        (Phase::Measuring, _) => "Levelling",
        (Phase::Paused, _) => "Paused",
        (Phase::Finished, _) => "Finished",
    }
}

/// The page of the bench.
pub fn front(session: &Session, view: &View, number: usize, simulated: bool) -> String {
    let faults: String = Fault::ALL
        .iter()
        .map(|(_, word)| format!("<option value=\"{word}\">{word}</option>"))
        .collect();
    let faults = match simulated {
        true => format!(
            "<form class=\"faults\" method=\"post\" action=\"/fault\"><label>Fault of the simulated bench \
             <select name=\"fault\">{faults}</select></label> <button type=\"submit\">Switch on</button></form>"
        ),
        false => String::new(),
    };
    let mounting = view.status.phase == Phase::Mounting;
    let button = |action: &str, class: &str, text: &str, key: &str| {
        let hidden = if action == "mounted" && !mounting {
            " hidden"
        } else {
            ""
        };
        format!(
            "<form method=\"post\" action=\"/{action}\"{hidden}><input type=\"hidden\" name=\"page\" value=\"{number}\">\
             <button id=\"{action}\" class=\"{class}\" type=\"submit\" aria-keyshortcuts=\"{key}\">{text} <kbd>{key}</kbd></button></form>"
        )
    };
    format!(
        r#"{head}<script src="/lab.js" defer></script>
</head>
<body data-page="{number}" data-view="{data}">
<header>
<h1>{title}</h1>
<p>{device} · recorded into <code>{folder}</code></p>
</header>
<p id="alarm" role="alert"{no_alarm}>{alarm}</p>
<main>
<section class="state" aria-label="State">
<p id="phase" class="{phase_class}" role="status">{phase}</p>
<p id="reason">{reason}</p>
<div class="buttons">{start}{mounted}{stop}</div>
<p class="numbers"><span><b id="acceleration">–</b> <small>m/s² of <i id="target">–</i></small></span>
<span><b id="frequency">–</b> <small>Hz</small></span>
<span><b id="drive">–</b> <small>V drive</small></span></p>
<p id="mounting" class="mounting"></p>
<p><progress id="progress" max="{total}" value="{done}" aria-label="Runs recorded"></progress> <span id="count">{done} of {total} runs</span></p>
</section>
<section class="signals" aria-label="Signals">
<div class="plot"><canvas id="curves" role="img" aria-label="The last samples of every channel"></canvas></div>
</section>
<section aria-label="Result">
<h2>Result so far</h2>
<p id="note">{note}</p>
<table><thead><tr><th>quantity</th><th>value</th><th>U relative</th></tr></thead><tbody id="result"></tbody></table>
<p><a href="/report" target="_blank" rel="noopener">Report</a></p>
</section>
<section aria-label="Last runs">
<h2>Last runs</h2>
<table><thead><tr><th>run</th><th>Hz</th><th>m/s²</th><th>off target</th><th>settled in</th></tr></thead><tbody id="runs"></tbody></table>
{faults}
</section>
</main>
</body>
</html>
"#,
        // The first picture needs no second request.
        data = escape(&serde_json::to_string(view).unwrap_or_default()),
        head = head(&session.title),
        title = escape(&session.title),
        device = escape(&session.identity.line()),
        folder = escape(&session.folder.display().to_string()),
        no_alarm = if view.alarm.is_none() { " hidden" } else { "" },
        alarm = escape(view.alarm.unwrap_or_default()),
        phase_class = phase(view)
            .split(' ')
            .next()
            .unwrap_or_default()
            .to_lowercase(),
        phase = phase(view),
        reason = escape(view.status.reason.as_deref().unwrap_or_default()),
        note = escape(view.result_note.as_deref().unwrap_or_default()),
        start = button("start", "go", "Start", "S"),
        mounted = button("mounted", "go", "Mounted", "M"),
        stop = button("stop", "halt", "Stop", "Esc"),
        total = view.status.total,
        done = view.status.done,
    )
}

#[cfg(test)]
mod tests {
    #[test]
    fn law_no_text_leaves_its_place() {
        let nasty = "<script>alert('1')</script>\" onload=\"x\" & ";
        let safe = super::escape(nasty);
        assert!(!safe.contains(['<', '>', '"', '\'']));
        assert!(super::notice(nasty, nasty).matches("<script").count() == 0);
    }
}
