//! Memory and file sizes of stages, counted before anything runs.
//!
//! Files: what they hold is counted, 4 bytes a number, and headers are added. Drops (VDB, values of
//! active voxels alone): 4 n + 129 l + 1025 m + 8201 u bytes a grid, with n voxels, l leaves of 8^3, m
//! nodes of 16^3 leaves and u of 32^3 of those. Tables are stored as they are. Pictures are compressed:
//! for them the size is an upper bound, about twice what is written.
//! Memory: the program itself, and so many times what a stage reads, makes and keeps beside it. The
//! factors were measured (2 threads, resident memory at its highest, November 2026) on scenes from 13
//! to 630 MB.

use std::collections::BTreeSet;

use niji_atmosphere::ScatteringOrders;
use niji_exchange::AirConstituent;
use niji_exchange::AtmosphereTable;
use niji_exchange::DensityLaw;
use niji_exchange::DiffuseLight;
use niji_exchange::STRIP_BYTES;
use niji_exchange::n_moments;
use niji_render::LEAST_STEPS;
use niji_render::PictureLayer;
use niji_scatter::N_PHASE_ANGLES;
use niji_scatter::NumberOfAngles;
use niji_scatter::number_of_angles;

use crate::effect::Effect;
use crate::scene::Scene;
use crate::sections::Spectral;

use super::drop_summary::DropSummary;
use super::facts::Situation;
use super::scattering_need::ScatteringNeed;

const MIB: f64 = 1_048_576.0;

/// Memory of the program before it does anything.
const PROGRAM_BYTES: f64 = 13.5 * MIB;

/// Bytes of a number in a file.
const NUMBER_BYTES: f64 = 4.0;

/// A header with its provenance.
const HEADER_BYTES: f64 = 1500.0;

/// The table of f(z): two numbers at each of its angles, whatever the scene.
const AIRY_FILE_BYTES: f64 = 108_981.0;

/// Bytes of a node while a plan asks where drops are, which every stage does.
const PLANNED_NODE_BYTES: f64 = 60.0;

/// What following the drops of a fountain takes.
const FOUNTAIN_BYTES: f64 = 14.0 * MIB;

/// Candidates of angles that a scattering table is chosen from; for exact theories, the series of the
/// drops that are computed at once besides; and light of every radius before it is averaged.
const SCATTER_WORK_BYTES: f64 = 12.0 * MIB;
const SERIES_BYTES: f64 = 20.0 * MIB;
const RADIUS_BYTES: f64 = 1.2 * MIB;

/// Rays in flight and what the renderer looks up, rows of the table that rays met among it.
const RENDER_WORK_BYTES: f64 = 96.0 * MIB;

/// Copies of a table while it is written, and while it is read.
const TABLE_COPIES: (f64, f64) = (2.1, 1.7);

/// What is in memory of a picture, and the part of it that is being compressed.
const PICTURE_COPIES: f64 = 1.5;

/// Rows of a picture that are made at a time, a tenth of it or less: as they are rendered, as layers, packed, and saved
/// if they take long; and pixels around them that others follow from. Of `rain-cell` all is 0.23, 0.47 and 0.63 GB at
/// 640 x 360, 1920 x 1080 and 3840 x 2160.
const STRIP_COPIES: f64 = 6.0;

/// Bytes of a node of drops: as the file's grids and the volume made of them, then in bricks of 9^3
/// nodes of four lanes and M2 once more.
const VOLUME_NODE_BYTES: f64 = 32.0;
const BRICK_NODE_BYTES: f64 = 20.0 * 729.0 / 512.0;

/// Planes of a picture besides the spectrum: RGB, both bows and the light of the air in XYZ,
/// transmittance, the sun's optical depth, distance, the error and its seven parts.
const PLANES: f64 = 3.0 + 9.0 + 3.0 + 8.0;

/// Memory and file of a stage, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Resources {
    pub(super) memory_bytes: u64,
    pub(super) file_bytes: u64,
}

impl Resources {
    fn new(memory_bytes: f64, file_bytes: f64) -> Self {
        Self {
            memory_bytes: memory_bytes as u64,
            file_bytes: file_bytes as u64,
        }
    }
}

/// Of the drop volume.
pub(super) fn drops(drops: &DropSummary, is_fountain: bool) -> Resources {
    let nodes = drops.n_nodes as f64;
    let followed = f64::from(u8::from(is_fountain)) * FOUNTAIN_BYTES;
    let memory = PROGRAM_BYTES + nodes * VOLUME_NODE_BYTES + followed;
    Resources::new(memory, drops.file_bytes as f64)
}

/// Of the table of Airy's integral.
pub(super) fn airy() -> Resources {
    Resources::new(PROGRAM_BYTES, AIRY_FILE_BYTES)
}

/// Of a scattering table for both polarizations, with so many angles.
pub(super) fn table(
    (need, angles): (&ScatteringNeed, &NumberOfAngles),
    situation: &Situation,
) -> Resources {
    let channels = 2.0 * situation.grid.len() as f64;
    let request = need.request(situation.grid, None);
    let of_phases = need.phase_functions.then(|| request.of_phase_functions());
    let phases = NumberOfAngles {
        all: N_PHASE_ANGLES,
        of_orders: Vec::new(),
    };
    let n_places = of_phases.map_or(0, |of_phases| of_phases.n_places(&phases));
    let n_places = (n_places + request.n_places(angles)) as f64;
    let n_parts = 1.0 + angles.of_orders.len() as f64 + f64::from(u8::from(need.phase_functions));
    let rows = n_parts * (need.effective_radius_um.len() * need.effective_variance.len()) as f64;
    // Each row of pixels is told where it is and which one it is; axes stand in the header.
    let axis = 20.0 * n_places / rows + 30.0 * rows.sqrt();
    let values = channels * NUMBER_BYTES * n_places + 16.0 * rows;
    let file = values + n_parts * (axis + 2.0 * HEADER_BYTES + 24.0 * channels);
    let series = if need.theory.is_exact() {
        SERIES_BYTES
    } else {
        0.0
    };
    let memory = PROGRAM_BYTES
        + PLANNED_NODE_BYTES * situation.drops.n_nodes as f64
        + SCATTER_WORK_BYTES
        + series
        + RADIUS_BYTES * need.effective_radius_um.len() as f64
        + TABLE_COPIES.0 * file;
    Resources::new(memory, file)
}

/// Of the air's table; `orders` is how finely light of higher orders will be solved, which the table at
/// hand holds coarsely, and of fewer wavelengths.
pub(super) fn atmosphere(
    (table, orders): (&AtmosphereTable, Option<ScatteringOrders>),
    situation: &Situation,
) -> Resources {
    let n_wavelengths = situation.grid.len() as f64;
    let more = n_wavelengths / table.wavelengths.len() as f64;
    let of_constituent = |air: &AirConstituent| {
        let reach = match air.law {
            DensityLaw::Exponential => air.reach_m.len() as f64,
            DensityLaw::Linear => 0.0,
        };
        let axes = air.reach_m.nrows() + air.reach_m.ncols() + air.phase_angle_rad.len();
        let numbers = reach + more * air.phase_sr1.len() as f64 + 2.0 * n_wavelengths;
        NUMBER_BYTES * numbers + 20.0 * (axes as f64 + n_wavelengths) + 3.0 * HEADER_BYTES
    };
    let constituents: f64 = table.constituents.iter().map(of_constituent).sum();
    let finer = |(light, orders): (&DiffuseLight, ScatteringOrders)| {
        let heights = (orders.n_layers + 1) as f64 / light.height_m.len() as f64;
        let degrees = n_moments(orders.max_degree) as f64 / n_moments(light.max_degree) as f64;
        NUMBER_BYTES * more * light.moments.len() as f64 * heights * degrees
    };
    let diffuse = table.diffuse.as_ref().zip(orders).map_or(0.0, finer);
    let file = constituents + 2.0 * NUMBER_BYTES * n_wavelengths + HEADER_BYTES + diffuse;
    Resources::new(PROGRAM_BYTES + 2.0 * file, file)
}

/// Angles of a scattering table, chosen as the stage chooses them, by the wavelengths of bounds. Where rows between those
/// of the plan turn out to be needed, it gets larger.
pub(super) fn angles(need: &ScatteringNeed, situation: &Situation) -> NumberOfAngles {
    // What is wrong with a need without angles is said by its refusal.
    number_of_angles(&need.request(situation.bins, None)).unwrap_or_default()
}

/// What the stage would say of the table before it computes any light; `None` if it makes it.
pub(super) fn refusal(
    (need, angles): (&ScatteringNeed, &NumberOfAngles),
    situation: &Situation,
) -> Option<niji_scatter::Error> {
    let request = need.request(situation.grid, None);
    let sound = request.check().and_then(|()| request.check_size(angles));
    sound.err()
}

/// Whether all of a picture is in memory before it is written: the mean of several instants, or one whose spectra are
/// packed as all of its pixels allow.
pub(super) fn is_pictured_whole(scene: &Scene, is_blurred: bool) -> bool {
    is_blurred || scene.picture.spectral != Spectral::Full
}

/// Of the picture with all its layers; its file is compressed, and smaller.
pub(super) fn picture(
    scene: &Scene,
    situation: &Situation,
    (on, table): (&BTreeSet<Effect>, Option<Resources>),
) -> Resources {
    let overscan_px = 2 * scene.camera.overscan_px;
    let size_px = [situation.camera.width_px(), situation.camera.height_px()];
    let [width, height] = size_px.map(|size| f64::from(size + overscan_px));
    // Light of the surroundings and of further orders in XYZ, distances of surfaces.
    let is_lit = scene.albedos().next().is_some();
    let layers = on.iter().filter_map(|effect| effect.row().layer);
    let layers = layers.filter(|it| is_lit || *it != PictureLayer::LitSurface);
    let n_more: usize = layers.map(|layer| layer.channels().len()).sum();
    let surface = f64::from(u8::from(scene.has_surfaces()));
    let planes = situation.grid.len() as f64 + PLANES + n_more as f64 + surface;
    let picture = NUMBER_BYTES * planes * width * height;
    let strip = (picture / f64::from(LEAST_STEPS)).min(STRIP_BYTES as f64);
    let of_picture = if is_pictured_whole(scene, on.contains(&Effect::MotionBlur)) {
        PICTURE_COPIES * picture
    } else {
        0.0
    };
    // Drops keep a second way of the light, and the table both its polarizations.
    let n_mirrored = f64::from(u8::from(on.contains(&Effect::ReflectionBow)));
    let bricks = BRICK_NODE_BYTES * (1.0 + n_mirrored);
    let nodes = situation.drops.n_nodes as f64 * (VOLUME_NODE_BYTES + bricks);
    let table_copies = TABLE_COPIES.1 + 2.0 * n_mirrored;
    let memory = PROGRAM_BYTES
        + RENDER_WORK_BYTES
        + STRIP_COPIES * strip
        + of_picture
        + nodes
        + table.map_or(0.0, |table| table_copies * table.file_bytes as f64);
    Resources::new(memory, picture)
}
