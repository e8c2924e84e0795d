//! The files of the page, which are in the program.

use super::http::Answer;

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";

/// Names, kinds and contents.
const FILES: [(&str, &str, &str); 11] = [
    ("", HTML, include_str!("page/index.html")),
    ("style.css", CSS, include_str!("page/style.css")),
    ("view.js", JS, include_str!("page/view.js")),
    ("server.js", JS, include_str!("page/server.js")),
    ("tone.js", JS, include_str!("page/tone.js")),
    ("picture.js", JS, include_str!("page/picture.js")),
    ("marks.js", JS, include_str!("page/marks.js")),
    ("controls.js", JS, include_str!("page/controls.js")),
    ("elements.js", JS, include_str!("page/elements.js")),
    ("sun.js", JS, include_str!("page/sun.js")),
    ("pointer.js", JS, include_str!("page/pointer.js")),
];

/// A file of the page.
pub(super) fn file(name: &str) -> Option<Answer> {
    let file = FILES.iter().find(|(known, ..)| *known == name);
    file.map(|(_, kind, content)| Answer::of(kind, *content))
}
