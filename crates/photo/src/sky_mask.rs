//! The sky of a photograph, by color, sharpness, place and connection to the top edge.
//!
//! A border down each column is a first guess ([`sky_border`](crate::sky_border), SW13); the colors and places above
//! and below it then decide pixel by pixel ([`likeness`](crate::sky_colors), BJ01, KK11), twice more from what they
//! found. What is connected to the top edge is sky, and what looks like it through holes above the lowest
//! border. Columns that are covered from the top, by a branch, say, guess nothing. All this happens on a picture of at
//! most 640 pixels; joint bilateral upsampling (KCLU07) carries it to the photograph.
//!
//! The confidence is the product of what speaks for a sky, each 0..1: how much of the top edge it has, how much of its
//! edge is sharp, how much smoother it is than the ground, and that it is brighter or bluer than that.
//!
//! A pixel that somebody points at is sky, and so is what has its color around it. Where no sure sky holds it already,
//! the border lies below it, and colors follow from it. Where that goes on to the top edge it is a sky however little
//! else speaks for it, unless without it one is found that is surer.

use ndarray::Array2;
use ndarray::Zip;

use crate::error::Error;
use crate::joint_bilateral::upsample_labels;
use crate::linear_picture::LinearPicture;
use crate::perceptual::oklab;
use crate::sky_border::mean_of_nine;
use crate::sky_border::sharpness;
use crate::sky_border::sky_border;
use crate::sky_colors::likeness;

/// Longest side on which the sky is looked for, pixels.
const LONGEST: usize = 640;
/// Part of the pixels that are darker than white.
const BELOW_WHITE: f64 = 0.99;
/// Times that colors decide.
const N_FITS: usize = 3;
/// Part of the columns whose border lies above the lowest that counts.
const ABOVE_LOWEST: f64 = 0.85;
/// Border above which a column is covered, as part of the lowest.
const COVERED: f64 = 0.3;
/// What is guessed below the border but above the lowest, where the sky may show through.
const THROUGH: f32 = -0.5;
/// Log ratio from which a hole shows the sky.
const HOLE: f32 = 0.5;
/// Where each sign of a sky says nothing for it, and where all: parts of the top edge and of its own, roughness over
/// that of the ground, difference of color (Oklab). Skies of plates have 0.75 to 1, 0.84 to 1, 0.02 to 0.38 and 0.16
/// to 0.43; rooms and thickets roughness from 0.52 on.
const TOP: (f64, f64) = (0.05, 0.3);
const EDGE: (f64, f64) = (0.2, 0.7);
const SMOOTHER: (f64, f64) = (0.4, 0.55);
const COLOR: (f64, f64) = (0.0, 0.1);
/// Difference of color (Oklab) from a pixel that is sky, and from pixel to pixel, up to which its surroundings are.
const OF_POINTED: f32 = 0.1;
const TO_NEXT: f32 = 0.03;
/// What is guessed of a pixel that is known to be sky: more than any color says.
const KNOWN: f32 = 20.0;
/// Sharpness of an edge over that of the sky.
const SHARP_EDGE: f64 = 2.0;
/// Confidence below which there may be no sky at all.
pub const SURE_OF_SKY: f64 = 0.3;

/// The sky of a photograph.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyMask {
    /// Which pixels are sky, by row and column.
    pub is_sky: Array2<bool>,
    /// Part of the picture that is sky.
    pub share: f64,
    /// How sure that is, 0..1; below [`SURE_OF_SKY`] there may be none.
    pub confidence: f64,
    /// Whether a pixel of it was pointed at, and it reaches the top edge from there: then it is one all the same.
    pub is_pointed: bool,
    /// Why, in words.
    pub reasons: Vec<String>,
}

/// Finds the sky of a photograph, of which a pixel may be pointed at: column and row, inside of the picture.
///
/// # Errors
/// A picture of fewer than 8 pixels along a side.
pub fn find_sky(photo: &LinearPicture, pointed: Option<[usize; 2]>) -> Result<SkyMask, Error> {
    let least = photo.nrows().min(photo.ncols());
    if least < 8 {
        return Err(Error::Range {
            what: "the shorter side of the photograph in pixels",
            found: least as f64,
            expected: "at least 8",
        });
    }
    let raw = reduced(photo).mapv(oklab);
    let means = mean_of_nine(&raw);
    let lab = Array2::from_shape_fn(raw.dim(), |at| -> [f32; 3] {
        std::array::from_fn(|channel| 0.5 * (raw[at][channel] + means[at][channel]))
    });
    let sharp = sharpness(&raw);
    let step = photo.nrows().max(photo.ncols()).div_ceil(LONGEST);
    let pointed = pointed.map(|[x, y]| {
        let (height, width) = lab.dim();
        ((y / step).min(height - 1), (x / step).min(width - 1))
    });
    let mut best = Candidate::new(&lab, &sharp, None);
    if let Some(at) = pointed
        && !(best.is_sure() && best.sky[at])
    {
        best = Candidate::new(&lab, &sharp, pointed).better(best);
    }
    let Candidate {
        sky: coarse,
        confidence,
        mut reasons,
        is_pointed,
    } = best;
    if is_pointed {
        reasons.push("what is pointed at goes on to the top edge".to_owned());
    }
    let is_sky = upsample_labels(&coarse.mapv(u8::from), photo)?.mapv(|label| label == 1);
    let n_sky = is_sky.iter().filter(|is_sky| **is_sky).count();
    Ok(SkyMask {
        share: n_sky as f64 / is_sky.len() as f64,
        confidence,
        is_pointed,
        reasons,
        is_sky,
    })
}

/// What may be the sky of a reduced picture.
struct Candidate {
    sky: Array2<bool>,
    confidence: f64,
    reasons: Vec<String>,
    is_pointed: bool,
}

impl Candidate {
    /// With what is pointed at, or without.
    fn new(lab: &Array2<[f32; 3]>, sharp: &Array2<f32>, pointed: Option<(usize, usize)>) -> Self {
        let known = match pointed {
            Some(at) => around(lab, at),
            None => Array2::from_elem(lab.dim(), false),
        };
        let sky = sky_of(lab, &sky_border(sharp, pointed), &known);
        let is_on_top = |at| reached(&sky, at).row(0).iter().any(|it| *it);
        let is_pointed = pointed.is_some_and(is_on_top);
        let (confidence, reasons) = confidence(&sky, lab, sharp);
        Self {
            sky,
            confidence,
            reasons,
            is_pointed,
        }
    }

    fn is_sure(&self) -> bool {
        self.confidence >= SURE_OF_SKY
    }

    /// What is pointed at, unless the other is a surer sky.
    fn better(self, other: Self) -> Self {
        let is_surer = other.is_sure() && other.confidence > self.confidence;
        if is_surer || !self.is_pointed {
            other
        } else {
            self
        }
    }
}

/// The means of squares of pixels, white at 1.
fn reduced(photo: &LinearPicture) -> LinearPicture {
    let (height, width) = photo.dim();
    let step = height.max(width).div_ceil(LONGEST);
    let mut picture =
        Array2::from_shape_fn((height.div_ceil(step), width.div_ceil(step)), |(y, x)| {
            let (mut sum, mut n) = ([0.0_f32; 3], 0.0);
            for row in y * step..((y + 1) * step).min(height) {
                for column in x * step..((x + 1) * step).min(width) {
                    n += 1.0;
                    for (sum, channel) in sum.iter_mut().zip(photo[[row, column]]) {
                        *sum += channel;
                    }
                }
            }
            sum.map(|sum| sum / n)
        });
    let greens = picture.iter().map(|pixel| pixel[1]).collect();
    let white = quantile(greens, BELOW_WHITE).max(1e-6);
    picture.mapv_inplace(|pixel| pixel.map(|channel| channel / white));
    picture
}

/// What has the color of a pixel and goes over into it.
fn around(lab: &Array2<[f32; 3]>, start: (usize, usize)) -> Array2<bool> {
    let apart = |a: (usize, usize), b: (usize, usize)| {
        let squares = lab[a].iter().zip(lab[b]).map(|(a, b)| (a - b) * (a - b));
        squares.sum::<f32>().sqrt()
    };
    spread(lab.dim(), vec![start], |from, to| {
        apart(start, to) < OF_POINTED && apart(from, to) < TO_NEXT
    })
}

fn sky_of(lab: &Array2<[f32; 3]>, border: &[usize], known: &Array2<bool>) -> Array2<bool> {
    let rows = border.iter().filter(|row| **row > 0);
    let lowest = quantile(rows.map(|row| *row as f32).collect(), ABOVE_LOWEST) as usize;
    let is_covered = |x: usize| (border[x] as f64) < COVERED * lowest as f64;
    let mut guess = Array2::from_shape_fn(lab.dim(), |(y, x)| match () {
        () if is_covered(x) && y < lowest => 0.0,
        () if y < border[x] => 1.0,
        () if y < lowest => THROUGH,
        () => -1.0,
    });
    let take_known = |guess: &mut Array2<f32>| {
        Zip::from(guess).and(known).for_each(|guess, is_known| {
            if *is_known {
                *guess = KNOWN;
            }
        });
    };
    take_known(&mut guess);
    let mut sky = guess.mapv(|value| value > 0.0);
    for _ in 0..N_FITS {
        let Some(like) = likeness(lab, &guess) else {
            break;
        };
        let start = Array2::from_shape_fn(lab.dim(), |(y, x)| {
            let is_seen = sky[[y, x]] || like.alone[[y, x]] > HOLE;
            y == 0 || known[[y, x]] || (y < lowest && is_seen)
        });
        let mut is_open = like.settled.mapv(|value| value > 0.0);
        is_open.zip_mut_with(known, |is_open, is_known| *is_open |= is_known);
        sky = connected(&is_open, &start);
        guess = sky.mapv(|is_sky| if is_sky { 1.0 } else { -1.0 });
        take_known(&mut guess);
    }
    sky
}

/// The part of the open pixels that is connected to a start.
fn connected(is_open: &Array2<bool>, start: &Array2<bool>) -> Array2<bool> {
    let starts = start
        .indexed_iter()
        .filter(|(at, is_start)| **is_start && is_open[*at]);
    let starts = starts.map(|(at, _)| at).collect();
    spread(is_open.dim(), starts, |_, to| is_open[to])
}

/// The part of a mask that is connected to a pixel.
fn reached(mask: &Array2<bool>, from: (usize, usize)) -> Array2<bool> {
    spread(mask.dim(), vec![from], |_, to| mask[to])
}

/// What is reached from pixel to pixel, going from one to the next where that may be.
fn spread(
    size: (usize, usize),
    mut next: Vec<(usize, usize)>,
    may_go: impl Fn((usize, usize), (usize, usize)) -> bool,
) -> Array2<bool> {
    let mut found = Array2::from_elem(size, false);
    for at in &next {
        found[*at] = true;
    }
    while let Some((y, x)) = next.pop() {
        let beside = [
            (y.wrapping_sub(1), x),
            (y + 1, x),
            (y, x.wrapping_sub(1)),
            (y, x + 1),
        ];
        for at in beside {
            if at.0 < size.0 && at.1 < size.1 && !found[at] && may_go((y, x), at) {
                found[at] = true;
                next.push(at);
            }
        }
    }
    found
}

fn confidence(
    sky: &Array2<bool>,
    lab: &Array2<[f32; 3]>,
    sharp: &Array2<f32>,
) -> (f64, Vec<String>) {
    let (height, width) = sky.dim();
    let of = |wanted: bool, value: &dyn Fn((usize, usize)) -> f32| {
        let pixels = sky.indexed_iter().filter(|(_, is_sky)| **is_sky == wanted);
        f64::from(quantile(pixels.map(|(at, _)| value(at)).collect(), 0.5))
    };
    let [sky_sharp, ground_sharp] = [true, false].map(|it| of(it, &|at| sharp[at]));
    let [sky_light, ground_light] = [true, false].map(|it| of(it, &|at| lab[at][0]));
    let [sky_yellow, ground_yellow] = [true, false].map(|it| of(it, &|at| lab[at][2]));
    let top = sky.row(0).iter().filter(|is_sky| **is_sky).count() as f64 / width as f64;
    let is_edge = |y: usize, x: usize| {
        let below = y + 1 < height && !sky[[y + 1, x]];
        let beside = x + 1 < width && sky[[y, x + 1]] != sky[[y, x]];
        (sky[[y, x]] && below) || beside
    };
    let (mut n_edge, mut n_sharp) = (0.0, 0.0);
    for ((y, x), value) in sharp.indexed_iter() {
        if is_edge(y, x) {
            n_edge += 1.0;
            n_sharp += f64::from(u8::from(f64::from(*value) > SHARP_EDGE * sky_sharp));
        }
    }
    let edge = n_sharp / f64::max(n_edge, 1.0);
    let smoother = sky_sharp / ground_sharp.max(1e-6);
    let (brighter, bluer) = (sky_light - ground_light, ground_yellow - sky_yellow);
    let percent = |part: f64| format!("{:.0} %", 100.0 * part);
    let reasons = vec![
        format!("it takes {} of the top edge", percent(top)),
        format!("its edge is sharp on {} of its length", percent(edge)),
        format!(
            "it has {} of the roughness of what is below",
            percent(smoother)
        ),
        format!(
            "it is {} and {} than that",
            if brighter > 0.0 { "brighter" } else { "darker" },
            if bluer > 0.0 { "bluer" } else { "yellower" },
        ),
    ];
    let color = ramp(brighter, COLOR).max(ramp(bluer, COLOR));
    let confidence = ramp(top, TOP) * ramp(edge, EDGE) * (1.0 - ramp(smoother, SMOOTHER)) * color;
    (confidence, reasons)
}

/// From 0 at the first to 1 at the second.
fn ramp(value: f64, (none, all): (f64, f64)) -> f64 {
    ((value - none) / (all - none)).clamp(0.0, 1.0)
}

/// The value below which a part of them lies; 0 of none.
fn quantile(mut values: Vec<f32>, part: f64) -> f32 {
    values.sort_by(f32::total_cmp);
    let index = (part * values.len().saturating_sub(1) as f64) as usize;
    values.get(index).copied().unwrap_or(0.0)
}
