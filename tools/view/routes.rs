//! Which request does what.

use std::time::Duration;

use niji_picture::SkyMarks;
use serde::Deserialize;
use serde_json::Map;
use serde_json::Value;
use serde_json::json;

use super::address::Address;
use super::desk::Desk;
use super::document::Document;
use super::document::PicksDrag;
use super::document::Refused;
use super::http::Answer;
use super::http::Method;
use super::http::Request;
use super::page;
use super::toml_values;
use crate::flags::Common;
use crate::shell_word::quoted;

/// How long a page waits for news.
const WAIT: Duration = Duration::from_secs(8);

/// Changes of values.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Change<T> {
    values: T,
    /// The movement of a hand that it belongs to.
    gesture: Option<String>,
}

/// Another text.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NewText {
    text: String,
    /// Number of the scene that it was made from.
    of: u64,
}

/// All that answers.
pub(super) struct Routes<'a> {
    pub(super) address: &'a Address,
    pub(super) desk: &'a Desk,
    pub(super) common: &'a Common,
}

impl Routes<'_> {
    /// Answers a request.
    pub(super) fn answer(&self, request: &Request) -> Answer {
        let (path, query) = match self.address.inside(request) {
            Ok(inside) => inside,
            Err(refusal) => return refusal,
        };
        match request.method {
            Method::Get => self.told(path, query),
            Method::Post => self.done(path, &request.body),
        }
    }

    fn told(&self, path: &str, query: &str) -> Answer {
        if let Some(file) = page::file(path) {
            return file;
        }
        let number = |name: &str| -> Option<f64> { argument(query, name)?.parse().ok() };
        let missing = || Answer::refused(404, "there is no such thing here");
        match path {
            "schema" => Answer::json(&niji_scene::scene_schema()),
            "scene" => self.scene(),
            "news" => Answer::json(&(self.desk).news(number("after").unwrap_or(0.0) as u64, WAIT)),
            "pixels" => match (number("picture"), self.desk.picture()) {
                (Some(wanted), Some(it)) if wanted == it.number as f64 => {
                    Answer::of("application/octet-stream", it.pixels())
                }
                // There is a newer one, of which there are news.
                (Some(_), _) => Answer::nothing(),
                (None, _) => missing(),
            },
            "picture.png" => match self.desk.picture() {
                Some(it) => {
                    let exposure_ev = self.desk.look(|it, _| it.scene().picture.exposure_ev);
                    match it.png(exposure_ev) {
                        Ok(bytes) => Answer::of("image/png", bytes),
                        Err(error) => Answer::refused(500, &error.to_string()),
                    }
                }
                None => missing(),
            },
            "at" => {
                let place = number("right").zip(number("down"));
                let at = place.zip(self.desk.picture());
                let known = at.and_then(|((right, down), it)| it.at([right, down]));
                known.map_or_else(missing, |known| Answer::json(&known))
            }
            _ => missing(),
        }
    }

    fn done(&self, path: &str, body: &[u8]) -> Answer {
        let outcome = match path {
            "set" => read(body).and_then(|change: Change<Map<String, Value>>| {
                let gesture = change.gesture.as_deref();
                // By their keys.
                self.desk.work(|it| it.set(&change.values, gesture))
            }),
            "drag-picks" => read(body).and_then(|change: Change<PicksDrag>| {
                let gesture = change.gesture.as_deref();
                self.desk.work(|it| it.drag_picks(&change.values, gesture))
            }),
            "text" => read(body).and_then(|new: NewText| {
                if self.desk.look(|_, revision| revision) != new.of {
                    let message = "the scene was changed elsewhere meanwhile: read it here first";
                    return Err(Refused::because(message));
                }
                self.desk.work(|it| it.replace(new.text, None))
            }),
            "undo" => self.desk.work(|it| it.step(true)),
            "redo" => self.desk.work(|it| it.step(false)),
            "save" => self.desk.work(Document::save),
            "again" => self.desk.work(Document::read_again),
            _ => return Answer::refused(404, "there is no such thing here"),
        };
        match outcome {
            Ok(()) => self.scene(),
            Err(Refused { key, message }) => Answer {
                status: if path == "save" { 409 } else { 422 },
                ..Answer::json(&json!({ "key": key, "message": message }))
            },
        }
    }

    /// The scene with all that a page shows of it beside the picture.
    fn scene(&self) -> Answer {
        self.desk.look(|document, revision| {
            let scene = document.scene();
            let [can_undo, can_redo, is_edited] = document.steps();
            Answer::json(&json!({
                "revision": revision,
                "name": scene.name,
                "path": document.path().display().to_string(),
                "text": document.text(),
                "values": toml_values::values(document.text()),
                "size": [scene.camera.width_px, scene.camera.height_px],
                "photograph_size": document.photograph_size(),
                "exposure_ev": scene.picture.exposure_ev,
                "sun": { "elevation_deg": scene.sun.elevation_deg, "azimuth_deg": scene.sun.azimuth_deg },
                "degrees_per_pixel": degrees_per_pixel(&scene),
                "marks": marks(&scene),
                "can_undo": can_undo,
                "can_redo": can_redo,
                "is_edited": is_edited,
                "command": command(document, self.common),
            }))
        })
    }
}

/// What a request says in JSON.
fn read<'a, T: Deserialize<'a>>(body: &'a [u8]) -> Result<T, Refused> {
    serde_json::from_slice(body).map_err(|error| Refused::because(error.to_string()))
}

/// A value of a query.
fn argument<'a>(query: &'a str, name: &str) -> Option<&'a str> {
    let mut pairs = query.split('&').filter_map(|pair| pair.split_once('='));
    pairs
        .find(|(found, _)| *found == name)
        .map(|(_, value)| value)
}

/// Angle of a pixel in the middle of the picture.
fn degrees_per_pixel(scene: &niji_scene::Scene) -> Option<f64> {
    let camera = scene.camera.camera().ok()?;
    Some(camera.pixel_angle().to_degrees())
}

fn marks(scene: &niji_scene::Scene) -> Value {
    let Ok(marks) = SkyMarks::of(scene) else {
        return Value::Null;
    };
    let bows = marks.bows.iter().map(|(edge, lines)| {
        json!({
            "bow": edge.bow,
            "color": edge.color,
            "angle_deg": edge.angle().to_degrees(),
            "lines": lines,
        })
    });
    json!({
        "bows": bows.collect::<Vec<_>>(),
        "horizon": marks.horizon,
        "antisolar_px": marks.antisolar_px,
        "sun_px": marks.sun_px,
    })
}

/// The command that makes the picture which is shown.
fn command(document: &Document, common: &Common) -> String {
    let mut words = vec![quoted(document.path())];
    words.extend(common.picture_flags());
    format!("niji run {} -o out", words.join(" "))
}
