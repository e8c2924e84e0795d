//! Which frames a sequence has, and which of them tell what all call for.
//!
//! It goes from the first frame with a written value to the last; where files are numbered it has the frames of which
//! all of them are there. What changes does so between written values, and most from one end to the other: looked at
//! are first and last, those at the quarters of the way, those with written values, and the one with the largest files,
//! evenly thinned to seven.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use niji_scene::LAST_FRAME;
use niji_scene::Sequence;
use niji_scene::with_frame;

/// Most frames that are looked at.
const MOST: usize = 7;

/// Parts of the way from the first frame to the last.
const PARTS: usize = 4;

/// Most frames whose angles are asked for.
const MOST_BETWEEN: usize = 64;

/// The frames of a sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SequenceFrames {
    frames: Vec<u32>,
    /// Those that are likely to show most.
    telling: BTreeSet<u32>,
}

impl SequenceFrames {
    /// Those of a sequence whose files lie in `folder`.
    pub(crate) fn of(sequence: &Sequence, folder: &Path) -> Self {
        let keys = sequence.keys();
        let names: BTreeSet<&str> = sequence.file_names().collect();
        let numbered = names.iter().map(|name| numbers(name, folder));
        let frames: Vec<u32> = match numbered.reduce(|a, b| &a & &b) {
            Some(numbers) => numbers.into_iter().collect(),
            None => match (keys.first(), keys.last()) {
                (Some(first), Some(last)) => (*first..=*last).collect(),
                _ => Vec::new(),
            },
        };
        let bytes = |frame: &&u32| -> u64 {
            let files = names
                .iter()
                .map(|name| folder.join(with_frame(name, **frame)));
            files
                .map(|file| fs::metadata(file).map_or(0, |it| it.len()))
                .sum()
        };
        let largest = frames
            .iter()
            .max_by_key(bytes)
            .filter(|_| !names.is_empty());
        let mut telling: BTreeSet<u32> = thinned(&frames, PARTS + 1).into_iter().collect();
        telling.extend(keys.into_iter().filter(|key| frames.contains(key)));
        telling.extend(largest);
        Self { frames, telling }
    }

    /// The frames to look at.
    pub(crate) fn to_look_at(&self) -> Vec<u32> {
        let telling: Vec<u32> = self.telling.iter().copied().collect();
        thinned(&telling, MOST)
    }

    /// Some of all frames.
    pub(crate) fn between(&self) -> Vec<u32> {
        thinned(&self.frames, MOST_BETWEEN)
    }
}

/// So many at most, evenly, first and last among them.
fn thinned(frames: &[u32], most: usize) -> Vec<u32> {
    let last = frames.len().saturating_sub(1);
    if last < most {
        return frames.to_vec();
    }
    let places = (0..most).map(|it| it * last / (most - 1));
    places.map(|place| frames[place]).collect()
}

/// The frames of which a file is there, whose name has `#` in place of digits.
fn numbers(name: &str, folder: &Path) -> BTreeSet<u32> {
    // The first part of the path with digits tells them, the whole path whether the file is there.
    let start = name.find('#').unwrap_or(name.len());
    let part = name[..start].rfind('/').map_or(0, |slash| slash + 1);
    let end = name[start..]
        .find('/')
        .map_or(name.len(), |slash| start + slash);
    let (before, after) = (&name[part..start], name[start..end].trim_start_matches('#'));
    let place = folder.join(&name[..part]);
    let place = if place.as_os_str().is_empty() {
        Path::new(".")
    } else {
        &place
    };
    let entries = fs::read_dir(place).into_iter().flatten().flatten();
    let number = |entry: fs::DirEntry| {
        let entry = entry.file_name().into_string().ok()?;
        let rest = entry.strip_prefix(before)?;
        let n_digits = rest.bytes().take_while(u8::is_ascii_digit).count();
        let number: u32 = rest[..n_digits].parse().ok()?;
        let is_ours = after.contains('#') || rest[n_digits..] == *after;
        let is_there = || folder.join(with_frame(name, number)).exists();
        (is_ours && number <= LAST_FRAME && is_there()).then_some(number)
    };
    entries.filter_map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sequence(sections: &str) -> Sequence {
        let text = format!("[sun]\nelevation_deg = 20.0\n{sections}");
        Sequence::from_toml(&text).unwrap().unwrap()
    }

    #[test]
    fn ends_quarters_and_written_values_are_looked_at_seven_at_most() {
        let of = |keys: &str| {
            let text = format!("[sequence]\nsun.elevation_deg = {keys}\n");
            SequenceFrames::of(&sequence(&text), Path::new("")).to_look_at()
        };
        assert_eq!(of("[[1, 1.0], [240, 2.0]]"), [1, 60, 120, 180, 240]);
        assert_eq!(
            of("[[1, 1.0], [70, 3.0], [240, 2.0]]"),
            [1, 60, 70, 120, 180, 240]
        );
        assert_eq!(of("[[5, 1.0]]"), [5]);
        let many: Vec<String> = (1..=50).map(|it| format!("[{}, 0.0]", 10 * it)).collect();
        let many = of(&format!("[{}]", many.join(", ")));
        assert_eq!((many.len(), many[0], many[6]), (7, 10, 500));
    }

    #[test]
    fn numbered_files_tell_the_frames_and_the_largest_is_looked_at() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sim")).unwrap();
        for (number, bytes) in [
            (3, 1),
            (4, 1),
            (5, 1),
            (6, 9),
            (7, 1),
            (8, 1),
            (9, 1),
            (10, 1),
        ] {
            fs::write(at(&format!("sim/smoke.{number:04}.vdb")), vec![0; bytes]).unwrap();
        }
        for other in [
            "smoke.0011.vdb.part",
            "smoke.vdb",
            "fire.0012.vdb",
            "smoke.12.vdb",
        ] {
            fs::write(at(&format!("sim/{other}")), "").unwrap();
        }
        let drops = sequence("[drops]\nfile = \"sim/smoke.####.vdb\"\n");
        let frames = SequenceFrames::of(&drops, folder.path());
        assert_eq!(frames.between(), [3, 4, 5, 6, 7, 8, 9, 10]);
        assert_eq!(frames.to_look_at(), [3, 4, 6, 8, 10]);
    }
}
