//! A page that its running command serves: only on the loopback address, under a secret path.

mod moves;
mod session;

use std::fmt::{Display, Write as _};
use std::io::Read;
use std::net::TcpListener;
#[cfg(unix)]
use std::net::TcpStream;
#[cfg(unix)]
use std::os::fd::OwnedFd;

use serde_json::{Value, json};
use tiny_http::{Header, Method, Request, Response, Server};

use crate::terminal::failure::BadInput;

pub(crate) use session::{Measured, Session};

/// Number of requests that are answered in parallel. Two are for run and theory of a move, one each for the
/// map, for the replay of records, and for changes of the file.
const WORKERS: usize = 5;
/// Largest request in bytes.
const LONGEST: u64 = 1 << 16;
/// Length of the secret, bytes.
const SECRET: usize = 16;
/// The page loads nothing from elsewhere.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; \
     style-src 'unsafe-inline'; connect-src 'self'; img-src data: blob:";

/// A server that is ready, with the address of its page.
pub(crate) struct Live {
    server: Server,
    host: String,
    secret: String,
}

impl Live {
    /// Opens a port of the loopback address; 0 takes any free one.
    pub(crate) fn new(port: u16) -> crate::Result<Self> {
        let cannot = |error: &dyn Display| {
            BadInput::error(
                format!("cannot listen on 127.0.0.1: {error}"),
                "leave --port out, and a free port is taken",
            )
        };
        let listener = TcpListener::bind(("127.0.0.1", port)).map_err(|error| cannot(&error))?;
        promptly(&listener);
        let server = Server::from_listener(listener, None).map_err(|error| cannot(&error))?;
        let mut bytes = [0; SECRET];
        getrandom::fill(&mut bytes).map_err(|error| {
            BadInput::error(
                format!("the system gives no random numbers: {error}"),
                "give the process access to the system's random numbers, such as /dev/urandom",
            )
        })?;
        let secret = bytes.iter().fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        });
        let host = server.server_addr().to_string();
        Ok(Self { server, host, secret })
    }

    /// Address of the page.
    pub(crate) fn address(&self) -> String {
        format!("http://{}/{}/", self.host, self.secret)
    }

    /// Answers requests until the command ends.
    pub(crate) fn serve(&self, session: &Session) {
        std::thread::scope(|scope| {
            for _ in 0..WORKERS {
                scope.spawn(|| {
                    while let Ok(request) = self.server.recv() {
                        self.answer(session, request);
                    }
                });
            }
        });
    }

    fn answer(&self, session: &Session, mut request: Request) {
        let mut hosts = request.headers().iter().filter(|header| header.field.equiv("Host"));
        let is_ours =
            hosts.next().is_some_and(|header| header.value.as_str() == self.host) && hosts.next().is_none();
        let path = request.url().strip_prefix(&format!("/{}/", self.secret)).map(str::to_owned);
        let Some(path) = path.filter(|_| is_ours) else {
            let _ = request.respond(Response::from_string("not found").with_status_code(404));
            return;
        };
        let method = request.method().clone();
        let asked = if method == Method::Post { asked(&mut request) } else { Value::Null };
        let (kind, text) = match (method, path.as_str()) {
            (Method::Get, "") => ("text/html; charset=utf-8", session.page()),
            (Method::Get, "file") => ("application/json", session.file().to_string()),
            (Method::Post, "state") => ("application/json", session.state(&asked).to_string()),
            (Method::Post, "map") => ("application/json", session.map(&asked).to_string()),
            (Method::Post, "replay") => ("application/json", session.replay(&asked).to_string()),
            (Method::Post, "write") => ("application/json", session.write(&asked).to_string()),
            _ => {
                let _ = request.respond(Response::from_string("not found").with_status_code(404));
                return;
            }
        };
        // The response is not chunked; its header has the length.
        let mut response = Response::from_string(text).with_chunked_threshold(usize::MAX);
        let headers = [
            ("Content-Type", kind),
            ("Cache-Control", "no-store"),
            ("Referrer-Policy", "no-referrer"),
            ("X-Content-Type-Options", "nosniff"),
            ("Content-Security-Policy", POLICY),
        ];
        for (name, value) in headers {
            if let Ok(header) = Header::from_bytes(name, value) {
                response.add_header(header);
            }
        }
        // If the page was closed, nothing waits for a response.
        let _ = request.respond(response);
    }
}

/// Makes all connections send small packets at once. Otherwise the body waits until the browser has
/// acknowledged the header, which takes 40 ms.
fn promptly(listener: &TcpListener) {
    // Connections inherit the option from their listener; `std` sets it on streams only.
    #[cfg(unix)]
    if let Ok(copy) = listener.try_clone() {
        let _ = TcpStream::from(OwnedFd::from(copy)).set_nodelay(true);
    }
    #[cfg(not(unix))]
    let _ = listener;
}

/// The content of a request; an empty object if it is not JSON.
fn asked(request: &mut Request) -> Value {
    let mut text = String::new();
    let read = request.as_reader().take(LONGEST).read_to_string(&mut text);
    read.ok().and_then(|_| serde_json::from_str(&text).ok()).unwrap_or_else(|| json!({}))
}
