//! What a picture errs by beside what is estimated with it, pixel by pixel.
//!
//! Of effects that are left out it is their bound in each part of the picture, for a sequence the RMS of that everywhere;
//! of what was looked at in small pictures of the same view, what was seen there. That is what is expected, the part of
//! each cause. To the error of a pixel, which few shall exceed, it adds
//!
//! M max(e(x + d))   over d of a pixel of the small picture in every direction
//! `e` what was seen or is bounded, `M` a margin, 1 of a bound: what is narrower than these pixels is brighter than they
//! show, and a difference of two levels that changes its sign is 0 where both err.

use ndarray::Array2;
use ndarray::Zip;
use niji_exchange::Aov;
use niji_geometry::PixelRegion;
use niji_scene::Effect;
use niji_scene::Plan;
use serde::Serialize;

use crate::pilot::Seen;
use crate::pilot::SmallPicture;

/// What files call effects left out, beside the causes of the error that is estimated.
pub const LEFT_OUT: &str = "left_out";
/// What they call light that the air scatters more than once.
pub const SKY: &str = "sky";
/// What they call that which lies between the nodes of the drops.
pub const DROP_SPACING: &str = "drop_spacing";

/// M of a difference of two levels or spacings, which is part of what the finer one errs by.
const OF_DIFFERENCE: f64 = 1.5;

/// M of light of further orders, by few paths, sizes and wavelengths and a coarse table.
const OF_LIGHT: f64 = 2.0;

/// M of a bound.
const OF_BOUND: f64 = 1.0;

/// What is known before a picture is rendered, over display white.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ForeseenErrors {
    /// Sum of the RMS bounds of the effects that the plan left out by itself of which nobody knows where they are.
    everywhere: f64,
    /// Bounds of the others.
    #[serde(skip_serializing_if = "Option::is_none")]
    left_out: Option<SmallPicture>,
    /// Light of further orders that the plan left out, where a small picture showed it.
    #[serde(skip_serializing_if = "Option::is_none")]
    further_orders: Option<SmallPicture>,
    /// What light of the sky is off by that the air scattered before.
    #[serde(skip_serializing_if = "Option::is_none")]
    sky: Option<SmallPicture>,
    /// What the spacing of the drops' nodes changes.
    #[serde(skip_serializing_if = "Option::is_none")]
    drop_spacing: Option<SmallPicture>,
}

impl ForeseenErrors {
    /// Those of a plan, with what was measured for it.
    pub(crate) fn of(plan: &Plan, seen: &Seen) -> Self {
        let effect = Effect::MultipleScattering;
        let further_orders = seen.further_orders.clone();
        let further_orders = further_orders.filter(|_| !plan.is_on(effect));
        let left_out = seen.left_out.clone();
        let is_placed = |it: Effect| {
            let is_seen = it == effect && further_orders.is_some();
            is_seen || it.is_bounded_by_place() && left_out.is_some()
        };
        let off = plan.effects.iter().filter(|it| it.is_left_out);
        let off = off.filter(|it| !is_placed(it.effect));
        Self {
            everywhere: off.map(|it| it.bound.rms).sum(),
            left_out,
            further_orders,
            sky: seen.sky.as_ref().map(|it| it.error.clone()),
            drop_spacing: seen.drop_spacing.as_ref().map(|it| it.error.clone()),
        }
    }

    /// Effects left out, and the others of which something is known.
    fn causes(&self) -> impl Iterator<Item = Cause<'_>> {
        let left_out = [
            (self.left_out.as_ref(), OF_BOUND),
            (self.further_orders.as_ref(), OF_LIGHT),
        ];
        let causes = [
            (LEFT_OUT, self.everywhere, &left_out[..]),
            (SKY, 0.0, &[(self.sky.as_ref(), OF_DIFFERENCE)]),
            (
                DROP_SPACING,
                0.0,
                &[(self.drop_spacing.as_ref(), OF_DIFFERENCE)],
            ),
        ];
        let causes = causes.map(|(name, everywhere, parts)| Cause {
            name,
            everywhere,
            parts: parts
                .iter()
                .filter_map(|(part, margin)| Some(((*part)?, *margin)))
                .collect(),
        });
        let is_known = |it: &Cause| it.name == LEFT_OUT || !it.parts.is_empty();
        causes.into_iter().filter(is_known)
    }

    /// Beside the estimated error of a region of a picture, each as one of its parts.
    pub(crate) fn add_to(&self, error: &mut Aov, place: Place) {
        for Cause {
            name,
            everywhere,
            parts,
        } in self.causes()
        {
            let Some((_, all)) = error.channels.first_mut() else {
                return;
            };
            let plane = |parts: &[(SmallPicture, f64)]| {
                let mut plane = Array2::zeros(all.dim());
                Zip::indexed(&mut plane).par_for_each(|at, value| {
                    let [right, down] = place.of(at);
                    let parts = parts.iter();
                    let here: f64 = parts.map(|(it, times)| times * it.at(right, down)).sum();
                    *value = ((everywhere + here) * place.display_white_cd_m2) as f32;
                });
                plane
            };
            let parts = parts.into_iter();
            let (expected, widened): (Vec<_>, Vec<_>) = parts
                .map(|(part, margin)| ((part.clone(), 1.0), (part.widened(), margin)))
                .unzip();
            let (values, at_most) = (plane(&expected), plane(&widened));
            for (all, at_most) in all.iter_mut().zip(&at_most) {
                *all = all.hypot(*at_most);
            }
            error.channels.push((name.to_owned(), values));
        }
    }
}

/// What one cause adds, over display white.
struct Cause<'a> {
    /// What files call it.
    name: &'static str,
    /// The same in every pixel.
    everywhere: f64,
    /// What is added to that in places, and its M.
    parts: Vec<(&'a SmallPicture, f64)>,
}

/// Where pixels lie, and what is white there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) region: PixelRegion,
    /// Pixels of the frame.
    pub(crate) frame_px: [u32; 2],
    pub(crate) display_white_cd_m2: f64,
}

impl Place {
    /// The middle of a pixel by row and column of the region, in parts of the frame to the right and down.
    fn of(&self, (row, column): (usize, usize)) -> [f64; 2] {
        let [width, height] = self.frame_px.map(f64::from);
        let x = f64::from(self.region.x_px) + column as f64 + 0.5;
        let y = f64::from(self.region.y_px) + row as f64 + 0.5;
        [x / width, y / height]
    }
}

#[cfg(test)]
mod tests {
    use niji_scene::Camera;

    use super::*;

    #[test]
    fn bounds_are_told_in_the_part_of_the_picture_that_they_are_of_and_reach_around_it() {
        // Four columns for eight pixels with two more on either side: three pixels each.
        let camera: Camera = serde_json::from_str(
            r#"{"position_m": [0, 2, 0], "azimuth_deg": 0, "elevation_deg": 0, "horizontal_fov_deg": 60,
                "width_px": 8, "height_px": 2, "overscan_px": 2}"#,
        )
        .unwrap();
        let parts = vec![vec![0.0, 0.5, 0.0, 0.0]; 2];
        let foreseen = ForeseenErrors {
            everywhere: 0.1,
            left_out: SmallPicture::of_parts(&camera, parts),
            ..ForeseenErrors::default()
        };
        let mut error = Aov {
            name: "error".to_owned(),
            unit: "cd/m^2".to_owned(),
            channels: vec![("Y".to_owned(), Array2::zeros((6, 12)))],
        };
        let place = Place {
            region: PixelRegion {
                x_px: -2,
                y_px: -2,
                width_px: 12,
                height_px: 6,
            },
            frame_px: [8, 2],
            display_white_cd_m2: 1.0,
        };
        foreseen.add_to(&mut error, place);
        assert_eq!(error.channels.len(), 2);
        let (at_most, told) = (&error.channels[0].1, &error.channels[1].1);
        for row in 0..6 {
            // The middle of the second part is that of the fifth column.
            assert!((told[[row, 4]] - 0.6).abs() < 1e-6);
            for column in 0..12 {
                let (most, told) = (at_most[[row, column]], told[[row, column]]);
                let is_inside = (3..6).contains(&column);
                assert!(!is_inside || (most - 0.6).abs() < 1e-6, "{column} {most}");
                assert!(told <= most + 1e-6 && (column < 8 || told < 0.1 + 1e-6));
            }
        }
        assert!(SmallPicture::of_parts(&camera, Vec::new()).is_none());
    }

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
        let foreseen = ForeseenErrors {
            everywhere: 0.25,
            further_orders: Some(SmallPicture {
                first_px: [-1.0; 2],
                frame_px: small_px.map(f64::from),
                luminance: (0..6).map(row).collect(),
            }),
            ..ForeseenErrors::default()
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
        foreseen.add_to(
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
            // One small pixel further to the right and down it is brightest.
            let most = at(place(x as u32, 5, 16), place(y as u32, 4, 8));
            let at_most = 2.0 * (OF_LIGHT * most + 0.25) as f32;
            assert!((error.channels[0].1[[y, x]] - at_most.hypot(3.0)).abs() < 1e-5);
        }
    }
}
