//! A program that serves a scene, and what it answers by plain HTTP.

#![allow(
    dead_code,
    clippy::unwrap_used,
    unreachable_pub,
    reason = "each target uses its own part, and ends where it fails"
)]

use std::io::BufRead;
use std::io::BufReader;
use std::io::Read;
use std::io::Write;
use std::net::Shutdown;
use std::net::TcpStream;
use std::path::Path;
use std::process::Child;
use std::process::Command;
use std::process::Stdio;
use std::time::Duration;
use std::time::Instant;

use serde_json::Value;
use serde_json::json;

/// Longest that a picture of a tenth of a second may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// A program that serves a scene, ended with the test.
pub struct View {
    child: Child,
    /// `127.0.0.1:PORT`
    pub host: String,
    /// `/TOKEN/`
    pub base: String,
}

impl Drop for View {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl View {
    /// Serves a scene.
    pub fn of(scene: &Path) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_niji"))
            .arg("view")
            .arg(scene)
            .arg("-q")
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        let printed = child.stdout.take().unwrap();
        BufReader::new(printed).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("http://").unwrap();
        let (host, base) = address.split_at(address.find('/').unwrap());
        Self {
            child,
            host: host.to_owned(),
            base: base.to_owned(),
        }
    }

    /// Sends bytes as they are; status and body of what comes back, none where nothing does.
    pub fn send(&self, bytes: &[u8]) -> Option<(u16, Vec<u8>)> {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        // It may have been refused already.
        let _ = stream.write_all(bytes);
        let _ = stream.shutdown(Shutdown::Write);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let end = answer.windows(4).position(|it| it == b"\r\n\r\n")?;
        let head = String::from_utf8(answer[..end].to_vec()).unwrap();
        let status = head.split(' ').nth(1)?.parse().ok()?;
        Some((status, answer.split_off(end + 4)))
    }

    /// Asks for a path with fields.
    pub fn get_from(&self, path: &str, fields: &str) -> (u16, Vec<u8>) {
        let request = format!("GET {path} HTTP/1.1\r\n{fields}\r\n");
        self.send(request.as_bytes()).unwrap()
    }

    /// Asks for something under the address.
    pub fn get(&self, path: &str) -> (u16, Vec<u8>) {
        let host = format!("Host: {}\r\n", self.host);
        self.get_from(&format!("{}{path}", self.base), &host)
    }

    /// The same as JSON.
    pub fn json(&self, path: &str) -> Value {
        let (status, body) = self.get(path);
        assert_eq!(status, 200, "{path}");
        serde_json::from_slice(&body).unwrap()
    }

    /// Has something done under the address.
    pub fn post(&self, path: &str, body: &Value) -> (u16, Value) {
        let body = body.to_string();
        let request = format!(
            "POST {}{path} HTTP/1.1\r\nHost: {}\r\nContent-Length: {}\r\n\r\n{body}",
            self.base,
            self.host,
            body.len()
        );
        let (status, body) = self.send(request.as_bytes()).unwrap();
        (status, serde_json::from_slice(&body).unwrap())
    }

    /// Sets a value.
    pub fn set(&self, key: &str, value: &Value) -> (u16, Value) {
        self.post("set", &json!({ "values": { key: value } }))
    }

    /// The picture of the scene as it is now, as `niji run` makes it.
    pub fn picture(&self) -> Value {
        let start = Instant::now();
        let mut after = 0;
        while start.elapsed() < PATIENCE {
            let news = self.json(&format!("news?after={after}"));
            if news["progress"].is_null() && news["picture"]["is_finished"] == true {
                return news["picture"].clone();
            }
            assert!(news["trouble"].is_null(), "{news}");
            after = news["event"].as_u64().unwrap();
        }
        panic!("no picture");
    }

    /// Its pixels.
    pub fn pixels(&self) -> Vec<f32> {
        let number = &self.picture()["number"];
        let (status, bytes) = self.get(&format!("pixels?picture={number}"));
        assert_eq!(status, 200);
        let (values, rest) = bytes.as_chunks::<4>();
        assert!(rest.is_empty());
        values.iter().map(|it| f32::from_le_bytes(*it)).collect()
    }
}
