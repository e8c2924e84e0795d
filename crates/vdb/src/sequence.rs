//! Sequences of files, one a frame: `rain.####.vdb` stands for `rain.0001.vdb`, `rain.0002.vdb` …
//!
//! A run of `#` stands for the frame number with at least so many digits, zeros in front. Nothing
//! here looks at the disc: what is there is told by the caller.

use std::ffi::OsStr;
use std::path::Path;
use std::path::PathBuf;

/// Stands for a digit of the frame number.
const DIGIT: char = '#';

/// The names of a sequence of files in one folder.
///
/// ```
/// use std::path::Path;
/// use niji_vdb::FrameSequence;
///
/// let rain = FrameSequence::new(Path::new("shots/rain.####.vdb")).expect("it has a run of #");
/// assert_eq!(rain.path(7), Path::new("shots/rain.0007.vdb"));
/// let listing = ["rain.0012.vdb", "rain.0007.vdb", "fog.0001.vdb", "rain.12.vdb"];
/// assert_eq!(rain.frames(listing), [7, 12]);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameSequence {
    folder: PathBuf,
    before: String,
    n_digits: usize,
    after: String,
}

impl FrameSequence {
    /// The sequence that a pattern stands for; `None` if its file name has no `#`, or is not
    /// Unicode. Of several runs of `#` the last one is the number.
    pub fn new(pattern: &Path) -> Option<Self> {
        let name = pattern.file_name()?.to_str()?;
        let end = name.rfind(DIGIT)? + DIGIT.len_utf8();
        let before = name[..end].trim_end_matches(DIGIT);
        Some(Self {
            folder: pattern.parent().unwrap_or(Path::new("")).to_owned(),
            before: before.to_owned(),
            n_digits: end - before.len(),
            after: name[end..].to_owned(),
        })
    }

    /// The folder that holds the files; empty for the current one.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The file of a frame.
    pub fn path(&self, frame: u32) -> PathBuf {
        let Self {
            before,
            n_digits,
            after,
            ..
        } = self;
        self.folder
            .join(format!("{before}{frame:0n_digits$}{after}"))
    }

    /// The frame whose file has that name (without a folder), if it is one of the sequence.
    pub fn frame(&self, name: &OsStr) -> Option<u32> {
        let name = name.to_str()?;
        let digits = name
            .strip_prefix(self.before.as_str())?
            .strip_suffix(self.after.as_str())?;
        let as_written = digits.len() == self.n_digits
            || digits.len() > self.n_digits && !digits.starts_with('0');
        let plain = digits.bytes().all(|byte| byte.is_ascii_digit());
        (as_written && plain).then(|| digits.parse().ok())?
    }

    /// The frames whose files are in the listing of a folder, in rising order.
    pub fn frames<N: AsRef<OsStr>>(&self, names: impl IntoIterator<Item = N>) -> Vec<u32> {
        let frames = names.into_iter();
        let mut frames = frames
            .filter_map(|name| self.frame(name.as_ref()))
            .collect::<Vec<_>>();
        frames.sort_unstable();
        frames.dedup();
        frames
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sequence(pattern: &str) -> FrameSequence {
        FrameSequence::new(Path::new(pattern)).expect("a run of #")
    }

    fn name(sequence: &FrameSequence, frame: u32) -> String {
        sequence.path(frame).to_string_lossy().into_owned()
    }

    #[test]
    fn frames_are_padded_with_zeros_and_grow_beyond_the_padding() {
        let rain = sequence("a/b/rain.####.vdb");
        assert_eq!(rain.folder(), Path::new("a/b"));
        assert_eq!(name(&rain, 0), "a/b/rain.0000.vdb");
        assert_eq!(name(&rain, 123), "a/b/rain.0123.vdb");
        assert_eq!(name(&rain, 123_456), "a/b/rain.123456.vdb");
        assert_eq!(name(&sequence("#"), u32::MAX), u32::MAX.to_string());
        assert_eq!(name(&sequence("take#2.##.vdb"), 5), "take#2.05.vdb");
    }

    #[test]
    fn every_name_gives_back_its_frame() {
        for pattern in ["rain.####.vdb", "#.vdb", "rain##", "1###1"] {
            let sequence = sequence(pattern);
            for frame in [0, 1, 9, 10, 99, 9999, 10_000, u32::MAX] {
                assert_eq!(
                    sequence.frame(OsStr::new(&name(&sequence, frame))),
                    Some(frame),
                    "{pattern}"
                );
            }
        }
    }

    #[test]
    fn names_that_the_pattern_does_not_write_are_of_no_frame() {
        let rain = sequence("rain.###.vdb");
        for other in [
            "rain.vdb",
            "rain..vdb",
            "rain.07.vdb",
            "rain.0007.vdb",
            "rain.+07.vdb",
            "rain.-07.vdb",
            "rain.7a7.vdb",
            "rain.٠٠٧.vdb",
            "rain.007.vdb.part",
            "a/rain.007.vdb",
            "rain.4294967296.vdb",
            "rain.###.vdb",
        ] {
            assert_eq!(rain.frame(OsStr::new(other)), None, "{other}");
        }
        // Before and after share the 1: a name is not read twice.
        assert_eq!(sequence("a1#1").frame(OsStr::new("a1")), None);
    }

    #[test]
    fn a_listing_in_any_order_gives_its_frames_in_order() {
        let listing = [
            "rain.010.vdb",
            "mist.001.vdb",
            "rain.002.vdb",
            "rain.1000.vdb",
        ];
        assert_eq!(sequence("rain.###.vdb").frames(listing), [2, 10, 1000]);
        assert_eq!(sequence("rain.###.vdb").frames::<&str>([]), []);
    }

    #[test]
    fn a_name_without_a_number_sign_is_no_sequence() {
        for pattern in ["rain.vdb", "", "/", "shot#1/rain.vdb", ".."] {
            assert_eq!(FrameSequence::new(Path::new(pattern)), None, "{pattern}");
        }
    }
}
