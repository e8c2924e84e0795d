//! When a frame of a sequence is shown, as EXR has it: `framesPerSecond` and `timeCode`.
//!
//! frame = ((60 h + m) 60 + s) N + f,   0 <= f < N
//! `N` frames of a second, whole: rates a thousandth below one, as 23.976 = 24000/1001, count by it, and drop none.
//! h begins again after 24 hours. There is no code above 30 frames per second: the format has no room for it.
//! [12M] SMPTE ST 12-1, time and control code.

use exr::meta::attribute::TimeCode;

use crate::attributes::AttributeValue;
use crate::attributes::Attributes;

/// Name of the rate among attributes, a number.
pub(crate) const FRAMES_PER_SECOND: &str = "framesPerSecond";

/// Name of the code among attributes, the text `HH:MM:SS:FF`.
pub(crate) const TIME_CODE: &str = "timeCode";

/// Most frames of a second that a code counts.
const MOST_COUNTED: u32 = 30;

/// What is N/1.001, to this part.
const ROUNDOFF: f64 = 2e-5;

/// A frame and how many are shown in a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameTime {
    /// Its number.
    pub frame: u32,
    /// Frames of a second, above 0.
    pub frames_per_second: f64,
}

impl FrameTime {
    /// The attributes that say so.
    #[must_use]
    pub fn attributes(self) -> Attributes {
        let rate = AttributeValue::Number(self.frames_per_second);
        let mut attributes = Attributes::from([(FRAMES_PER_SECOND.to_owned(), rate)]);
        let n = self.frames_per_second.ceil() as u32;
        if (1..=MOST_COUNTED).contains(&n) {
            let seconds = self.frame / n;
            let (hours, minutes) = (seconds / 3600 % 24, seconds / 60 % 60);
            let code = format!(
                "{hours:02}:{minutes:02}:{:02}:{:02}",
                seconds % 60,
                self.frame % n
            );
            attributes.insert(TIME_CODE.to_owned(), AttributeValue::Text(code));
        }
        attributes
    }
}

/// A rate as a fraction.
pub(crate) fn fraction(frames_per_second: f64) -> (i32, u32) {
    let n = frames_per_second.ceil();
    let is_slowed = (frames_per_second * 1001.0 / (1000.0 * n) - 1.0).abs() < ROUNDOFF;
    if is_slowed {
        return (1000 * n as i32, 1001);
    }
    if frames_per_second.fract() == 0.0 {
        return (frames_per_second as i32, 1);
    }
    ((1000.0 * frames_per_second).round() as i32, 1000)
}

/// A code as the format has it; `None` of a text that is none.
pub(crate) fn time_code(text: &str) -> Option<TimeCode> {
    let numbers: Option<Vec<u8>> = text.split(':').map(|it| it.parse().ok()).collect();
    let [hours, minutes, seconds, frame] = numbers?.try_into().ok()?;
    Some(TimeCode {
        hours,
        minutes,
        seconds,
        frame,
        ..TimeCode::default()
    })
}

/// A code as a text.
pub(crate) fn time_code_text(code: &TimeCode) -> String {
    let TimeCode {
        hours,
        minutes,
        seconds,
        frame,
        ..
    } = code;
    format!("{hours:02}:{minutes:02}:{seconds:02}:{frame:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(frame: u32, frames_per_second: f64) -> Option<String> {
        let time = FrameTime {
            frame,
            frames_per_second,
        };
        match time.attributes().remove(TIME_CODE)? {
            AttributeValue::Text(text) => Some(text),
            AttributeValue::Number(_) => None,
        }
    }

    #[test]
    fn codes_count_frames_within_seconds_and_begin_again_after_a_day() {
        let is = |text: &str| Some(text.to_owned());
        assert_eq!(code(0, 24.0), is("00:00:00:00"));
        assert_eq!(code(23, 24.0), is("00:00:00:23"));
        assert_eq!(code(24, 24.0), is("00:00:01:00"));
        assert_eq!(code(86_400 * 25 + 7, 25.0), is("00:00:00:07"));
        // Non-drop: an hour of it has as many frames as one of 30.
        assert_eq!(code(3600 * 30, 29.97), is("01:00:00:00"));
        assert_eq!(code(10, 60.0), None);
        let whole = time_code("01:02:03:04").unwrap();
        assert_eq!(time_code_text(&whole), "01:02:03:04");
        assert_eq!((whole.hours, whole.frame), (1, 4));
        assert_eq!(time_code("1:2:3"), None);
    }

    #[test]
    fn rates_of_television_are_their_fractions() {
        for (rate, expected) in [
            (24.0, (24, 1)),
            (23.976, (24_000, 1001)),
            (29.97, (30_000, 1001)),
            (59.94, (60_000, 1001)),
            (12.5, (12_500, 1000)),
        ] {
            assert_eq!(fraction(rate), expected, "{rate}");
        }
    }
}
