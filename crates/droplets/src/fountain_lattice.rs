//! Water left on a lattice by drops that pass, as area moments.
//!
//! Steady jets: a stream of F kg/s whose drops stay h seconds near a place keeps F h of water there.
//! Each part of a flight leaves F h at its middle, shared among the 8 nodes around it with trilinear
//! weights; a node then has
//! M3 = W/(rho V),   M2 = sum M3_i/r_i,   M4 = sum M3_i r_i,   r_e = M3/M2,   v_e = M4 M2/M3² - 1
//! `W` water of the node, `V` volume of a voxel, rho = (4/3) pi rho_w, `r_i` radius of the drops of
//! flight i. Weights add up to 1, also at the faces, where all of what lies beyond the outermost
//! nodes goes to them: the lattice holds sum F h exactly, which is the flow times the mean time of
//! flight.
//!
//! The lattice is cut into slabs along x, each filled by one thread with the flights in their order,
//! so that no sum depends on the number of threads.

use glam::DVec3;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::MAX_EFFECTIVE_VARIANCE;
use niji_sizes::SizeMoments;
use niji_sizes::liquid_water_g_m3;
use rayon::prelude::*;

use crate::Error;
use crate::fountain_flight::Launch;

/// Slabs of the lattice: work for so many threads.
const N_SLABS: usize = 16;

/// Flights that one thread follows at a time.
const FLIGHTS_TOGETHER: usize = 128;

/// Such bunches of flights that are held in memory at a time: 4096 flights, some 50 MB.
const BUNCHES_AT_A_TIME: usize = 32;

/// Distance of the parcels along a flight in voxels. The extinction of a node is then 0.5 % off in the
/// mean from that of parcels a tenth as far apart.
const PARCEL_VOXELS: f64 = 0.8;

/// A flight and the water that takes it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stream {
    /// The drops.
    pub(crate) launch: Launch,
    /// Flow (kg/s).
    pub(crate) flow_kg_s: f64,
}

/// Water (g) and its products with the radius (um) to the power -1 and 1.
type Sums = [f64; 3];

/// Water that a part of a flight leaves: where, in voxels from node (0, 0, 0), and how much.
#[derive(Debug, Clone, Copy)]
struct Parcel {
    place: DVec3,
    water_g: f64,
    radius_um: f64,
}

/// A lattice that collects water.
#[derive(Debug)]
pub(crate) struct Lattice {
    frame: Frame,
    sums: Vec<Sums>,
}

/// The nodes of a lattice.
#[derive(Debug, Clone, Copy)]
struct Frame {
    grid: GridBox,
    n_nodes: [usize; 3],
}

impl Lattice {
    /// Lay streams out over a box.
    ///
    /// # Errors
    /// As [`GridBox::n_nodes`].
    pub(crate) fn of_streams(grid: GridBox, streams: &[Stream]) -> Result<Self, Error> {
        let n_nodes = grid.n_nodes()?.map(|count| count as usize);
        let frame = Frame { grid, n_nodes };
        let mut sums = vec![[0.0; 3]; n_nodes.iter().product()];
        let slab_nodes = frame.slab_planes() * n_nodes[1] * n_nodes[2];
        for some in streams.chunks(FLIGHTS_TOGETHER * BUNCHES_AT_A_TIME) {
            let bunches = some.par_chunks(FLIGHTS_TOGETHER);
            let by_slab: Vec<[Vec<Parcel>; N_SLABS]> = bunches
                .map(|streams| frame.parcels_by_slab(streams))
                .collect();
            let slabs = sums.par_chunks_mut(slab_nodes).enumerate();
            slabs.for_each(|(slab, nodes)| {
                for parcel in by_slab.iter().flat_map(|bunch| &bunch[slab]) {
                    frame.leave(parcel, slab, nodes);
                }
            });
        }
        Ok(Self { frame, sums })
    }

    /// The drops as a mode without a name.
    ///
    /// # Errors
    /// As [`DropMode::from_fn`].
    pub(crate) fn mode(&self) -> Result<DropMode, Error> {
        let [nx, ny, nz] = self.frame.n_nodes;
        let mode = DropMode::from_fn("", &self.frame.grid, |position| {
            let place = (position - self.frame.grid.min) / self.frame.grid.voxel_m;
            let [x, y, z] = place.to_array().map(|index| index as usize);
            let node = (x.min(nx - 1) * ny + y.min(ny - 1)) * nz + z.min(nz - 1);
            self.drops(self.sums[node])
        })?;
        Ok(mode)
    }

    /// The drops of a node of this water.
    fn drops(&self, [over_radius, water_g, times_radius]: Sums) -> Drops {
        if water_g <= 0.0 {
            return Drops::NONE;
        }
        let per_volume = 1.0 / (liquid_water_g_m3(1.0) * self.frame.grid.voxel_m.powi(3));
        let [m2, m3, m4] = [over_radius, water_g, times_radius].map(|sum| sum * per_volume);
        let effective_variance = ((m4 / m3) * (m2 / m3) - 1.0).max(0.0);
        // A cubic metre taken as one drop: the gamma law that has these sums counts the drops.
        let moments = SizeMoments {
            mean_r_um: (m3 / m2) * (1.0 - 2.0 * effective_variance),
            mean_r2_um2: m2,
            mean_r3_um3: m3,
            effective_variance,
        };
        let widest = f64::from(MAX_EFFECTIVE_VARIANCE);
        Drops::of_law(&moments.with_variance_at_most(widest), 1.0)
    }
}

impl Frame {
    /// Planes of nodes across x that make a slab.
    fn slab_planes(&self) -> usize {
        self.n_nodes[0].div_ceil(N_SLABS)
    }

    /// The parcels of some flights, in their order, by the slabs that they touch: one or two.
    fn parcels_by_slab(&self, streams: &[Stream]) -> [Vec<Parcel>; N_SLABS] {
        let mut slabs: [Vec<Parcel>; N_SLABS] = std::array::from_fn(|_| Vec::new());
        let planes = self.slab_planes();
        let last = self.n_nodes[0] - 1;
        for stream in streams {
            self.parcels(stream, |parcel| {
                let plane = parcel.place.x as usize;
                let (slab, next) = (plane / planes, (plane + 1).min(last) / planes);
                slabs[slab].push(parcel);
                if next != slab {
                    slabs[next].push(parcel);
                }
            });
        }
        slabs
    }

    /// The parcels that a flight leaves.
    fn parcels(&self, stream: &Stream, mut visit: impl FnMut(Parcel)) {
        let voxel_m = self.grid.voxel_m;
        let last = DVec3::from(self.n_nodes.map(|count| (count - 1) as f64));
        stream.launch.fly(|step| {
            let length_m = step.start.0.distance(step.end.0);
            let n_parcels = (length_m / (PARCEL_VOXELS * voxel_m)).ceil().max(1.0);
            let water_g = 1e3 * stream.flow_kg_s * step.time_s / n_parcels;
            for index in 0..n_parcels as usize {
                let position = step.place((index as f64 + 0.5) / n_parcels);
                let place = (position - self.grid.min) / voxel_m - 0.5;
                visit(Parcel {
                    place: place.clamp(DVec3::ZERO, last),
                    water_g,
                    radius_um: 1e6 * stream.launch.radius_m,
                });
            }
        });
    }

    /// Leave a parcel on those of its 8 nodes that lie in a slab.
    fn leave(&self, parcel: &Parcel, slab: usize, nodes: &mut [Sums]) {
        let [ny, nz] = [self.n_nodes[1], self.n_nodes[2]];
        let first_plane = slab * self.slab_planes();
        let floor = parcel.place.floor();
        let [x, y, z] = floor.to_array().map(|index| index as usize);
        let up = (parcel.place - floor).to_array();
        let parts = [
            parcel.water_g / parcel.radius_um,
            parcel.water_g,
            parcel.water_g * parcel.radius_um,
        ];
        for corner in 0..8_usize {
            let [dx, dy, dz] = [corner >> 2, corner >> 1 & 1, corner & 1];
            let share = |axis: usize, upper| if upper == 1 { up[axis] } else { 1.0 - up[axis] };
            let weight = share(0, dx) * share(1, dy) * share(2, dz);
            // At the highest node of an axis there is none above, and its weight is 0.
            if weight > 0.0 && x + dx >= first_plane {
                let node = ((x + dx - first_plane) * ny + y + dy) * nz + z + dz;
                if let Some(sums) = nodes.get_mut(node) {
                    for (sum, part) in sums.iter_mut().zip(parts) {
                        *sum += weight * part;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
#[path = "fountain_lattice_tests.rs"]
mod tests;
