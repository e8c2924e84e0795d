//! What a picture leaves out, pixel by pixel.
//!
//! Of effects with a bound it is the RMS of that, the same everywhere; of light that was looked at in a small
//! picture of the same view, what was seen there.

use ndarray::Array2;
use niji_exchange::Aov;
use niji_geometry::PixelRegion;
use niji_scene::Effect;
use niji_scene::Plan;
use serde::Deserialize;
use serde::Serialize;

/// What files call it beside the causes of the error.
pub const LEFT_OUT: &str = "left_out";

/// Luminance of a small picture, over display white.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SmallPicture {
    /// Column and row of its first pixel, counted from the first of the frame.
    pub(crate) first_px: [i32; 2],
    /// Those of the frame.
    pub(crate) frame_px: [u32; 2],
    /// By row and column.
    pub(crate) luminance: Vec<Vec<f32>>,
}

/// What the effects change that a plan left out by itself, over display white.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LeftOut {
    /// Sum of the RMS bounds of all but light of further orders.
    everywhere: f64,
    /// Light of further orders, where a small picture showed it.
    #[serde(skip_serializing_if = "Option::is_none")]
    further_orders: Option<SmallPicture>,
}

impl LeftOut {
    /// What a plan left out, with the light of further orders that was looked at before.
    pub(crate) fn of(plan: &Plan, further_orders: Option<&SmallPicture>) -> Self {
        let effect = Effect::MultipleScattering;
        let further_orders = further_orders.filter(|_| !plan.is_on(effect)).cloned();
        let is_shown = |it: Effect| it == effect && further_orders.is_some();
        let off = plan.effects.iter().filter(|it| it.is_left_out);
        let off = off.filter(|it| !is_shown(it.effect));
        Self {
            everywhere: off.map(|it| it.bound.rms).sum(),
            further_orders,
        }
    }

    /// Beside the estimated error of a region of a picture, as one of its parts.
    pub(crate) fn add_to(&self, error: &mut Aov, place: Place) {
        let Some((_, all)) = error.channels.first_mut() else {
            return;
        };
        let left_out = Array2::from_shape_fn(all.dim(), |(y, x)| {
            let [x, y] = [
                f64::from(place.region.x_px) + x as f64,
                f64::from(place.region.y_px) + y as f64,
            ];
            let [width, height] = place.frame_px.map(f64::from);
            let of_further = self.further_orders.as_ref();
            let light = of_further.map_or(0.0, |it| it.at((x + 0.5) / width, (y + 0.5) / height));
            ((self.everywhere + light) * place.display_white_cd_m2) as f32
        });
        for (all, left_out) in all.iter_mut().zip(&left_out) {
            *all = all.hypot(*left_out);
        }
        error.channels.push((LEFT_OUT.to_owned(), left_out));
    }
}

/// Where pixels lie, and what is white there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) region: PixelRegion,
    /// Pixels of the frame.
    pub(crate) frame_px: [u32; 2],
    pub(crate) display_white_cd_m2: f64,
}

impl SmallPicture {
    /// Its light at a place in parts of the frame, linear between pixels; the nearest ones hold outside.
    fn at(&self, right: f64, down: f64) -> f64 {
        let [width, height] = self.frame_px.map(f64::from);
        let [first_x, first_y] = self.first_px.map(f64::from);
        let n_columns = self.luminance.first().map_or(0, Vec::len);
        let x = between(right * width - 0.5 - first_x, n_columns);
        let y = between(down * height - 0.5 - first_y, self.luminance.len());
        let pairs = y.iter().flat_map(|y| x.iter().map(move |x| (*y, *x)));
        let light = |((row, of_row), (column, of_column)): ((usize, f64), (usize, f64))| {
            of_row * of_column * f64::from(self.luminance[row][column])
        };
        pairs.map(light).sum()
    }
}

/// The two pixels around a place with their weights.
fn between(place: f64, n_px: usize) -> [(usize, f64); 2] {
    let last = n_px.saturating_sub(1);
    let place = place.clamp(0.0, last as f64);
    let (below, part) = (place as usize, place.fract());
    [(below, 1.0 - part), ((below + 1).min(last), part)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_picture_is_linear_over_the_frame_whatever_region_of_it_is_asked_for() {
        // Twice as many pixels along each side, with overscan of two; linear in both directions.
        let (frame_px, small_px) = ([16_u32, 8_u32], [8_u32, 4_u32]);
        let at = |x: f64, y: f64| 1.0 + 2.0 * x + 3.0 * y;
        let place =
            |n: u32, low: i32, size: u32| (f64::from(low) + f64::from(n) + 0.5) / f64::from(size);
        let row = |y| {
            (0..10)
                .map(|x| at(place(x, -1, 8), place(y, -1, 4)) as f32)
                .collect()
        };
        let left_out = LeftOut {
            everywhere: 0.25,
            further_orders: Some(SmallPicture {
                first_px: [-1, -1],
                frame_px: small_px,
                luminance: (0..6).map(row).collect(),
            }),
        };
        let region = PixelRegion {
            x_px: 3,
            y_px: 2,
            width_px: 5,
            height_px: 4,
        };
        let mut error = Aov {
            name: "error".to_owned(),
            unit: "cd/m^2".to_owned(),
            channels: vec![("Y".to_owned(), Array2::from_elem((4, 5), 3.0))],
        };
        let display_white_cd_m2 = 2.0;
        left_out.add_to(
            &mut error,
            Place {
                region,
                frame_px,
                display_white_cd_m2,
            },
        );
        let (name, found) = &error.channels[1];
        assert_eq!(name, "left_out");
        for ((y, x), found) in found.indexed_iter() {
            let expected = at(place(x as u32, 3, 16), place(y as u32, 2, 8)) + 0.25;
            assert!(
                (f64::from(*found) - 2.0 * expected).abs() < 1e-5,
                "{y} {x}: {found}"
            );
            assert!((error.channels[0].1[[y, x]] - found.hypot(3.0)).abs() < 1e-5);
        }
    }
}
