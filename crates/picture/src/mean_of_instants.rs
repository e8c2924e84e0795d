//! The mean of a frame's pictures at the instants of its shutter, and what lies between them.
//!
//! L = sum_i L_i / n,   e^2 = sum_i d_i^2 / (8 n^2) + (sum_i d_i / (24 n))^2,   d_i = L_(i+1) - 2 L_i + L_(i-1)
//! `L_i` luminance in the middle of the i-th of n equal parts of the time, `e` what is told of the error of the mean (midpoint
//! rule). The first and the last d_i^2 count twice, for beyond them are none. Where an edge of height J passes, two of the
//! d_i^2 are J^2, and e is J/(2 n) at least, the most that the mean can be off. Where
//! light is smooth the mean is off by the mean of L'' h^2/24, h = 1/n, as the second term has it (Davis and Rabinowitz,
//! Methods of Numerical Integration, Academic Press (1984), section 2.1), and e falls with n^-2 at least.
//!
//! Light, its layers and what lets light pass are means. Distances and the sun's depth have none: they are those of the frame
//! itself. Each cause of error is a mean too, for what errs at one instant errs alike at the next, and so is what
//! all together are; to that the square of what lies between instants is added.

use ndarray::Array2;
use ndarray::Zip;
use niji_exchange::Aov;
use niji_exchange::SpectralImage;
use niji_exchange::luminance;
use niji_render::PictureLayer;

/// What files call it that lies between the instants of a shutter, beside other causes of error.
pub const MOTION: &str = "motion";

/// Layers that have no mean.
const OF_FRAME: [PictureLayer; 3] = [
    PictureLayer::Depth,
    PictureLayer::Surface,
    PictureLayer::TauSun,
];

/// Parts of the second differences that are told as error: of an edge, and of smooth light.
const OF_EDGE: f64 = 1.0 / 8.0;
const OF_SMOOTH: f64 = 1.0 / 24.0;

/// Pictures that are added up.
pub(crate) struct MeanOfInstants {
    n_instants: usize,
    n_added: usize,
    mean: Option<SpectralImage>,
    /// Luminance of the last two.
    last: Vec<Array2<f64>>,
    /// Sums of d_i^2 and of d_i.
    sums: Option<[Array2<f64>; 2]>,
}

impl MeanOfInstants {
    /// Of so many.
    pub(crate) fn new(n_instants: usize) -> Self {
        Self {
            n_instants,
            n_added: 0,
            mean: None,
            last: Vec::new(),
            sums: None,
        }
    }

    /// Adds the next.
    pub(crate) fn add(&mut self, image: &SpectralImage) {
        self.compare(luminance(&image.radiance, &image.wavelengths));
        // The middle one, of an even number the one after the middle, is the frame.
        let is_frame = self.n_added == self.n_instants / 2;
        self.n_added += 1;
        let Some(mean) = &mut self.mean else {
            let first = self.mean.insert(image.clone());
            // As a file has them: sums have one order, whether a picture comes from there or not.
            for aov in &mut first.aovs {
                aov.channels.sort_by(|a, b| a.0.cmp(&b.0));
            }
            return;
        };
        // Equal pictures have this very mean.
        let part = 1.0 / self.n_added as f32;
        let mix = |mean: &mut f32, value: &f32| *mean += (value - *mean) * part;
        Zip::from(&mut mean.radiance)
            .and(&image.radiance)
            .par_for_each(mix);
        for (mean, aov) in mean.aovs.iter_mut().zip(&image.aovs) {
            let has_mean = OF_FRAME.iter().all(|layer| layer.name() != aov.name);
            for (name, mean) in &mut mean.channels {
                let Some((_, values)) = aov.channels.iter().find(|it| it.0 == *name) else {
                    continue;
                };
                if has_mean {
                    Zip::from(mean).and(values).for_each(mix);
                } else if is_frame {
                    mean.assign(values);
                }
            }
        }
        if is_frame {
            mean.world_to_camera = image.world_to_camera;
            mean.attributes.clone_from(&image.attributes);
        }
    }

    fn compare(&mut self, light: Array2<f64>) {
        if let [before, last] = self.last.as_slice() {
            let [squares, sum] = self
                .sums
                .get_or_insert_with(|| [(); 2].map(|()| Array2::zeros(light.dim())));
            let is_end = [2, self.n_instants - 1].map(|end| self.n_added == end);
            let weight = 1.0 + is_end.map(|it| f64::from(u8::from(it))).iter().sum::<f64>();
            Zip::from(squares)
                .and(sum)
                .and(before)
                .and(last)
                .and(&light)
                .for_each(|squares, sum, before, last, light| {
                    let second = light - 2.0 * last + before;
                    *squares += weight * second * second;
                    *sum += second;
                });
            self.last.remove(0);
        }
        self.last.push(light);
    }

    /// What is told of the error of the mean [cd/m²]; nothing of fewer than three.
    fn error(&self) -> Option<Array2<f64>> {
        let [squares, sum] = self.sums.as_ref()?;
        let n = self.n_instants as f64;
        let error = Zip::from(squares).and(sum).map_collect(|squares, sum| {
            let smooth = OF_SMOOTH * sum / n;
            (OF_EDGE * squares / (n * n) + smooth * smooth).sqrt()
        });
        Some(error)
    }

    /// The mean, with its error.
    ///
    /// # Panics
    /// If nothing was added.
    pub(crate) fn finish(mut self) -> SpectralImage {
        let mut image = self.mean.take().expect("a shutter has instants");
        let name = PictureLayer::Error.name();
        if let Some(error) = image.aovs.iter_mut().find(|aov| aov.name == name) {
            let motion = self.error().map(|it| it.mapv(|it| it as f32));
            add_part(error, motion);
        }
        image
    }
}

/// Adds a cause to the means of all causes, and to the mean of what they are together, which is no less than these are.
fn add_part(error: &mut Aov, motion: Option<Array2<f32>>) {
    let is_all = |name: &str| name == PictureLayer::Error.channels()[0];
    let Some(place) = error.channels.iter().position(|(name, _)| is_all(name)) else {
        return;
    };
    let (name, mut all) = error.channels.swap_remove(place);
    let motion = motion.unwrap_or_else(|| Array2::zeros(all.dim()));
    Zip::from(&mut all)
        .and(&motion)
        .for_each(|all: &mut f32, motion| *all = all.hypot(*motion));
    error.channels.push((MOTION.to_owned(), motion));
    error.channels.sort_by(|a, b| a.0.cmp(&b.0));
    error.channels.insert(0, (name, all));
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use ndarray::Array3;
    use niji_exchange::Attributes;
    use niji_exchange::ImageWindows;
    use niji_exchange::Provenance;
    use niji_exchange::Spectra;
    use niji_geometry::PixelRegion;
    use niji_radiometry::WavelengthGrid;

    use super::*;

    /// Pixels of a row, each with light of its own course.
    const WIDTH: usize = 200;

    fn image(lights: &[f64], depth_m: f32) -> SpectralImage {
        let row =
            |value: &dyn Fn(usize) -> f32| Array2::from_shape_fn((1, WIDTH), |(_, x)| value(x));
        let aov = |layer: PictureLayer, channels: Vec<(&str, Array2<f32>)>| Aov {
            name: layer.name().to_owned(),
            unit: layer.unit().to_owned(),
            channels: channels
                .into_iter()
                .map(|(name, it)| (name.to_owned(), it))
                .collect(),
        };
        let window = PixelRegion::frame(WIDTH as u32, 1);
        SpectralImage {
            wavelengths: WavelengthGrid::new(550.0, 10.0, 1).unwrap(),
            radiance: Array3::from_shape_fn((1, 1, WIDTH), |(_, _, x)| lights[x] as f32),
            aovs: vec![
                aov(PictureLayer::Depth, vec![("Z", row(&|_| depth_m))]),
                aov(
                    PictureLayer::Error,
                    vec![
                        ("Y", row(&|_| 5.0)),
                        ("shadow", row(&|_| 3.0)),
                        ("air", row(&|_| depth_m)),
                    ],
                ),
            ],
            spectra: Spectra::Full,
            windows: ImageWindows {
                data: window,
                display: window,
            },
            white_luminance_cd_m2: 1.0,
            world_to_camera: None,
            attributes: Attributes::new(),
            provenance: Provenance::default(),
        }
    }

    /// The mean of light by pixel and time over so many instants of [0, 1], and how far it is off beside what is told.
    fn off_and_told(
        n_instants: usize,
        (light, mean): (impl Fn(usize, f64) -> f64, impl Fn(usize) -> f64),
    ) -> Vec<[f64; 2]> {
        let mut sum = MeanOfInstants::new(n_instants);
        for index in 0..n_instants {
            let time = (index as f64 + 0.5) / n_instants as f64;
            let lights: Vec<f64> = (0..WIDTH).map(|x| light(x, time)).collect();
            sum.add(&image(&lights, index as f32));
        }
        let found = sum.finish();
        let to_y = luminance(&Array3::ones((1, 1, 1)), &found.wavelengths)[[0, 0]];
        let told = &found.aovs[1].channels;
        let told = &told.iter().find(|(name, _)| name == MOTION).unwrap().1;
        let off = |x: usize| (f64::from(found.radiance[[0, 0, x]]) - mean(x)).abs();
        (0..WIDTH)
            .map(|x| [off(x), f64::from(told[[0, x]]) / to_y])
            .collect()
    }

    #[test]
    fn an_edge_that_passes_is_off_by_no_more_than_is_told_and_by_about_half_of_it_in_the_mean() {
        let place = |x: usize| 0.2 + 0.6 * x as f64 / WIDTH as f64;
        let light = |x: usize, time: f64| f64::from(u8::from(time > place(x)));
        for n_instants in [5, 9, 33] {
            let found = off_and_told(n_instants, (light, |x| 1.0 - place(x)));
            assert!(
                found.iter().all(|[off, told]| *off < 1.001 * told + 1e-6),
                "{n_instants}"
            );
            let [off, told] = [0, 1].map(|of| found.iter().map(|it| it[of]).sum::<f64>());
            assert!(
                (0.42..0.51).contains(&(off / told)),
                "{n_instants} {}",
                off / told
            );
        }
    }

    #[test]
    fn smooth_light_is_told_with_more_than_it_is_off_and_a_line_is_exact() {
        // A bow that passes, from none to both of its sides.
        let rate = |x: usize| 2.0 * PI * x as f64 / WIDTH as f64;
        let light = |x: usize, time: f64| 1.0 + (rate(x) * time).sin();
        let mean = |x: usize| match rate(x) {
            0.0 => 1.0,
            rate => 1.0 + (1.0 - rate.cos()) / rate,
        };
        let mut before = f64::INFINITY;
        for n_instants in [5, 9, 33, 65] {
            let found = off_and_told(n_instants, (light, mean));
            assert!(
                found.iter().all(|[off, told]| *off < told + 1e-6),
                "{n_instants}"
            );
            let largest = found.iter().map(|it| it[1]).fold(0.0, f64::max);
            assert!(largest < 0.36 * before, "{n_instants} {largest}");
            before = largest;
        }
        let line = off_and_told(5, (|_, time: f64| 1.0 + time, |_| 1.5));
        assert!(line.iter().all(|[off, told]| *off < 1e-6 && *told < 1e-6));
    }

    #[test]
    fn causes_are_means_distances_those_of_the_frame() {
        let mut sum = MeanOfInstants::new(3);
        for depth_m in [1.0, 4.0, 10.0] {
            let mut image = image(&[1.0; WIDTH], depth_m);
            if depth_m > 1.0 {
                // As rows come back that were saved.
                image.aovs[1].channels.reverse();
            }
            sum.add(&image);
        }
        let found = sum.finish();
        assert_eq!(found.aovs[0].channels[0].1[[0, 0]], 4.0);
        let names: Vec<&str> = found.aovs[1]
            .channels
            .iter()
            .map(|it| it.0.as_str())
            .collect();
        assert_eq!(names, ["Y", "air", MOTION, "shadow"]);
        let [all, air, motion, shadow] =
            [0, 1, 2, 3].map(|it| found.aovs[1].channels[it].1[[0, 7]]);
        assert_eq!((air, motion, shadow), (5.0, 0.0, 3.0));
        assert_eq!(all, 5.0);
    }
}
