//! Who may speak to the server: the browser that opened the link of this start, from the page of this server.
//!
//! `Host` is compared with the list of the server's own names, so that a foreign name that resolves to this machine is
//! refused; comparing `Origin` with `Host` would not do that. A request that changes something, and a stream, must come
//! from the page of this server by its `Origin`.

use axum::http::{HeaderMap, Method, StatusCode, header};
use std::net::SocketAddr;

/// Why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// The name in `Host` is none of this server.
    Host,
    /// The request comes from another page.
    Origin,
    /// The token of this start is missing.
    Token,
}

impl Refused {
    /// Status of the answer.
    pub fn status(self) -> StatusCode {
        match self {
            Self::Host => StatusCode::MISDIRECTED_REQUEST,
            Self::Origin | Self::Token => StatusCode::FORBIDDEN,
        }
    }

    /// The answer for people.
    pub fn text(self) -> &'static str {
        match self {
            Self::Host => {
                "This server answers to 127.0.0.1 and localhost alone. Open the link that the program printed."
            }
            Self::Origin => {
                "This request comes from another page and is refused. Use the page of the live bench."
            }
            Self::Token => {
                "This browser has no key to the live bench, or the program was started anew. Open the link that the program printed when it started."
            }
        }
    }
}

/// The token and the names of one start.
#[derive(Clone, Debug)]
pub struct Doors {
    token: String,
    cookie: String,
    hosts: [String; 2],
}

impl Doors {
    /// Draws the token of a start.
    ///
    /// # Errors
    /// The system gives no random numbers.
    pub fn new(address: SocketAddr) -> Result<Self, getrandom::Error> {
        let mut bytes = [0u8; 24];
        getrandom::fill(&mut bytes)?;
        let port = address.port();
        Ok(Self {
            token: bytes.iter().map(|b| format!("{b:02x}")).collect(),
            // Cookies know no ports: each has a name of its own.
            cookie: format!("proofmass-lab-{port}"),
            hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")],
        })
    }

    /// The link that opens the page.
    pub fn link(&self) -> String {
        format!("http://{}/?token={}", self.hosts[0], self.token)
    }

    /// The cookie that the link leaves.
    pub fn cookie(&self) -> String {
        format!(
            "{}={}; HttpOnly; SameSite=Strict; Path=/",
            self.cookie, self.token
        )
    }

    /// Whether a token is that of this start, in a time that tells nothing of it.
    pub fn is_token(&self, given: &str) -> bool {
        let differing = given
            .bytes()
            .zip(self.token.bytes())
            .fold(0, |d, (a, b)| d | (a ^ b));
        given.len() == self.token.len() && differing == 0
    }

    /// Looks at a request before anything else does; `token` is the one of its address, where it has one.
    ///
    /// # Errors
    /// Why it is refused.
    pub fn check(
        &self,
        method: &Method,
        headers: &HeaderMap,
        token: Option<&str>,
    ) -> Result<(), Refused> {
        let mut hosts = headers.get_all(header::HOST).iter();
        let host = hosts.next().and_then(|h| h.to_str().ok());
        if hosts.next().is_some() || !self.hosts.iter().any(|h| Some(h.as_str()) == host) {
            return Err(Refused::Host);
        }
        let origin = headers
            .get(header::ORIGIN)
            .map(|o| o.to_str().unwrap_or_default());
        let own = |o: &str| {
            self.hosts
                .iter()
                .any(|h| o.strip_prefix("http://") == Some(h))
        };
        let reads = *method == Method::GET || *method == Method::HEAD;
        // A browser leaves `Origin` out where its own page reads; it never does where something is changed.
        if !origin.map_or(reads, own) {
            return Err(Refused::Origin);
        }
        let known = self.cookies(headers).any(|c| self.is_token(c));
        match known || token.is_some_and(|t| reads && self.is_token(t)) {
            true => Ok(()),
            false => Err(Refused::Token),
        }
    }

    fn cookies<'a>(&'a self, headers: &'a HeaderMap) -> impl Iterator<Item = &'a str> {
        let all = headers
            .get_all(header::COOKIE)
            .iter()
            .filter_map(|c| c.to_str().ok());
        let pairs = all
            .flat_map(|c| c.split(';'))
            .filter_map(|p| p.trim().split_once('='));
        pairs
            .filter(|(name, _)| *name == self.cookie)
            .map(|(_, value)| value)
    }
}
