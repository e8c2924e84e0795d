//! Progress bars on standard error, only where a person looks at it.

use std::fmt::Display;
use std::sync::Once;
use std::sync::OnceLock;
use std::time::Duration;
use std::time::Instant;

use indicatif::ProgressBar;
use indicatif::ProgressDrawTarget;
use indicatif::ProgressStyle;

use crate::output;

/// How much the program says on standard error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Verbosity {
    /// Only errors.
    Quiet,
    /// Messages, tables and progress.
    Normal,
    /// Also what each stage decided.
    Verbose,
}

impl Verbosity {
    /// Says something on standard error, unless it is to be quiet.
    pub(crate) fn say(self, text: impl Display) {
        if self > Self::Quiet {
            output::say(text);
        }
    }

    /// Says a warning, unless it is to be quiet.
    pub(crate) fn warn(self, warning: impl Display) {
        self.say(format_args!("{:>11}  {warning}", "warning"));
    }
}

/// A bar over `n_steps` steps; hidden when quiet or when standard error is not a terminal.
#[must_use]
pub(crate) fn bar(stage: &str, n_steps: u64, verbosity: Verbosity) -> ProgressBar {
    if verbosity == Verbosity::Quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(n_steps), ProgressDrawTarget::stderr());
    let template = "{prefix:>11} {wide_bar} {percent:>3} %  {eta} left";
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.set_prefix(stage.to_owned());
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Work that is watched before its time is estimated.
const WATCHED_S: f64 = 2.0;
/// Estimates below it are not worth a line.
const LONG_S: f64 = 20.0;

/// Says once, soon after the start of a long run, how long it will take, also where no bar is drawn.
pub(crate) struct Estimate {
    stage: &'static str,
    verbosity: Verbosity,
    /// When parts began to be done, and which was the first: what comes before them says nothing of
    /// their speed.
    first: OnceLock<(Instant, f64)>,
    said: Once,
}

impl Estimate {
    /// The clock starts with the first part heard.
    pub(crate) fn new(stage: &'static str, verbosity: Verbosity) -> Self {
        Self {
            stage,
            verbosity,
            first: OnceLock::new(),
            said: Once::new(),
        }
    }

    /// Hears which part is done, from 0 to 1.
    pub(crate) fn hear(&self, part: f64, bar: &ProgressBar) {
        let &(start, first_part) = self.first.get_or_init(|| (Instant::now(), part));
        let elapsed_s = start.elapsed().as_secs_f64();
        if elapsed_s < WATCHED_S || part <= first_part || self.verbosity == Verbosity::Quiet {
            return;
        }
        self.said.call_once(|| {
            let left_s = elapsed_s * (1.0 - part) / (part - first_part);
            if left_s > LONG_S {
                let text = format!("{:>11}  about {left_s:.0} s more", self.stage);
                bar.suspend(|| output::say(text));
            }
        });
    }
}
