//! The graph of a job, the same for every engine:
//!
//! ```text
//! tables ──► frames ────────────► check      a sequence
//!        └─► tiles ──► merge ──► check       a picture, or each frame of a sequence, in tiles
//! ```
//! A step is one command of this program, run once for every chunk of its frames times every chunk of its tiles.
//! What an engine knows by another name (paths, the task's own frames) stands in it as a [`Word`]; nothing here
//! knows an engine.

use std::fmt;

use serde::Serialize;

use crate::choice_file;
use crate::frame_list::FrameList;

/// Frames that a task puts together from tiles: each takes seconds.
const MERGED_FRAMES: usize = 10;

/// The step that decides for all frames and makes what they share.
pub(super) const TABLES: &str = "tables";

/// A word of a command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Word {
    /// As it stands.
    Text(String),
    /// The scene file.
    Scene,
    /// The folder of the pictures.
    Out,
    /// A file in that folder.
    Inside(&'static str),
    /// The frames of the task.
    Frames,
    /// The tiles of the task, of so many.
    TilesOf(u32),
    /// The threads that the task has.
    Threads,
}

/// Numbers that tasks share out, in order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Shares {
    /// All of them.
    pub(super) all: FrameList,
    /// How many a task has at most.
    pub(super) most: usize,
}

/// When a step begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Begins {
    /// At once.
    AtOnce,
    /// When every task of the step succeeded.
    AfterSuccess(&'static str),
    /// When every task of the step has ended, however: it says itself what it misses.
    AfterEnd(&'static str),
}

/// One command, run for every chunk of frames times every chunk of tiles.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Step {
    /// Its name.
    pub(super) name: &'static str,
    /// When it begins.
    pub(super) begins: Begins,
    /// Its frames, where tasks share them out.
    pub(super) frames: Option<Shares>,
    /// Its tiles, where tasks share them out.
    pub(super) tiles: Option<Shares>,
    /// What follows the name of the program.
    pub(super) command: Vec<Word>,
}

/// What is to be made.
#[derive(Clone, Debug)]
pub(super) struct Request<'a> {
    /// The frames of a sequence.
    pub(super) frames: Option<&'a FrameList>,
    /// The tiles of each picture.
    pub(super) n_tiles: Option<u32>,
    /// Frames, or tiles of one, that a task has at most.
    pub(super) chunk: usize,
    /// Flags of every `niji run`.
    pub(super) flags: &'a [String],
    /// Whether what is there of another request is made anew.
    pub(super) replaces: bool,
}

impl Shares {
    /// Tasks it takes.
    pub(super) fn n_tasks(&self) -> usize {
        self.all.len().div_ceil(self.most)
    }

    /// What each task has.
    pub(super) fn lists(&self) -> Vec<FrameList> {
        let numbers: Vec<u32> = self.all.iter().collect();
        let chunks = numbers.chunks(self.most);
        chunks
            .map(|chunk| FrameList::of(chunk.iter().copied()))
            .collect()
    }
}

impl Step {
    /// Tasks of this step.
    pub(super) fn n_tasks(&self) -> usize {
        let of = |shares: &Option<Shares>| shares.as_ref().map_or(1, Shares::n_tasks);
        of(&self.frames) * of(&self.tiles)
    }
}

impl Begins {
    /// The step that is waited for.
    pub(super) fn after(self) -> Option<&'static str> {
        match self {
            Self::AtOnce => None,
            Self::AfterSuccess(step) | Self::AfterEnd(step) => Some(step),
        }
    }
}

impl Request<'_> {
    /// The steps, in order.
    pub(super) fn steps(&self) -> Vec<Step> {
        let frames = |most: usize| {
            let all = self.frames.cloned()?;
            Some(Shares { all, most })
        };
        let Some(n_tiles) = self.n_tiles else {
            let frames = Step {
                name: "frames",
                begins: Begins::AfterSuccess(TABLES),
                frames: frames(self.chunk),
                tiles: None,
                command: self.run(&[frames_of_task(), chosen()].concat()),
            };
            return vec![self.tables(), frames, check("frames")];
        };
        let of_task = self.frames.map_or(Vec::new(), |_| frames_of_task());
        let flags = [
            of_task.clone(),
            vec![text("--tiles"), Word::TilesOf(n_tiles)],
            chosen(),
        ];
        let tiles = Step {
            name: "tiles",
            begins: Begins::AfterSuccess(TABLES),
            frames: frames(1),
            tiles: Some(Shares {
                all: FrameList::of(1..=n_tiles),
                most: self.chunk.min(n_tiles as usize),
            }),
            command: self.run(&flags.concat()),
        };
        let merge = Step {
            name: "merge",
            // A tile that failed keeps no other picture from being put together.
            begins: Begins::AfterEnd("tiles"),
            frames: frames(MERGED_FRAMES),
            tiles: None,
            command: self.forced([vec![text("merge"), Word::Out], of_task].concat()),
        };
        vec![self.tables(), tiles, merge, check("merge")]
    }

    fn tables(&self) -> Step {
        let frames = self.frames.iter();
        let mut flags: Vec<Word> = frames
            .flat_map(|all| [text("--frames"), text(&all.to_string())])
            .collect();
        flags.extend([text("--until"), text(TABLES)]);
        Step {
            name: TABLES,
            begins: Begins::AtOnce,
            frames: None,
            tiles: None,
            command: self.run(&flags),
        }
    }

    /// `niji run SCENE -o OUT` with flags.
    fn run(&self, flags: &[Word]) -> Vec<Word> {
        let mut words = vec![text("run"), Word::Scene, text("-o"), Word::Out];
        words.extend(self.flags.iter().map(|flag| text(flag)));
        words.extend_from_slice(flags);
        words.extend([text("--threads"), Word::Threads]);
        self.forced(words)
    }

    fn forced(&self, mut words: Vec<Word>) -> Vec<Word> {
        words.extend(self.replaces.then(|| text("--force")));
        words
    }
}

fn check(after: &'static str) -> Step {
    Step {
        name: "check",
        begins: Begins::AfterEnd(after),
        frames: None,
        tiles: None,
        command: vec![text("farm"), text("status"), Word::Out],
    }
}

fn frames_of_task() -> Vec<Word> {
    vec![text("--frames"), Word::Frames]
}

fn chosen() -> Vec<Word> {
    vec![text("--choice"), Word::Inside(choice_file::FILE)]
}

fn text(word: &str) -> Word {
    Word::Text(word.to_owned())
}

impl fmt::Display for Word {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => write!(out, "{text}"),
            Self::Scene => write!(out, "SCENE"),
            Self::Out => write!(out, "DIR"),
            Self::Inside(file) => write!(out, "DIR/{file}"),
            Self::Frames => write!(out, "FRAMES"),
            Self::TilesOf(n_tiles) => write!(out, "TILES/{n_tiles}"),
            Self::Threads => write!(out, "THREADS"),
        }
    }
}

impl fmt::Display for Step {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shares = |shares: &Option<Shares>, what: &str| {
            let shares = shares.as_ref();
            shares.map(|it| format!("{} {what} by {}", it.all.len(), it.most.min(it.all.len())))
        };
        let of: Vec<String> = [shares(&self.frames, "frames"), shares(&self.tiles, "tiles")]
            .into_iter()
            .flatten()
            .collect();
        let begins = match self.begins {
            Begins::AtOnce => String::new(),
            Begins::AfterSuccess(step) => format!("after {step}"),
            Begins::AfterEnd(step) => format!("when {step} ended"),
        };
        write!(
            out,
            "{:<7} {:>7} {:<40} {begins:<18} niji",
            self.name,
            match self.n_tasks() {
                1 => "1 task".to_owned(),
                n_tasks => format!("{n_tasks} tasks"),
            },
            of.join(" x ")
        )?;
        self.command
            .iter()
            .try_for_each(|word| write!(out, " {word}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(frames: Option<&str>, n_tiles: Option<u32>, chunk: usize) -> Vec<Step> {
        let frames = frames.map(|it| FrameList::parse(it).unwrap());
        let request = Request {
            frames: frames.as_ref(),
            n_tiles,
            chunk,
            flags: &[],
            replaces: false,
        };
        request.steps()
    }

    #[test]
    fn tasks_share_out_every_number_once_and_in_order() {
        for (text, most) in [("1-240", 20), ("1-3,7,10-20:2", 4), ("5", 3), ("1-7", 7)] {
            let all = FrameList::parse(text).unwrap();
            let shares = Shares {
                all: all.clone(),
                most,
            };
            let lists = shares.lists();
            assert_eq!(lists.len(), shares.n_tasks());
            assert!(lists.iter().all(|list| (1..=most).contains(&list.len())));
            assert!(
                lists.iter().flat_map(FrameList::iter).eq(all.iter()),
                "{text}"
            );
        }
    }

    #[test]
    fn a_step_begins_after_one_that_stands_before_it() {
        for (frames, n_tiles) in [
            (Some("1-12"), None),
            (Some("1-12"), Some(8)),
            (None, Some(8)),
        ] {
            let steps = steps(frames, n_tiles, 3);
            for (index, step) in steps.iter().enumerate() {
                let before = steps[..index].last().map(|it| it.name);
                assert_eq!(step.begins.after(), before, "{step}");
            }
            assert_eq!(steps.last().map(|it| it.name), Some("check"));
        }
    }

    #[test]
    fn tasks_are_counted_by_frames_and_tiles() {
        let n_tasks = |frames, n_tiles, chunk| -> Vec<usize> {
            let steps = steps(frames, n_tiles, chunk);
            steps.iter().map(Step::n_tasks).collect()
        };
        assert_eq!(n_tasks(Some("1-12"), None, 3), [1, 4, 1]);
        assert_eq!(n_tasks(Some("1-12"), Some(8), 3), [1, 12 * 3, 2, 1]);
        assert_eq!(n_tasks(None, Some(8), 100), [1, 1, 1, 1]);
        assert_eq!(n_tasks(Some("1-10000"), Some(64), 1)[1], 640_000);
    }
}
