//! The page and what it asks for, over HTTP on the loopback address.

use crate::doors::{Doors, Refused};
use crate::page;
use crate::session::Session;
use crate::simulated::{Fault, Switch};
use crate::view;
use crate::walk::Click;
use axum::Router;
use axum::extract::{DefaultBodyLimit, Form, Query, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::sse::{Event, Sse};
use axum::response::{Html, IntoResponse, Redirect, Response};
use axum::routing::{get, post};
use futures_util::stream::{Stream, unfold};
use serde::Deserialize;
use std::convert::Infallible;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How often the page is told.
const TOLD: Duration = Duration::from_millis(100);
/// Pages that may look on at once.
const PAGES: usize = 16;
/// Largest request, bytes.
const LARGEST: usize = 4096;
/// What a page may load: its own style and script, nothing of others.
const OWN: &str = "default-src 'none'; style-src 'self'; script-src 'self'; connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'";
/// A report is one file with its script inside; it gets no rights of this server.
const REPORT: &str = "sandbox allow-scripts; default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

/// What every request sees.
pub struct Desk {
    session: Arc<Session>,
    doors: Doors,
    switch: Option<Switch>,
    /// Page that started the walk: its signs of life count.
    holder: Mutex<Option<String>>,
    pages: AtomicUsize,
    numbers: AtomicUsize,
}

/// A server that listens.
pub struct Server {
    listener: TcpListener,
    desk: Arc<Desk>,
}

impl Server {
    /// Listens on a port of the loopback address; zero is any that is free.
    ///
    /// # Errors
    /// The port is in use, with what to do.
    pub fn bind(port: u16, session: Arc<Session>, switch: Option<Switch>) -> Result<Self, String> {
        let address = SocketAddr::from((Ipv4Addr::LOCALHOST, port));
        let listener = TcpListener::bind(address).map_err(|e| match e.kind() {
            std::io::ErrorKind::AddrInUse => format!(
                "port {port} is in use, perhaps by another live bench: end that one, or choose another with --port, 0 for any that is free"
            ),
            _ => format!("port {port} cannot be listened on: {e}"),
        })?;
        let ready = listener
            .set_nonblocking(true)
            .and_then(|()| listener.local_addr());
        let own = ready.map_err(|e| format!("port {port} cannot be listened on: {e}"))?;
        let doors =
            Doors::new(own).map_err(|e| format!("the system gives no random numbers: {e}"))?;
        let desk = Desk {
            session,
            doors,
            switch,
            holder: Mutex::new(None),
            pages: AtomicUsize::new(0),
            numbers: AtomicUsize::new(1),
        };
        Ok(Self {
            listener,
            desk: Arc::new(desk),
        })
    }

    /// The link that opens the page.
    pub fn link(&self) -> String {
        self.desk.doors.link()
    }

    /// Serves for as long as the program runs.
    ///
    /// # Errors
    /// The system refuses.
    pub fn serve(self) -> std::io::Result<()> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()?;
        runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(self.listener)?;
            axum::serve(listener, routes(self.desk)).await
        })
    }
}

fn routes(desk: Arc<Desk>) -> Router {
    Router::new()
        .route("/", get(front))
        .route("/lab.css", get(style))
        .route("/lab.js", get(script))
        .route("/events", get(events))
        .route("/report", get(report))
        .route("/result.json", get(result_json))
        .route("/start", post(start))
        .route("/mounted", post(mounted))
        .route("/stop", post(stop))
        .route("/beat", post(beat))
        .route("/fault", post(fault))
        .fallback(missing)
        .layer(DefaultBodyLimit::max(LARGEST))
        .layer(from_fn_with_state(desk.clone(), door))
        .with_state(desk)
}

#[derive(Default, Deserialize)]
struct Given {
    token: Option<String>,
}

async fn door(
    State(desk): State<Arc<Desk>>,
    Query(given): Query<Given>,
    request: Request,
    next: Next,
) -> Response {
    let front = request.uri().path() == "/";
    let token = given.token.as_deref().filter(|_| front);
    let mut response = match desk.doors.check(request.method(), request.headers(), token) {
        Ok(()) => next.run(request).await,
        Err(refused) => refusal(refused),
    };
    let headers = response.headers_mut();
    let fixed = [
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "same-origin"),
        (header::CACHE_CONTROL, "no-store"),
    ];
    for (name, value) in fixed {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers
        .entry(header::CONTENT_SECURITY_POLICY)
        .or_insert(HeaderValue::from_static(OWN));
    response
}

fn refusal(refused: Refused) -> Response {
    (
        refused.status(),
        Html(page::notice("Refused", refused.text())),
    )
        .into_response()
}

async fn missing() -> Response {
    let text =
        "There is no such page. The live bench is at the address without anything behind the port.";
    (StatusCode::NOT_FOUND, Html(page::notice("Not found", text))).into_response()
}

async fn front(State(desk): State<Arc<Desk>>, Query(given): Query<Given>) -> Response {
    if given.token.is_some_and(|t| desk.doors.is_token(&t)) {
        // The token leaves the address, and with it the history.
        return (
            [(header::SET_COOKIE, desk.doors.cookie())],
            Redirect::to("/"),
        )
            .into_response();
    }
    let number = desk.numbers.fetch_add(1, Ordering::Relaxed);
    let view = view::of(&desk.session, desk.switch.as_ref());
    Html(page::front(
        &desk.session,
        &view,
        number,
        desk.switch.is_some(),
    ))
    .into_response()
}

async fn style() -> Response {
    (
        [(header::CONTENT_TYPE, "text/css; charset=utf-8")],
        page::STYLE,
    )
        .into_response()
}

async fn script() -> Response {
    (
        [(header::CONTENT_TYPE, "text/javascript; charset=utf-8")],
        page::SCRIPT,
    )
        .into_response()
}

async fn report(State(desk): State<Arc<Desk>>) -> Response {
    let result = desk.session.evaluated().result.clone();
    match result.map(|(result, _)| result.html()) {
        Some(Ok(html)) => ([(header::CONTENT_SECURITY_POLICY, REPORT)], Html(html)).into_response(),
        Some(Err(e)) => {
            let text = format!("The report cannot be written: {e}");
            (
                StatusCode::INTERNAL_SERVER_ERROR,
                Html(page::notice("No report", &text)),
            )
                .into_response()
        }
        None => {
            let text = "There is no result yet. It comes when a mounting is done and the runs determine it.";
            (StatusCode::NOT_FOUND, Html(page::notice("No report", text))).into_response()
        }
    }
}

/// The result so far, as `proofmass calibrate` writes it of the same folder.
async fn result_json(State(desk): State<Arc<Desk>>) -> Response {
    let result = desk.session.evaluated().result.clone();
    match result.map(|(result, _)| result.to_json()) {
        Some(Ok(json)) => ([(header::CONTENT_TYPE, "application/json")], json).into_response(),
        Some(Err(e)) => (StatusCode::INTERNAL_SERVER_ERROR, e.to_string()).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no result yet").into_response(),
    }
}

/// Counts a page for as long as its stream is open.
struct Looking(Arc<Desk>);

impl Drop for Looking {
    fn drop(&mut self) {
        self.0.pages.fetch_sub(1, Ordering::SeqCst);
    }
}

async fn events(State(desk): State<Arc<Desk>>) -> Response {
    if desk.pages.fetch_add(1, Ordering::SeqCst) >= PAGES {
        desk.pages.fetch_sub(1, Ordering::SeqCst);
        let text = "Too many pages look on: close one.";
        return (StatusCode::TOO_MANY_REQUESTS, text).into_response();
    }
    Sse::new(told(Looking(desk))).into_response()
}

fn told(looking: Looking) -> impl Stream<Item = Result<Event, Infallible>> {
    unfold(looking, |looking| async move {
        tokio::time::sleep(TOLD).await;
        let view = view::of(&looking.0.session, looking.0.switch.as_ref());
        let text = serde_json::to_string(&view).unwrap_or_default();
        Some((Ok(Event::default().data(text)), looking))
    })
}

#[derive(Deserialize)]
struct Asked {
    #[serde(default)]
    page: String,
    #[serde(default)]
    fault: String,
}

impl Desk {
    /// Whether this page holds the bench, or nobody does; it holds it from then on.
    fn holds(&self, page: &str) -> bool {
        let mut holder = self.holder.lock().unwrap_or_else(PoisonError::into_inner);
        let free =
            holder.as_deref().is_none_or(|h| h == page) || !self.session.shared.page_is_there();
        if free {
            *holder = Some(page.to_owned());
        }
        free
    }
}

/// A form of a page without script goes back to the page.
fn back(headers: &HeaderMap) -> Response {
    let accepts = headers.get(header::ACCEPT).and_then(|a| a.to_str().ok());
    match accepts.is_some_and(|a| a.contains("text/html")) {
        true => Redirect::to("/").into_response(),
        false => StatusCode::NO_CONTENT.into_response(),
    }
}

fn click(desk: &Desk, headers: &HeaderMap, asked: &Asked, click: Click) -> Response {
    if !desk.holds(&asked.page) {
        let text =
            "Another page holds the bench. It may be stopped from here, and started from there.";
        return (StatusCode::CONFLICT, Html(page::notice("Held", text))).into_response();
    }
    desk.session.shared.page_beat();
    desk.session.click(click);
    back(headers)
}

async fn start(
    State(desk): State<Arc<Desk>>,
    headers: HeaderMap,
    Form(asked): Form<Asked>,
) -> Response {
    click(&desk, &headers, &asked, Click::Start)
}

async fn mounted(
    State(desk): State<Arc<Desk>>,
    headers: HeaderMap,
    Form(asked): Form<Asked>,
) -> Response {
    click(&desk, &headers, &asked, Click::Mounted)
}

/// Anybody with the page may stop.
async fn stop(State(desk): State<Arc<Desk>>, headers: HeaderMap) -> Response {
    desk.session.stop();
    back(&headers)
}

async fn beat(State(desk): State<Arc<Desk>>, Form(asked): Form<Asked>) -> StatusCode {
    let holder = desk.holder.lock().unwrap_or_else(PoisonError::into_inner);
    if holder.as_deref() == Some(asked.page.as_str()) {
        desk.session.shared.page_beat();
    }
    StatusCode::NO_CONTENT
}

async fn fault(
    State(desk): State<Arc<Desk>>,
    headers: HeaderMap,
    Form(asked): Form<Asked>,
) -> Response {
    match (&desk.switch, Fault::of(&asked.fault)) {
        (Some(switch), Some(fault)) => {
            switch.set(fault);
            back(&headers)
        }
        (None, _) => (
            StatusCode::NOT_FOUND,
            "a bench of metal has no faults to switch on",
        )
            .into_response(),
        (_, None) => (StatusCode::BAD_REQUEST, "there is no such fault").into_response(),
    }
}
