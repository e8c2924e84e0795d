//! What terrain sees around it, looked for at its nodes.
//!
//! x(P) = sum_i w_i x(P_i)
//! `x` tangents of the horizon that the terrain makes, the share of surfaces below it and what surfaces send; `P` point of the triangle of
//! nodes `P_i`, `w_i` its barycentric weights. A triangle is flat, so what it sees changes over it no faster than from
//! node to node. Each node looks once, when first asked; what it sees depends on no ray.

use std::sync::OnceLock;

use glam::DVec3;
use niji_geometry::HeightField;

use crate::sent_light::Senders;
use crate::sky_view::N_AZIMUTHS;

/// Nodes along a side of what is kept together.
const TILE: usize = 8;

/// What a place on terrain sees around it.
// f32: a few bytes for each of millions of nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PlaceView {
    /// Tangents of the horizon that the terrain makes, by azimuth.
    pub(crate) horizons: [f32; N_AZIMUTHS],
    /// Share of what lies below the horizon that surfaces are.
    pub(crate) below: f32,
    /// What surfaces send.
    pub(crate) senders: Senders,
}

type Tile = [OnceLock<PlaceView>; TILE * TILE];

/// A terrain whose nodes look around.
#[derive(Debug)]
pub(crate) struct TerrainView<'a> {
    pub(crate) field: &'a HeightField,
    /// Row by row.
    tiles: Vec<OnceLock<Box<Tile>>>,
}

impl<'a> TerrainView<'a> {
    /// One of which nobody has asked yet.
    pub(crate) fn new(field: &'a HeightField) -> Self {
        let (n_x, n_z) = field.size();
        let n_tiles = n_x.div_ceil(TILE) * n_z.div_ceil(TILE);
        Self {
            field,
            tiles: (0..n_tiles).map(|_| OnceLock::new()).collect(),
        }
    }

    /// What a point of the surface sees, where `look` tells it of a node.
    pub(crate) fn at(&self, point: DVec3, look: impl Fn(DVec3) -> PlaceView) -> PlaceView {
        let mut mean = PlaceView::default();
        for (node, weight) in self.field.nodes_around(point) {
            if weight <= 0.0 {
                continue;
            }
            let seen = self.of_node(node, &look);
            for (sum, horizon) in mean.horizons.iter_mut().zip(seen.horizons) {
                *sum += weight as f32 * horizon;
            }
            mean.below += weight as f32 * seen.below;
            mean.senders.add_all(&seen.senders, weight as f32);
        }
        mean
    }

    fn of_node(&self, (x, z): (usize, usize), look: impl Fn(DVec3) -> PlaceView) -> &PlaceView {
        let n_tiles_x = self.field.size().0.div_ceil(TILE);
        let tile = self.tiles[z / TILE * n_tiles_x + x / TILE]
            .get_or_init(|| Box::new([const { OnceLock::new() }; TILE * TILE]));
        tile[z % TILE * TILE + x % TILE].get_or_init(|| look(self.field.node(x, z)))
    }
}

#[cfg(test)]
mod tests {
    use niji_geometry::CoveredSlopes;
    use niji_geometry::HeightMap;
    use niji_geometry::Ray;

    use super::*;
    use crate::sky_view::Azimuth;
    use crate::sky_view::azimuths;
    use crate::sky_view::free_share;

    const N: usize = 41;
    const SPACING_M: f64 = 5.0;

    fn field(height: impl Fn(f64, f64) -> f64) -> HeightField {
        let nodes = (0..N * N).map(|index| ((index % N) as f64, (index / N) as f64));
        HeightField::new(HeightMap {
            size: (N, N),
            height_m: nodes.map(|(x, z)| height(x, z) as f32).collect(),
            spacing_m: SPACING_M,
            corner: DVec3::ZERO,
        })
        .unwrap()
    }

    fn look(field: &HeightField, from: DVec3) -> PlaceView {
        let origin = from + 1e-5 * DVec3::Y;
        let horizons = azimuths().map(|it| field.horizon(origin, it.along, 0.0) as f32);
        PlaceView {
            horizons: horizons.collect::<Vec<_>>().try_into().unwrap(),
            below: origin.x as f32,
            senders: Senders::default(),
        }
    }

    /// Points of the surface, with the normals of their triangles.
    fn places(field: &HeightField) -> Vec<(DVec3, DVec3)> {
        let side_m = (N - 1) as f64 * SPACING_M;
        let fractions =
            (1..400).map(|n| [0.7548, 0.5698].map(|step| (f64::from(n) * step).fract()));
        let rays = fractions.map(|[x, z]| Ray {
            origin: DVec3::new(x * side_m, 1e4, z * side_m),
            direction: DVec3::NEG_Y,
        });
        let met = rays.map(|ray| (field.nearest(&ray, 0.0).unwrap(), ray));
        met.map(|(hit, ray)| (ray.at(hit.distance_m), hit.normal))
            .collect()
    }

    /// Shares of the sky by nodes, and as the place itself sees it.
    fn shares(field: &HeightField) -> Vec<[f64; 2]> {
        let view = TerrainView::new(field);
        let of_place = |(point, side): (DVec3, DVec3)| {
            let known = view.at(point, |node| look(field, node));
            let own = look(field, point);
            [known, own].map(|it| {
                free_share(
                    (side, side),
                    |Azimuth { index, .. }, covered: &mut CoveredSlopes| {
                        covered.add([f64::NEG_INFINITY, f64::from(it.horizons[index])]);
                    },
                    |_| {},
                )
            })
        };
        places(field).into_iter().map(of_place).collect()
    }

    #[test]
    fn on_a_plane_every_place_sees_what_its_nodes_see() {
        let field = field(|x, z| 2.0 * x - 1.5 * z);
        for [found, own] in shares(&field) {
            assert!((found - own).abs() < 1e-4, "{found} {own}");
        }
        let view = TerrainView::new(&field);
        for (point, _) in places(&field) {
            let seen = view.at(point, |node| look(&field, node));
            assert!((f64::from(seen.below) - point.x).abs() < 1e-4);
        }
    }

    #[test]
    fn between_the_nodes_of_rough_ground_little_changes() {
        let bumps = |x: f64, z: f64| (0.9 * x + 0.4 * z).sin() * (1.3 * z - 0.3 * x).cos();
        let valley = |x: f64, _| 0.3 * (x - 20.0).powi(2);
        let cliff = |x: f64, z: f64| if x > 20.0 { 40.0 } else { 0.1 * z };
        let rough = field(|x, z| valley(x, z) + 5.0 * bumps(x, z));
        // Worst found 0.0013, 0.0134 and 0.0020 as RMS, 0.064 at a place: bumps as wide as seven cells, of slopes to 2.
        for (field, most) in [(field(valley), 0.002), (rough, 0.02), (field(cliff), 0.003)] {
            let shares = shares(&field);
            let squares = shares.iter().map(|[found, own]| (found - own).powi(2));
            let rms = (squares.sum::<f64>() / shares.len() as f64).sqrt();
            assert!(rms < most, "{rms}");
            assert!(shares.iter().any(|[_, own]| *own < 0.9));
        }
    }

    #[test]
    fn a_node_looks_once() {
        use std::cell::Cell;
        let field = field(|x, z| (x * z).sin());
        let view = TerrainView::new(&field);
        let n_looks = Cell::new(0);
        let count = |node| {
            n_looks.set(n_looks.get() + 1);
            look(&field, node)
        };
        let point = DVec3::new(12.0, 0.0, 33.0);
        let first = view.at(point, count);
        assert_eq!(n_looks.get(), 3);
        assert_eq!(view.at(point, count), first);
        assert_eq!(n_looks.get(), 3);
    }
}
