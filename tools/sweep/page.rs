//! The page of a sweep: one file of HTML with everything inside.

use std::fmt::Write as _;
use std::fs;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::PRESET;
use super::point::Point;
use super::point::Runs;
use crate::failure::Failure;

const HEAD: &str = "<!DOCTYPE html>
<html lang=\"en\">
<head>
<meta charset=\"utf-8\">
<style>
body { font: 15px/1.45 sans-serif; color: #222; max-width: 1100px; margin: 2em auto; padding: 0 1em }
table { border-collapse: collapse; font-variant-numeric: tabular-nums }
th, td { padding: 2px 10px; text-align: right; border-bottom: 1px solid #e4e4e4 }
th:nth-child(-n+2), td:nth-child(-n+2) { text-align: left }
tr.front { background: #fff6d8 }
figure { display: inline-block; margin: 0 12px 18px 0; width: 500px; vertical-align: top }
figure img { width: 245px; image-rendering: auto }
svg { max-width: 100%; height: auto }
</style>
";

/// What the page shows.
pub(super) struct Page<'a> {
    pub(super) title: &'a str,
    pub(super) points: &'a [Point],
    /// Error against time, as SVG.
    pub(super) plot: &'a str,
}

impl Page<'_> {
    /// The page, with the pictures of the presets and of the Pareto front.
    ///
    /// # Errors
    /// A picture of a run that cannot be read.
    pub(super) fn html(&self, runs: &Runs) -> Result<String, Failure> {
        let title = escaped(self.title);
        let mut html =
            format!("{HEAD}<title>{title}: what accuracy costs</title>\n</head>\n<body>\n");
        let _ = write!(
            html,
            "<h1>{title}: what accuracy costs</h1>\n<p>Each point is the whole scene, run from nothing \
             with one level in place of the scene&rsquo;s own, or with a preset. Errors are relative \
             RMSE of spectral radiance against the preset <em>reference</em>; <em>own</em> against the \
             best level of the same decision. No other point is faster and nearer than those on the \
             Pareto front (marked).</p>\n{}\n",
            self.plot
        );
        self.table(&mut html);
        html += "<h2>Pictures</h2>\n<p>Left the preview, right the color difference CIEDE2000 to the \
                 reference, from 0 (dark blue) to 10 and more (yellow); 1 is just seen side by side.</p>\n";
        let mut shown: Vec<&str> = Vec::new();
        for point in self.points {
            let is_wanted = point.on_front || point.decision == PRESET;
            if is_wanted && !shown.contains(&point.run.as_str()) {
                figure(&mut html, point, runs)?;
                shown.push(&point.run);
            }
        }
        html += "</body>\n</html>\n";
        Ok(html)
    }

    fn table(&self, html: &mut String) {
        *html += "<table>\n<tr><th>decision</th><th>level</th><th>time (s)</th><th>memory (MB)</th>\
                  <th>relative RMSE</th><th>own</th><th>largest/white</th><th>&Delta;E mean</th>\
                  <th>&Delta;E max</th></tr>\n";
        for point in self.points {
            let class = if point.on_front {
                " class=\"front\""
            } else {
                ""
            };
            let memory = point
                .peak_memory_mb
                .map_or_else(|| "?".to_owned(), |megabytes| format!("{megabytes:.0}"));
            let _ = writeln!(
                html,
                "<tr{class}><td>{}</td><td>{}</td><td>{:.3}</td><td>{memory}</td><td>{:.1e}</td>\
                 <td>{:.1e}</td><td>{:.1e}</td><td>{:.2}</td><td>{:.2}</td></tr>",
                escaped(&point.decision),
                escaped(&point.level),
                point.seconds,
                point.relative_rmse,
                point.own_relative_rmse,
                point.max_over_white,
                point.mean_color_difference,
                point.max_color_difference,
            );
        }
        *html += "</table>\n";
    }
}

fn figure(html: &mut String, point: &Point, runs: &Runs) -> Result<(), Failure> {
    let mut images = String::new();
    for path in [runs.picture(&point.run), runs.map(&point.run)] {
        let png = fs::read(&path).map_err(|error| Failure::bad_input(&path, error))?;
        let data = BASE64_STANDARD.encode(png);
        let _ = write!(
            images,
            "<img alt=\"\" src=\"data:image/png;base64,{data}\"> "
        );
    }
    let _ = writeln!(
        html,
        "<figure>{images}<figcaption>{}: {}, {:.3} s, relative RMSE {:.1e}</figcaption></figure>",
        escaped(&point.decision),
        escaped(&point.level),
        point.seconds,
        point.relative_rmse,
    );
    Ok(())
}

/// Text of a scene is nobody's HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
