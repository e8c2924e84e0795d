//! `niji plan --preview`: a coarse picture with the places of the bows drawn over it.

use std::path::Path;

use niji_picture::Look;
use niji_picture::Looks;
use niji_picture::PlannedScene;
use niji_picture::SkyMarks;
use niji_picture::unwatched;
use niji_scene::PickedBow;
use niji_scene::PickedColor;
use niji_scene::Scene;

use crate::failure::Failure;
use crate::output;
use crate::output::Existing;
use crate::scene_file;

/// Columns at most.
const WIDTH_PX: u32 = 960;

/// Half of the width of a line, and of the cross at the antisolar point, in pixels.
const HALF_LINE_PX: f64 = 0.9;
const HALF_CROSS_PX: f64 = 9.0;

/// Colors of lines: outer and inner edge of the primary and of the secondary, horizon, antisolar point.
const RED: [u8; 3] = [255, 70, 60];
const VIOLET: [u8; 3] = [170, 120, 255];
const PALE_RED: [u8; 3] = [255, 160, 150];
const PALE_VIOLET: [u8; 3] = [210, 190, 255];
const WHITE: [u8; 3] = [255, 255, 255];

/// Draws where the bows of a scene lie, and the horizon and the antisolar point where these are in view.
///
/// # Errors
/// A scene that cannot be looked at, or a file that exists or cannot be written.
pub(crate) fn write(
    planned: &PlannedScene,
    (scene, to): (&Path, &Path),
    existing: Existing,
) -> Result<(), Failure> {
    output::check_free(to, existing)?;
    let mut shown = planned.scene.clone();
    shown.camera.overscan_px = 0;
    shown.camera = shown.camera.no_wider_than(WIDTH_PX);
    let looked = Looks::default().planned(&shown, Look::Finer, scene_file::beside(scene))?;
    let mut sheet = Sheet::of(&looked, &shown)?;
    let marks = SkyMarks::of(&shown)?;
    sheet.lines(&marks.horizon, WHITE);
    for (edge, lines) in &marks.bows {
        let color = match (edge.bow, edge.color) {
            (PickedBow::Primary, PickedColor::Violet) => VIOLET,
            (PickedBow::Primary, _) => RED,
            (PickedBow::Secondary, PickedColor::Violet) => PALE_VIOLET,
            (PickedBow::Secondary, _) => PALE_RED,
        };
        sheet.lines(lines, color);
    }
    if let Some([x, y]) = marks.antisolar_px {
        let cross = HALF_CROSS_PX;
        sheet.lines(&[vec![[x - cross, y], [x + cross, y]]], WHITE);
        sheet.lines(&[vec![[x, y - cross], [x, y + cross]]], WHITE);
    }
    sheet.write(to)
}

/// Pixels of three bytes.
struct Sheet {
    size_px: [usize; 2],
    rgb: Vec<u8>,
}

impl Sheet {
    /// A look at a scene, as large as `shown`.
    fn of(looked: &PlannedScene, shown: &Scene) -> Result<Self, Failure> {
        let mut bytes = Vec::new();
        // Where bows lie is asked of scenes without light, too.
        let picture = looked.unchecked_picture(&unwatched)?;
        let failed = |error: &dyn std::fmt::Display| Failure::Failed(error.to_string());
        let written = picture.write_png(&mut bytes, shown.picture.exposure_ev);
        written.map_err(|error| failed(&error))?;
        let decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        let mut reader = decoder.read_info().map_err(|error| failed(&error))?;
        let mut small = vec![0; reader.output_buffer_size().unwrap_or(0)];
        let info = reader
            .next_frame(&mut small)
            .map_err(|error| failed(&error))?;
        let n_channels = info.color_type.samples();
        let small_px = [info.width, info.height].map(|it| it as usize);
        let size_px = [shown.camera.width_px, shown.camera.height_px].map(|it| it as usize);
        let mut rgb = Vec::with_capacity(3 * size_px[0] * size_px[1]);
        for y in 0..size_px[1] {
            let rows = around(y, (size_px[1], small_px[1]));
            for x in 0..size_px[0] {
                let columns = around(x, (size_px[0], small_px[0]));
                for channel in 0..3 {
                    let value = rows.iter().flat_map(|(row, of_row)| {
                        let small = &small;
                        columns.iter().map(move |(column, of_column)| {
                            let at = n_channels * (row * small_px[0] + column) + channel;
                            of_row * of_column * f64::from(small[at])
                        })
                    });
                    rgb.push(value.sum::<f64>().round() as u8);
                }
            }
        }
        Ok(Self { size_px, rgb })
    }

    /// Broken lines of one color.
    fn lines(&mut self, lines: &[Vec<[f64; 2]>], color: [u8; 3]) {
        for ends in lines.iter().flat_map(|line| line.windows(2)) {
            let [from, to] = [ends[0], ends[1]];
            let length_px = (to[0] - from[0]).hypot(to[1] - from[1]);
            let n_steps = (2.0 * length_px).ceil().max(1.0);
            for step in 0..=n_steps as usize {
                let part = step as f64 / n_steps;
                self.dot(
                    [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis])),
                    color,
                );
            }
        }
    }

    /// The pixels whose middle is near a place.
    fn dot(&mut self, place: [f64; 2], color: [u8; 3]) {
        let near = |axis: usize| {
            let low = (place[axis] - HALF_LINE_PX).floor().max(0.0) as usize;
            let high = (place[axis] + HALF_LINE_PX).ceil().max(0.0) as usize;
            low..high.min(self.size_px[axis])
        };
        let (columns, rows) = (near(0), near(1));
        for y in rows {
            for x in columns.clone() {
                let off = [x as f64 + 0.5 - place[0], y as f64 + 0.5 - place[1]];
                if off[0].hypot(off[1]) <= HALF_LINE_PX {
                    let at = 3 * (y * self.size_px[0] + x);
                    self.rgb[at..at + 3].copy_from_slice(&color);
                }
            }
        }
    }

    fn write(&self, to: &Path) -> Result<(), Failure> {
        output::write_rgb_png(to, self.size_px, &self.rgb)
    }
}

/// The two of `n_small` pixels around the middle of one of `n`, with their weights.
fn around(index: usize, (n, n_small): (usize, usize)) -> [(usize, f64); 2] {
    let place = (index as f64 + 0.5) * n_small as f64 / n as f64 - 0.5;
    let place = place.clamp(0.0, n_small as f64 - 1.0);
    let below = place as usize;
    let part = place - below as f64;
    [(below, 1.0 - part), ((below + 1).min(n_small - 1), part)]
}
