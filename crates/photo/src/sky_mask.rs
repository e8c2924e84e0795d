//! The sky of a photograph, by color, sharpness, place and connection to the top edge.
//!
//! Guesses of a sky ([`sky_borders`](crate::sky_border), SW13; [`sky_prior`](crate::sky_prior)) each lead on: the colors
//! and places of what is guessed to be sky and ground decide pixel by pixel ([`Colors`](crate::sky_colors), BJ01, KK11),
//! and again from what they found. What is connected to the top edge is sky, and what looks like it through holes above
//! its lowest border. That is done on a picture of at most 160 pixels. Of what was found there the surest counts
//! ([`sky_score`](crate::sky_score)); colors settle its border on one of at most 640, and joint bilateral upsampling
//! (KCLU07) carries it to the photograph.
//!
//! A pixel that somebody points at is sky, and so is what has its color around it, unless a sure sky holds it already.
//! Where that goes on to the top edge it is a sky however little else speaks for it, unless without it one is found
//! that is surer.

use ndarray::Array2;
use ndarray::Zip;
use rayon::prelude::*;

use crate::error::Error;
use crate::joint_bilateral::upsample_labels;
use crate::linear_picture::LinearPicture;
use crate::linear_picture::square_means;
use crate::perceptual::oklab;
use crate::perceptual::square_apart;
use crate::sky_border::mean_of_nine;
use crate::sky_border::sharpness;
use crate::sky_border::sky_borders;
use crate::sky_colors::Colors;
use crate::sky_prior::sky_prior;
use crate::sky_score::sky_score;

/// Longest side on which a sky is looked for, and on which its border is settled, pixels.
const COARSE: usize = 160;
const FINE: usize = 640;
/// Part of the pixels that are darker than white.
const BELOW_WHITE: f64 = 0.99;
/// Log ratios from which the look of any sky is a guess.
const LIKE_ANY: [f32; 2] = [0.0, -1.5];
/// Times that colors decide on either.
const N_COARSE: usize = 3;
const N_FINE: usize = 1;
/// Part of the columns whose border lies above the lowest that counts.
const ABOVE_LOWEST: f64 = 0.85;
/// Border above which a column is covered from the top, by a branch, say, as part of the lowest.
const COVERED: f64 = 0.3;
/// Log ratio from which a hole shows the sky.
const HOLE: f32 = 0.5;
/// Difference of color (Oklab) from a pixel that is sky, and from pixel to pixel, up to which its surroundings are.
const OF_POINTED: f32 = 0.1;
const TO_NEXT: f32 = 0.03;
/// What is guessed of a pixel that is known to be sky: more than any color says.
const KNOWN: f32 = 20.0;
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
    let [coarse, fine] = [COARSE, FINE].map(|longest| Reduced::new(photo, longest));
    let pointed = pointed.map(|[x, y]| [y, x]);
    let known = match pointed {
        Some(at) => around(&fine.lab, fine.pixel(at)),
        None => Array2::from_elem(fine.lab.dim(), false),
    };
    let prior = sky_prior(&coarse.lab, &coarse.sharp);
    let search = Search {
        colors: Colors::new(coarse.lab.clone(), prior),
        sharp: &coarse.sharp,
    };
    let none = Array2::from_elem(coarse.lab.dim(), false);
    let mut best = search.surest(&none, None);
    if let Some(at) = pointed {
        let at = coarse.pixel(at);
        if !(best.is_sure() && best.sky[at]) {
            let mut near = coarse.taken(&known, &fine);
            near[at] = true;
            best = search.surest(&near, Some(at)).better(best);
        }
    }
    let known = if best.is_pointed {
        known
    } else {
        Array2::from_elem(fine.lab.dim(), false)
    };
    let guess = fine.taken(&best.sky, &coarse);
    let colors = Colors::new(fine.lab.clone(), fine.taken(&search.colors.prior, &coarse));
    let settled = sky_of(&colors, guess.mapv(sign), &known, N_FINE);
    let Candidate {
        confidence,
        mut reasons,
        is_pointed,
        ..
    } = best;
    if is_pointed {
        reasons.push("what is pointed at goes on to the top edge".to_owned());
    }
    let is_sky = upsample_labels(&settled.mapv(u8::from), photo)?.mapv(|label| label == 1);
    let n_sky = is_sky.iter().filter(|is_sky| **is_sky).count();
    Ok(SkyMask {
        share: n_sky as f64 / is_sky.len() as f64,
        confidence,
        is_pointed,
        reasons,
        is_sky,
    })
}

/// A photograph of fewer pixels, in Oklab, white at 1.
struct Reduced {
    /// Pixels of the photograph along the side of one.
    step: usize,
    lab: Array2<[f32; 3]>,
    sharp: Array2<f32>,
}

impl Reduced {
    fn new(photo: &LinearPicture, longest: usize) -> Self {
        let raw = reduced(photo, longest).mapv(oklab);
        let means = mean_of_nine(&raw);
        let lab = Array2::from_shape_fn(raw.dim(), |at| -> [f32; 3] {
            std::array::from_fn(|channel| 0.5 * (raw[at][channel] + means[at][channel]))
        });
        Self {
            step: step(photo, longest),
            sharp: sharpness(&raw),
            lab,
        }
    }

    /// The pixel that holds one of the photograph, by row and column.
    fn pixel(&self, [y, x]: [usize; 2]) -> (usize, usize) {
        let (height, width) = self.lab.dim();
        (
            (y / self.step).min(height - 1),
            (x / self.step).min(width - 1),
        )
    }

    /// What another reduction has in the middles of the pixels.
    fn taken<T: Copy>(&self, map: &Array2<T>, other: &Self) -> Array2<T> {
        Array2::from_shape_fn(self.lab.dim(), |(y, x)| {
            map[other.pixel([y, x].map(|index| index * self.step + self.step / 2))]
        })
    }
}

/// Where a sky is looked for.
struct Search<'a> {
    colors: Colors,
    sharp: &'a Array2<f32>,
}

impl Search<'_> {
    /// The surest sky that holds what is known; where a pixel is pointed at, of those that reach the top edge from it.
    fn surest(&self, known: &Array2<bool>, pointed: Option<(usize, usize)>) -> Candidate {
        let prior = &self.colors.prior;
        let borders = sky_borders(self.sharp).into_iter().map(|border| {
            let rows = border.iter().map(|row| *row as f32);
            let lowest = quantile(rows.collect(), ABOVE_LOWEST) as usize;
            let is_covered = |x: usize| (border[x] as f64) < COVERED * lowest as f64;
            Array2::from_shape_fn(prior.dim(), |(y, x)| match () {
                () if y < border[x] => 1.0,
                () if prior[[y, x]] > 0.0 || (y < lowest && is_covered(x)) => 0.0,
                () => -1.0,
            })
        });
        let likes = LIKE_ANY.map(|least| prior.mapv(|value| sign(value > least)));
        let guesses: Vec<Array2<f32>> = borders.chain(likes).collect();
        let candidate = |guess: Array2<f32>| {
            let sky = sky_of(&self.colors, guess, known, N_COARSE);
            let is_on_top = |at| reached(&sky, at).row(0).iter().any(|it| *it);
            let (confidence, reasons) = sky_score(&sky, &self.colors, self.sharp);
            Candidate {
                is_pointed: pointed.is_some_and(is_on_top),
                confidence,
                reasons,
                sky,
            }
        };
        let candidates: Vec<_> = guesses.into_par_iter().map(candidate).collect();
        let surest = candidates.into_iter().reduce(|best, next| {
            let rank = |it: &Candidate| (it.is_pointed, it.confidence);
            if rank(&next) > rank(&best) {
                next
            } else {
                best
            }
        });
        surest.expect("there is a guess")
    }
}

/// What may be the sky of a reduced picture.
struct Candidate {
    sky: Array2<bool>,
    confidence: f64,
    reasons: Vec<String>,
    is_pointed: bool,
}

impl Candidate {
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

/// 1 for the sky, −1 for the ground.
fn sign(is_sky: bool) -> f32 {
    if is_sky { 1.0 } else { -1.0 }
}

/// Pixels of a photograph along the side of one of a picture of at most so many.
fn step(photo: &LinearPicture, longest: usize) -> usize {
    photo.nrows().max(photo.ncols()).div_ceil(longest)
}

/// The means of squares of pixels, white at 1.
fn reduced(photo: &LinearPicture, longest: usize) -> LinearPicture {
    let mut picture = square_means(&photo.view(), step(photo, longest));
    let greens = picture.iter().map(|pixel| pixel[1]).collect();
    let white = quantile(greens, BELOW_WHITE).max(1e-6);
    picture.mapv_inplace(|pixel| pixel.map(|channel| channel / white));
    picture
}

/// What has the color of a pixel and goes over into it.
fn around(lab: &Array2<[f32; 3]>, start: (usize, usize)) -> Array2<bool> {
    let apart = |a: (usize, usize), b: (usize, usize)| square_apart(lab[a], lab[b]).sqrt();
    spread(lab.dim(), vec![start], |from, to| {
        apart(start, to) < OF_POINTED && apart(from, to) < TO_NEXT
    })
}

/// What colors make of a guess: 1 for the sky, −1 for the ground, between where it is not sure.
fn sky_of(
    colors: &Colors,
    mut guess: Array2<f32>,
    known: &Array2<bool>,
    n_fits: usize,
) -> Array2<bool> {
    let mut sky = guess.mapv(|value| value > 0.0);
    for _ in 0..n_fits {
        Zip::from(&mut guess)
            .and(known)
            .for_each(|guess, is_known| {
                if *is_known {
                    *guess = KNOWN;
                }
            });
        let Some(like) = colors.likeness(&guess) else {
            break;
        };
        let mut is_open = like.settled.mapv(|value| value > 0.0);
        is_open.zip_mut_with(known, |is_open, is_known| *is_open |= is_known);
        let from_top = Array2::from_shape_fn(is_open.dim(), |(y, x)| y == 0 || known[[y, x]]);
        sky = connected(&is_open, &from_top);
        let columns = sky.columns().into_iter();
        let ends = columns.map(|column| {
            let last = column.iter().rposition(|is_sky| *is_sky);
            last.map_or(0.0, |row| row as f32 + 1.0)
        });
        let lowest = quantile(ends.collect(), ABOVE_LOWEST) as usize;
        let start = Array2::from_shape_fn(is_open.dim(), |(y, x)| {
            sky[[y, x]] || (y < lowest && like.alone[[y, x]] > HOLE)
        });
        sky = connected(&is_open, &start);
        guess = sky.mapv(sign);
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

/// The value below which a part of them lies; 0 of none.
pub(crate) fn quantile(mut values: Vec<f32>, part: f64) -> f32 {
    values.sort_by(f32::total_cmp);
    let index = (part * values.len().saturating_sub(1) as f64) as usize;
    values.get(index).copied().unwrap_or(0.0)
}
