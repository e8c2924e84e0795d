//! What pages and painter share: the scene as it is, and the newest picture of it.

use std::sync::Arc;
use std::sync::Condvar;
use std::sync::Mutex;
use std::sync::MutexGuard;
use std::sync::PoisonError;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;
use std::time::Duration;
use std::time::Instant;

use niji_picture::Scene;
use niji_picture::have_same_light;
use serde_json::Value;
use serde_json::json;

use super::document::Document;
use super::document::Refused;
use super::picture::Picture;

/// Parts of a picture that are told of, at most.
const PART_STEP: f64 = 0.02;

/// What is on the desk.
struct Papers {
    document: Document,
    /// Number of the scene as it is.
    revision: u64,
    picture: Option<Arc<Picture>>,
    /// What the plan of the last finished picture says.
    plan: Value,
    /// What is being made, and which part of it is done.
    progress: Option<(&'static str, f64)>,
    /// Why there is no picture.
    trouble: Option<String>,
    /// Number of what happened last.
    event: u64,
}

/// A place to work at, for any number of pages and one painter.
pub(super) struct Desk {
    papers: Mutex<Papers>,
    happened: Condvar,
    /// Number of the scene that is wanted: a picture of an older one is not finished.
    wanted: AtomicU64,
}

/// A scene to paint.
pub(super) struct Job {
    pub(super) revision: u64,
    pub(super) scene: Scene,
}

impl Desk {
    pub(super) fn new(document: Document) -> Self {
        let papers = Papers {
            document,
            revision: 1,
            picture: None,
            plan: Value::Null,
            progress: None,
            trouble: None,
            event: 1,
        };
        Self {
            papers: Mutex::new(papers),
            happened: Condvar::new(),
            wanted: AtomicU64::new(1),
        }
    }

    fn papers(&self) -> MutexGuard<'_, Papers> {
        self.papers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes something and tells whoever waits.
    fn note(&self, note: impl FnOnce(&mut Papers)) {
        let mut papers = self.papers();
        note(&mut papers);
        papers.event += 1;
        drop(papers);
        self.happened.notify_all();
    }

    /// Works on the document; a scene whose light is another is painted anew.
    ///
    /// # Errors
    /// As `work`, which then left the document as it was.
    pub(super) fn work<T>(
        &self,
        work: impl FnOnce(&mut Document) -> Result<T, Refused>,
    ) -> Result<T, Refused> {
        let mut outcome = Err(Refused::because("not done"));
        self.note(|papers| {
            let (before, text) = (papers.document.scene(), papers.document.text().to_owned());
            outcome = work(&mut papers.document);
            if papers.document.text() != text {
                papers.revision += 1;
            }
            if !have_same_light(&before, &papers.document.scene()) {
                self.wanted.store(papers.revision, Ordering::Release);
                papers.progress = Some(("plan", 0.0));
            }
        });
        outcome
    }

    /// The document, and the number of its scene.
    pub(super) fn look<T>(&self, look: impl FnOnce(&Document, u64) -> T) -> T {
        let papers = self.papers();
        look(&papers.document, papers.revision)
    }

    /// The newest picture.
    pub(super) fn picture(&self) -> Option<Arc<Picture>> {
        self.papers().picture.clone()
    }

    /// Whether a scene is no longer wanted.
    pub(super) fn is_stale(&self, revision: u64) -> bool {
        self.wanted.load(Ordering::Acquire) != revision
    }

    /// The scene that is wanted, as soon as it is another than `done`.
    pub(super) fn job(&self, done: u64) -> Job {
        let waiting = |_: &mut Papers| !self.is_stale(done);
        let papers = self.happened.wait_while(self.papers(), waiting);
        let papers = papers.unwrap_or_else(PoisonError::into_inner);
        Job {
            revision: self.wanted.load(Ordering::Acquire),
            scene: papers.document.scene(),
        }
    }

    /// Waits whether a scene stays wanted for a time.
    pub(super) fn rests(&self, revision: u64, time: Duration) -> bool {
        let waiting = |_: &mut Papers| !self.is_stale(revision);
        let waited = self
            .happened
            .wait_timeout_while(self.papers(), time, waiting);
        drop(waited);
        !self.is_stale(revision)
    }

    /// Hears which part of a picture is done.
    pub(super) fn hear(&self, what: &'static str, part: f64) {
        let is_news = |papers: &Papers| match papers.progress {
            Some((known, before)) => known != what || (part - before).abs() >= PART_STEP,
            None => true,
        };
        if is_news(&self.papers()) {
            self.note(|papers| papers.progress = Some((what, part)));
        }
    }

    /// Takes a picture, a finished one with what its plan says.
    pub(super) fn show(&self, picture: Picture, plan: Option<Value>) {
        self.note(|papers| {
            let is_last = picture.is_finished;
            papers.picture = Some(Arc::new(picture));
            papers.plan = plan.unwrap_or(papers.plan.take());
            papers.trouble = None;
            if is_last {
                papers.progress = None;
            }
        });
    }

    /// Says why there is no picture.
    pub(super) fn say(&self, trouble: String) {
        self.note(|papers| {
            papers.trouble = Some(trouble);
            papers.progress = None;
        });
    }

    /// What there is to know, as soon as anything happened after an event, or after a time.
    pub(super) fn news(&self, after: u64, time: Duration) -> Value {
        let end = Instant::now() + time;
        let mut papers = self.papers();
        while papers.event <= after {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            let waited = self.happened.wait_timeout(papers, left);
            papers = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        json!({
            "event": papers.event,
            "revision": papers.revision,
            "picture": papers.picture.as_ref().map(|picture| picture.about()),
            "progress": papers.progress,
            "trouble": papers.trouble,
            "plan": papers.plan,
        })
    }
}
