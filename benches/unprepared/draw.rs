//! Scenes drawn by a seed: what people write, with numbers that nobody chose.

use std::fmt::Write as _;

/// Shapes of drops, each of which is drawn once before any is drawn twice.
const SHAPES: [fn(&mut Dice, Ahead) -> String; 8] = [
    uniform, gradient, shaft, cell, fountain, waterfall, fog, spray,
];

/// Where the camera looks.
#[derive(Clone, Copy)]
struct Ahead {
    /// East and south of unit length together.
    towards: [f64; 2],
}

impl Ahead {
    /// A place on the ground so far away, as TOML has it.
    fn at(self, distance_m: f64) -> [f64; 2] {
        self.towards.map(|it| distance_m * it)
    }
}

/// Numbers that follow from a seed (Steele, Lea and Flood 2014, SplitMix64).
pub(crate) struct Dice(u64);

impl Dice {
    /// Numbers of a seed: the first 16 hexadecimal digits of a text, as the hash of a commit.
    pub(crate) fn new(seed: &str) -> Option<Self> {
        u64::from_str_radix(seed.get(..16.min(seed.len()))?, 16)
            .ok()
            .map(Self)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// As likely within one factor as within another.
    fn of_any_size(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn one_in(&mut self, n: u64) -> bool {
        self.bits().is_multiple_of(n)
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[(self.bits() % all.len() as u64) as usize]
    }

    fn gusts(&mut self, largest_eddy_m: f64) -> String {
        if self.one_in(2) {
            return String::new();
        }
        format!(
            "turbulence = {{ strength = {:.2}, eddy_m = {:.1}, seed = {} }}\n",
            self.between(0.1, 0.9),
            self.of_any_size(0.2 * largest_eddy_m, largest_eddy_m),
            self.bits() % 100
        )
    }
}

/// So many scenes, as texts, by number.
pub(crate) fn scenes(dice: &mut Dice, n_scenes: usize) -> Vec<String> {
    (0..n_scenes)
        .map(|index| {
            let shape = SHAPES.get(index).copied();
            let shape = shape.unwrap_or_else(|| dice.one_of(&SHAPES));
            scene(dice, index + 1, shape)
        })
        .collect()
}

fn scene(dice: &mut Dice, number: usize, shape: fn(&mut Dice, Ahead) -> String) -> String {
    let sun_deg = dice.between(0.5, 40.0);
    let sun_azimuth_deg = dice.between(0.0, 360.0);
    let view_azimuth_deg = (sun_azimuth_deg + 180.0 + dice.between(-25.0, 25.0)).rem_euclid(360.0);
    let view_deg = dice.between(-3.0, 22.0);
    let (east, north) = view_azimuth_deg.to_radians().sin_cos();
    let ahead = Ahead {
        towards: [east, -north],
    };
    let mut text = format!(
        "format = 1\nname = \"drawn-{number}\"\n\n\
         [sun]\nelevation_deg = {sun_deg:.1}\nazimuth_deg = {sun_azimuth_deg:.0}\n\n\
         [camera]\nposition_m = [0.0, {:.1}, 0.0]\nazimuth_deg = {view_azimuth_deg:.0}\n\
         elevation_deg = {view_deg:.1}\nhorizontal_fov_deg = {:.1}\nwidth_px = 64\nheight_px = 48\n\n\
         [drops]\n{}\n",
        dice.of_any_size(1.5, 40.0),
        dice.of_any_size(12.0, 110.0),
        shape(dice, ahead),
    );
    if !dice.one_in(5) {
        let mut constituents = vec!["\"rayleigh\""];
        constituents.extend(dice.one_in(2).then_some("\"ozone\""));
        let haze = dice.one_in(2).then(|| {
            let kind = dice.one_of(&["clear", "rural", "maritime", "urban"]);
            let seen = dice
                .one_in(2)
                .then(|| format!("visibility_km = {:.1}\n", dice.of_any_size(3.0, 80.0)));
            format!("aerosol = \"{kind}\"\n{}", seen.unwrap_or_default())
        });
        constituents.extend(haze.as_ref().map(|_| "\"aerosol\""));
        let _ = write!(
            text,
            "[air]\nconstituents = [{}]\n{}\n",
            constituents.join(", "),
            haze.unwrap_or_default()
        );
    }
    let _ = write!(
        text,
        "[ground]\nalbedo = {:.2}\n\n[picture]\nexposure_ev = {:.1}\n",
        dice.between(0.03, 0.5),
        dice.between(-1.0, 3.0)
    );
    text
}

/// A box around a place ahead, from the ground up, with its longest side.
fn upright_box(dice: &mut Dice, ahead: Ahead, distance_m: f64) -> (String, f64) {
    let [x, z] = ahead.at(distance_m);
    let [width, depth, height] = [(0.4, 1.2), (0.1, 0.6), (0.2, 0.8)]
        .map(|(low, high)| distance_m * dice.between(low, high));
    let text = format!(
        "box_min_m = [{:.1}, 0.0, {:.1}]\nbox_max_m = [{:.1}, {height:.1}, {:.1}]\n",
        x - 0.5 * width,
        z - 0.5 * depth,
        x + 0.5 * width,
        z + 0.5 * depth
    );
    (text, width.max(height))
}

fn uniform(dice: &mut Dice, ahead: Ahead) -> String {
    let distance_m = dice.of_any_size(20.0, 2000.0);
    let (sides, longest_m) = upright_box(dice, ahead, distance_m);
    let radius_um = dice.of_any_size(8.0, 1000.0);
    format!(
        "shape = \"uniform\"\n{sides}\
         law = {{ hansen-travis = {{ effective_radius_um = {radius_um:.1}, effective_variance = {:.3} }} }}\n\
         number_density_m3 = {:.4}\nvoxel_m = {:.3}\n",
        dice.between(0.01, 0.2),
        number_of(dice.of_any_size(0.02, 1.5), (longest_m, radius_um)),
        longest_m / 16.0
    )
}

/// Drops in a cubic metre that make an optical depth across a length.
fn number_of(depth: f64, (length_m, radius_um): (f64, f64)) -> f64 {
    depth / (2.0 * std::f64::consts::PI * (1e-6 * radius_um).powi(2) * length_m)
}

fn gradient(dice: &mut Dice, ahead: Ahead) -> String {
    let distance_m = dice.of_any_size(20.0, 1000.0);
    let (sides, longest_m) = upright_box(dice, ahead, distance_m);
    let radii_um = [0, 1].map(|_| dice.of_any_size(15.0, 1200.0));
    let numbers = radii_um.map(|it| number_of(dice.of_any_size(0.05, 1.0), (longest_m, it)));
    format!(
        "shape = \"gradient\"\n{sides}axis = \"y\"\n\
         radius_at_min_um = {:.1}\nradius_at_max_um = {:.1}\n\
         number_density_at_min_m3 = {:.4}\nnumber_density_at_max_m3 = {:.4}\nvoxel_m = {:.3}\n",
        radii_um[0],
        radii_um[1],
        numbers[0],
        numbers[1],
        longest_m / 24.0
    )
}

fn shaft(dice: &mut Dice, ahead: Ahead) -> String {
    let distance_m = dice.of_any_size(400.0, 5000.0);
    let [x, z] = ahead.at(distance_m);
    let radius_m = distance_m * dice.between(0.15, 0.6);
    let footprint = if dice.one_in(2) {
        format!("{{ column = {{ radius_m = {radius_m:.0} }} }}")
    } else {
        let depth_m = radius_m * dice.between(0.3, 2.0);
        let width_m = 2.0 * radius_m;
        format!("{{ box = {{ width_x_m = {width_m:.0}, width_z_m = {depth_m:.0} }} }}")
    };
    format!(
        "shape = \"rain-shaft\"\nrain_rate_mm_h = {:.1}\nfootprint = {footprint}\n\
         center_xz_m = [{x:.0}, {z:.0}]\nbase_y_m = 0.0\ntop_y_m = {:.0}\nedge_m = {:.0}\nvoxel_m = {:.1}\n{}",
        dice.of_any_size(0.5, 100.0),
        dice.between(500.0, 2500.0),
        radius_m * dice.between(0.05, 0.3),
        radius_m / 12.0,
        dice.gusts(radius_m)
    )
}

fn cell(dice: &mut Dice, ahead: Ahead) -> String {
    let distance_m = dice.of_any_size(800.0, 6000.0);
    let [x, z] = ahead.at(distance_m);
    let radius_m = distance_m * dice.between(0.15, 0.5);
    format!(
        "shape = \"rain-cell\"\nmax_rain_rate_mm_h = {:.1}\nradius_m = {radius_m:.0}\n\
         center_xz_m = [{x:.0}, {z:.0}]\nbase_y_m = 0.0\ntop_y_m = {:.0}\n\
         wind_shear_xz_1_s = [{:.4}, {:.4}]\nvoxel_m = {:.1}\n{}",
        dice.of_any_size(1.0, 80.0),
        dice.between(800.0, 3500.0),
        dice.between(-0.002, 0.002),
        dice.between(-0.002, 0.002),
        radius_m / 12.0,
        dice.gusts(radius_m)
    )
}

fn fountain(dice: &mut Dice, ahead: Ahead) -> String {
    let [x, z] = ahead.at(dice.of_any_size(3.0, 40.0));
    let speed_m_s = dice.of_any_size(5.0, 18.0);
    let height_m = speed_m_s * speed_m_s / 19.6;
    format!(
        "shape = \"fountain\"\nnozzle_m = [{x:.2}, 0.3, {z:.2}]\nring_radius_m = {:.2}\n\
         speed_m_s = {speed_m_s:.1}\nelevation_deg = {:.0}\nspread_deg = {:.0}\nflow_kg_s = {:.2}\n\
         effective_radius_um = {:.0}\neffective_variance = {:.2}\nwind_xz_m_s = [{:.1}, {:.1}]\n\
         basin_y_m = 0.0\nvoxel_m = {:.3}\n",
        dice.between(0.05, 0.6),
        dice.between(50.0, 88.0),
        dice.between(4.0, 20.0),
        dice.of_any_size(0.05, 10.0),
        dice.of_any_size(60.0, 900.0),
        dice.between(0.02, 0.25),
        dice.between(-2.0, 2.0),
        dice.between(-2.0, 2.0),
        height_m / 20.0
    )
}

fn waterfall(dice: &mut Dice, ahead: Ahead) -> String {
    let distance_m = dice.of_any_size(40.0, 1500.0);
    let [x, z] = ahead.at(distance_m);
    let height_m = distance_m * dice.between(0.1, 0.6);
    format!(
        "shape = \"waterfall\"\nfoot_m = [{x:.0}, 0.0, {z:.0}]\nazimuth_deg = {:.0}\nheight_m = {height_m:.0}\n\
         width_m = {:.0}\nflow_kg_s = {:.0}\nsplash_fraction = {:.3}\nmist_fraction = {:.4}\n\
         curtain_effective_radius_um = {:.0}\nsplash_effective_radius_um = {:.0}\n\
         mist_effective_radius_um = {:.0}\nwind_xz_m_s = [{:.1}, {:.1}]\nvoxel_m = {:.2}\n",
        dice.between(0.0, 360.0),
        height_m * dice.between(0.2, 1.5),
        height_m * dice.of_any_size(3.0, 60.0),
        dice.between(0.02, 0.12),
        dice.of_any_size(0.001, 0.01),
        dice.between(600.0, 1500.0),
        dice.between(150.0, 400.0),
        dice.between(20.0, 80.0),
        dice.between(-2.0, 2.0),
        dice.between(-2.0, 2.0),
        height_m / 20.0
    )
}

fn fog(dice: &mut Dice, ahead: Ahead) -> String {
    let distance_m = dice.of_any_size(40.0, 800.0);
    let (sides, longest_m) = upright_box(dice, ahead, distance_m);
    format!(
        "shape = \"fog-bank\"\n{sides}voxel_m = {:.2}\nprofile = \"{}\"\nmax_lwc_g_m3 = {:.3}\n\
         max_effective_radius_um = {:.1}\neffective_variance = {:.2}\n{}",
        longest_m / 24.0,
        dice.one_of(&["adiabatic", "ground-based", "even"]),
        dice.of_any_size(0.01, 0.3),
        dice.of_any_size(4.0, 30.0),
        dice.between(0.03, 0.2),
        dice.gusts(longest_m / 3.0)
    )
}

fn spray(dice: &mut Dice, ahead: Ahead) -> String {
    let distance_m = dice.of_any_size(20.0, 300.0);
    let (sides, longest_m) = upright_box(dice, ahead, distance_m);
    format!(
        "shape = \"sea-spray\"\n{sides}surface_lwc_g_m3 = {:.2}\nscale_height_m = {:.1}\n\
         median_radius_um = {:.0}\ngeometric_standard_deviation = {:.2}\nvoxel_m = {:.2}\n{}",
        dice.of_any_size(0.05, 2.0),
        dice.of_any_size(2.0, 15.0),
        dice.of_any_size(20.0, 300.0),
        dice.between(1.2, 2.0),
        longest_m / 24.0,
        dice.gusts(longest_m / 4.0)
    )
}
