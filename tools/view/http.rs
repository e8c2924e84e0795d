//! A request of HTTP/1.1 read strictly, and an answer written: what a page on this machine needs, and no more.
//!
//! `httparse` reads the head. A connection is one request and one answer; whatever is longer than a page sends, or
//! framed in a way that two readers could take for two things, is refused.

use std::io;
use std::io::Read;
use std::io::Write;
use std::net::Shutdown;
use std::net::TcpStream;
use std::time::Duration;

/// Most bytes of a head, fields in it, and bytes of a body: a scene has a hundredth of that.
const MOST_HEAD: usize = 16 << 10;
const MOST_FIELDS: usize = 64;
const MOST_BODY: usize = 4 << 20;

/// How long a client may be silent, and how long what it goes on sending after a refusal is read.
const PATIENCE: Duration = Duration::from_secs(10);
const PATIENCE_AFTER: Duration = Duration::from_millis(200);

/// What a page asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    Get,
    Post,
}

/// A request.
#[derive(Debug)]
pub(super) struct Request {
    pub(super) method: Method,
    /// Path and query, as they were sent.
    pub(super) target: String,
    /// Fields with their names in small letters, in the order that they came.
    fields: Vec<(String, String)>,
    pub(super) body: Vec<u8>,
}

impl Request {
    /// The only value of a field; `Err` where there are several.
    pub(super) fn field(&self, name: &str) -> Result<Option<&str>, Answer> {
        let mut values = self.fields.iter().filter(|(found, _)| found == name);
        let first = values.next().map(|(_, value)| value.as_str());
        match values.next() {
            None => Ok(first),
            Some(_) => Err(Answer::refused(400, &format!("found {name} twice"))),
        }
    }
}

/// An answer.
#[derive(Debug)]
pub(super) struct Answer {
    pub(super) status: u16,
    pub(super) content_type: &'static str,
    pub(super) body: Vec<u8>,
}

impl Answer {
    /// What was asked for.
    pub(super) fn of(content_type: &'static str, body: impl Into<Vec<u8>>) -> Self {
        Self {
            status: 200,
            content_type,
            body: body.into(),
        }
    }

    /// JSON.
    pub(super) fn json(value: &serde_json::Value) -> Self {
        Self::of("application/json", value.to_string())
    }

    /// That there is nothing.
    pub(super) fn nothing() -> Self {
        Self::refused(204, "")
    }

    /// Why it was refused.
    pub(super) fn refused(status: u16, message: &str) -> Self {
        Self {
            status,
            ..Self::of("text/plain; charset=utf-8", message)
        }
    }
}

/// Reads a request, has it answered, and writes that; nothing is said to whoever is gone.
pub(super) fn serve(stream: &TcpStream, answer: impl FnOnce(&Request) -> Answer) {
    let patience = Some(PATIENCE);
    if stream.set_read_timeout(patience).is_err() || stream.set_write_timeout(patience).is_err() {
        return;
    }
    let answered = match read(stream) {
        Ok(Some(request)) => answer(&request),
        Ok(None) | Err(Trouble::Gone) => return,
        Err(Trouble::Refused(answer)) => answer,
    };
    if write(stream, &answered).is_ok() {
        linger(stream);
    }
}

/// Why there is no request.
#[derive(Debug)]
enum Trouble {
    Refused(Answer),
    Gone,
}

impl From<io::Error> for Trouble {
    fn from(_: io::Error) -> Self {
        Self::Gone
    }
}

fn refused<T>(status: u16, message: &str) -> Result<T, Trouble> {
    Err(Trouble::Refused(Answer::refused(status, message)))
}

/// A request; `None` where the connection was closed without one.
fn read(mut stream: impl Read) -> Result<Option<Request>, Trouble> {
    let mut bytes = Vec::new();
    loop {
        let mut chunk = [0; 4096];
        let n_read = stream.read(&mut chunk)?;
        if n_read == 0 {
            return if bytes.is_empty() {
                Ok(None)
            } else {
                refused(400, "found half of a request")
            };
        }
        bytes.extend_from_slice(&chunk[..n_read]);
        let mut fields = [httparse::EMPTY_HEADER; MOST_FIELDS];
        let mut head = httparse::Request::new(&mut fields);
        match head.parse(&bytes) {
            Ok(httparse::Status::Complete(length)) => {
                let (mut request, n_body) = request(&head)?;
                let mut body = bytes.split_off(length);
                if body.len() > n_body {
                    return refused(400, "found more than one request");
                }
                let n_left = n_body - body.len();
                stream.take(n_left as u64).read_to_end(&mut body)?;
                if body.len() < n_body {
                    return Err(Trouble::Gone);
                }
                request.body = body;
                return Ok(Some(request));
            }
            Ok(httparse::Status::Partial) if bytes.len() < MOST_HEAD => (),
            Ok(httparse::Status::Partial) | Err(httparse::Error::TooManyHeaders) => {
                return refused(431, "found a longer head than a page sends");
            }
            Err(error) => return refused(400, &format!("no request of HTTP/1.1: {error}")),
        }
    }
}

/// A request without its body, and how long that is.
fn request(head: &httparse::Request) -> Result<(Request, usize), Trouble> {
    let method = match head.method {
        Some("GET") => Method::Get,
        Some("POST") => Method::Post,
        _ => return refused(405, "expected GET or POST"),
    };
    if head.version != Some(1) {
        return refused(505, "expected HTTP/1.1");
    }
    let mut fields = Vec::new();
    for field in head.headers.iter() {
        let Ok(value) = std::str::from_utf8(field.value) else {
            return refused(400, "found a field that is no text");
        };
        fields.push((field.name.to_ascii_lowercase(), value.trim().to_owned()));
    }
    let request = Request {
        method,
        target: head.path.unwrap_or_default().to_owned(),
        fields,
        body: Vec::new(),
    };
    let field = |name| request.field(name).map_err(Trouble::Refused);
    if field("transfer-encoding")?.is_some() {
        return refused(501, "expected Content-Length");
    }
    let length = match (field("content-length")?, method) {
        (None, Method::Get) => 0,
        (None, Method::Post) => return refused(411, "expected Content-Length"),
        (Some(length), _) if length.bytes().all(|it| it.is_ascii_digit()) => {
            length.parse().unwrap_or(usize::MAX)
        }
        (Some(_), _) => return refused(400, "expected a number as Content-Length"),
    };
    if length > MOST_BODY {
        return refused(413, "found a longer body than a scene has");
    }
    Ok((request, length))
}

fn write(mut stream: &TcpStream, answer: &Answer) -> io::Result<()> {
    let Answer {
        status,
        content_type,
        body,
    } = answer;
    let reason = match status {
        200 => "OK",
        204 => "No Content",
        403 => "Forbidden",
        404 => "Not Found",
        409 => "Conflict",
        422 => "Unprocessable Content",
        _ => "Refused",
    };
    // The page loads nothing from elsewhere, nobody shows it in theirs, and its address goes nowhere.
    let head = format!(
        "HTTP/1.1 {status} {reason}\r\nContent-Type: {content_type}\r\nContent-Length: {}\r\nConnection: close\r\n\
         Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\nCross-Origin-Opener-Policy: same-origin\r\n\
         Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
         img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(body)?;
    stream.flush()
}

/// Reads what is still sent, for a while: closed at once, the answer to it would be lost.
fn linger(mut stream: &TcpStream) {
    let is_closing = stream.shutdown(Shutdown::Write).is_ok();
    if is_closing && stream.set_read_timeout(Some(PATIENCE_AFTER)).is_ok() {
        let mut chunk = [0; 4096];
        let mut left = MOST_BODY;
        while let Ok(n_read @ 1..) = stream.read(&mut chunk) {
            left = left.saturating_sub(n_read);
            if left == 0 {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status_of(bytes: &[u8]) -> Option<u16> {
        match read(bytes) {
            Err(Trouble::Refused(answer)) => Some(answer.status),
            Ok(_) | Err(Trouble::Gone) => None,
        }
    }

    #[test]
    fn a_request_has_its_fields_and_its_body() {
        let sent = b"POST /a?b HTTP/1.1\r\nHost: x\r\nContent-LENGTH: 3\r\n\r\nabc";
        let request = read(&sent[..]).unwrap().unwrap();
        assert_eq!((request.method, &*request.target), (Method::Post, "/a?b"));
        assert_eq!(request.field("host").unwrap(), Some("x"));
        assert_eq!(request.body, b"abc");
    }

    #[test]
    fn what_is_framed_in_two_ways_or_too_long_is_refused() {
        let post = |fields: &str| format!("POST / HTTP/1.1\r\n{fields}\r\n");
        let long = format!("X: {}\r\n", "a".repeat(MOST_HEAD));
        let many = "X: a\r\n".repeat(MOST_FIELDS + 1);
        for (sent, expected) in [
            (post(""), 411),
            (post("Content-Length: 1\r\nContent-Length: 2\r\n"), 400),
            (
                post("Content-Length: 3\r\nTransfer-Encoding: chunked\r\n"),
                501,
            ),
            (post("Content-Length: -1\r\n"), 400),
            (post("Content-Length: +1\r\n"), 400),
            (post("Content-Length: 99999999999999999999999\r\n"), 413),
            (post(&long), 431),
            (post(&many), 431),
            (
                "GET / HTTP/1.1\r\n\r\nGET / HTTP/1.1\r\n\r\n".to_owned(),
                400,
            ),
            ("GET / HTTP/1.0\r\n\r\n".to_owned(), 505),
            ("PUT / HTTP/1.1\r\n\r\n".to_owned(), 405),
            ("GET /\r\n".to_owned(), 400),
            ("GET / HTT".to_owned(), 400),
        ] {
            assert_eq!(status_of(sent.as_bytes()), Some(expected), "{sent:.80}");
        }
        assert!(matches!(read(&b""[..]), Ok(None)));
    }
}
