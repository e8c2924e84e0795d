//! Frames as the command line has them: `12`, `1-240`, `1-3,7,10-20:2`.

use std::fmt;
use std::ops::RangeInclusive;

use niji_scene::LAST_FRAME;
use serde::Deserialize;
use serde::Serialize;

/// Frames by number, in ascending order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub(crate) struct FrameList {
    parts: Vec<Part>,
}

/// every n-th frame of a range; its end is one of them.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Part {
    range: RangeInclusive<u32>,
    step: usize,
}

impl FrameList {
    /// Reads a list.
    ///
    /// # Errors
    /// What was found instead, a frame that is there twice among them.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let parts = text.split(',').map(Part::parse);
        let parts = parts.collect::<Option<Vec<_>>>().filter(|parts| {
            let mut pairs = parts.windows(2);
            pairs.all(|pair| pair[0].range.end() < pair[1].range.start())
        });
        parts.map(|parts| Self { parts }).ok_or_else(|| {
            format!(
                "found {text:?}, expected frames in ascending order, none of them twice, \
                 say 12, 1-240 or 1-3,7,10-20:2"
            )
        })
    }

    /// Frames in any order, written as briefly as even steps allow.
    pub(crate) fn of(numbers: impl IntoIterator<Item = u32>) -> Self {
        let mut numbers: Vec<u32> = numbers.into_iter().collect();
        numbers.sort_unstable();
        numbers.dedup();
        let (mut rest, mut parts) = (&numbers[..], Vec::new());
        while let [first, ..] = *rest {
            let step = rest.get(1).map_or(1, |second| second - first);
            let is_even = |pair: &&[u32]| pair[1] - pair[0] == step;
            let n = 1 + rest.windows(2).take_while(is_even).count();
            // Of two frames a step says nothing.
            let n = if n == 2 && step > 1 { 1 } else { n };
            parts.push(Part {
                range: first..=rest[n - 1],
                step: if n == 1 { 1 } else { step as usize },
            });
            rest = &rest[n..];
        }
        Self { parts }
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        let parts = self.parts.iter();
        parts
            .map(|it| it.range.clone().count().div_ceil(it.step))
            .sum()
    }

    /// Its frames.
    pub(crate) fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        let parts = self.parts.iter();
        parts.flat_map(|it| it.range.clone().step_by(it.step))
    }
}

impl fmt::Display for FrameList {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, Part { range, step }) in self.parts.iter().enumerate() {
            let comma = if index == 0 { "" } else { "," };
            match (range.start(), range.end(), step) {
                (first, last, _) if first == last => write!(out, "{comma}{first}")?,
                (first, last, 1) => write!(out, "{comma}{first}-{last}")?,
                (first, last, step) => write!(out, "{comma}{first}-{last}:{step}")?,
            }
        }
        Ok(())
    }
}

/// In files a list may be empty.
impl TryFrom<String> for FrameList {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        if text.is_empty() {
            return Ok(Self::of([]));
        }
        Self::parse(&text)
    }
}

impl From<FrameList> for String {
    fn from(list: FrameList) -> Self {
        list.to_string()
    }
}

impl Part {
    fn parse(text: &str) -> Option<Self> {
        let (range, step) = text.split_once(':').unwrap_or((text, "1"));
        let number = |text: &str| text.trim().parse::<u32>().ok();
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        let (first, last) = (number(first)?, number(last)?);
        let step = number(step).filter(|step| *step > 0)?;
        let is_range = first <= last && last <= LAST_FRAME && (step == 1 || range.contains('-'));
        is_range.then(|| Self {
            range: first..=last - (last - first) % step,
            step: step as usize,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_read_as_people_type_them() {
        let frames = |text| FrameList::parse(text).unwrap().iter().collect::<Vec<_>>();
        assert_eq!(frames(" 12 "), [12]);
        assert_eq!(frames("0-0"), [0]);
        assert_eq!(frames("1-4"), [1, 2, 3, 4]);
        assert_eq!(
            frames("1-3, 7,10-20:2"),
            [1, 2, 3, 7, 10, 12, 14, 16, 18, 20]
        );
        // The end of a range may lie between its frames.
        assert_eq!(frames("1-6:4,6"), [1, 5, 6]);
    }

    #[test]
    fn frames_are_written_briefly_and_read_back() {
        for (numbers, text) in [
            (&[12][..], "12"),
            (&[7, 3, 1, 2, 3], "1-3,7"),
            (&[1, 2, 3, 7, 10, 15, 20], "1-3,7,10-20:5"),
            (&[1, 2, 5, 9], "1-2,5,9"),
            (&[4, 6], "4,6"),
        ] {
            let list = FrameList::of(numbers.iter().copied());
            assert_eq!(list.to_string(), text);
            assert_eq!(FrameList::parse(text), Ok(list.clone()));
            assert_eq!(list.len(), list.iter().count(), "{text}");
        }
        assert_eq!(FrameList::try_from(String::new()), Ok(FrameList::of([])));
    }

    #[test]
    fn what_is_no_list_or_has_a_frame_twice_is_refused() {
        for text in [
            "",
            "-",
            "3-",
            "-3",
            "5-4",
            "1-2-3",
            "a",
            "1.5",
            "1-99999999",
            "1,",
            "1,1",
            "1-5,3",
            "7,1-3",
            "1-5:0",
            "1-5:",
            "3:2",
        ] {
            let refused = FrameList::parse(text).unwrap_err();
            assert!(
                refused.contains("ascending") && refused.contains("1-3,7,10-20:2"),
                "{refused}"
            );
        }
    }
}
