//! Frames as the command line has them: `12`, `1-240`, `1-3,7,10-20:2`.

use std::ops::RangeInclusive;

use niji_scene::LAST_FRAME;

/// Frames by number, in ascending order.
#[derive(Clone, Debug, PartialEq, Eq)]
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

    /// Its frames.
    pub(crate) fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        let parts = self.parts.iter();
        parts.flat_map(|it| it.range.clone().step_by(it.step))
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
