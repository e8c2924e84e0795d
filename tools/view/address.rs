//! Who may ask: whoever knows the address that was printed, from a page of this very server.
//!
//! A page of somebody else that is open in the same browser can send requests here. It cannot read the token, and
//! its requests say whose they are: by `Origin`, by `Sec-Fetch-Site`, and by the `Host` that it knows this machine by.

use std::fmt::Write as _;

use super::http::Answer;
use super::http::Request;

/// Bytes of a token: nobody guesses 128 bits.
const N_BYTES: usize = 16;

/// The address of the page.
pub(super) struct Address {
    port: u16,
    token: String,
}

impl Address {
    /// With a token that nobody knows.
    ///
    /// # Errors
    /// A system without random numbers.
    pub(super) fn new(port: u16) -> Result<Self, getrandom::Error> {
        let mut bytes = [0; N_BYTES];
        getrandom::fill(&mut bytes)?;
        let token = bytes.iter().fold(String::new(), |mut token, byte| {
            // Writing to a String cannot fail.
            let _ = write!(token, "{byte:02x}");
            token
        });
        Ok(Self { port, token })
    }

    /// What a person opens.
    pub(super) fn url(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    /// What is asked for under the address: path and query.
    ///
    /// # Errors
    /// The refusal of a request from elsewhere, or without the token.
    pub(super) fn inside<'a>(&self, request: &'a Request) -> Result<(&'a str, &'a str), Answer> {
        let hosts = ["127.0.0.1", "localhost"].map(|host| format!("{host}:{}", self.port));
        let is_ours = |host: &str| hosts.iter().any(|ours| ours == host);
        let forbidden = |what: &str| Err(Answer::refused(403, what));
        if !request.field("host")?.is_some_and(is_ours) {
            return forbidden("found another host, expected the address that was printed");
        }
        let origin = request.field("origin")?;
        let is_own = |origin: &str| origin.strip_prefix("http://").is_some_and(is_ours);
        let site = request.field("sec-fetch-site")?;
        if !origin.is_none_or(is_own) || !site.is_none_or(|it| it == "same-origin" || it == "none")
        {
            return forbidden("found a page of another origin");
        }
        let (path, query) = request
            .target
            .split_once('?')
            .unwrap_or((&request.target, ""));
        let inside = path.strip_prefix('/').and_then(|it| it.split_once('/'));
        match inside {
            Some((token, inside)) if is_equal(token, &self.token) => Ok((inside, query)),
            _ => forbidden("found no such token, expected the address that was printed"),
        }
    }
}

/// Compares in a time that does not depend on how much is equal.
fn is_equal(one: &str, other: &str) -> bool {
    let pairs = one.bytes().zip(other.bytes());
    one.len() == other.len() && pairs.fold(0, |differs, (a, b)| differs | (a ^ b)) == 0
}
