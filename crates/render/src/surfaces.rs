//! Surfaces that end view rays: what is behind them is hidden.
//!
//! d(x, y) = D[floor(y H / h), floor(x W / w)]
//! `D` distances along the rays [m], `H` x `W` pixels, of a picture of `h` x `w` pixels in which
//! (x, y) is a point. The nearest pixel counts and nothing is mixed: between a tree and the sky
//! behind it there is no surface at half the distance. A map finer than the picture serves rays that
//! share a pixel, one by one; in one of the picture's own pixels edges run through pixels as those around them say
//! (`map_edge`), unless its distances are those of whole pixels. A mesh or terrain ends every ray for itself, where it first meets a triangle; of all
//! the nearest counts. What has an albedo is lit (`surface_light`); the rest is black.

use glam::DVec3;
use ndarray::Array2;
use niji_geometry::Camera;
use niji_geometry::CoveredSlopes;
use niji_geometry::HeightField;
use niji_geometry::MeshBvh;
use niji_geometry::Ray;

use crate::error::Error;
use crate::map_edge;
use crate::paint::Painted;
use crate::paint::SurfaceColor;
use crate::water_surface::Foot;
use crate::water_surface::WaterSurface;

/// A surface in the world (m), seen from both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Where it is.
    pub shape: SolidShape,
    /// What it gives back, as much in all directions; `None` for one that hides and nothing else.
    pub albedo: Option<SurfaceColor>,
}

/// Where a surface is.
#[derive(Clone, Debug, PartialEq)]
pub enum SolidShape {
    /// Triangles.
    Mesh(MeshBvh),
    /// Terrain.
    Heights(HeightField),
}

/// A place on a lit surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Face {
    /// Unit normal of the triangle, towards the eye.
    pub(crate) side: DVec3,
    /// Unit normal by which light is taken, of a smooth surface where that is known.
    pub(crate) normal: DVec3,
    /// Of which solid.
    pub(crate) solid: usize,
    /// Which triangle of it, where it is a mesh.
    pub(crate) triangle: u32,
    /// What of its paint, where it is painted.
    pub(crate) painted: Painted,
}

/// A place at which a ray meets a solid.
struct Met {
    distance_m: f64,
    /// Of the triangle, and of the smooth surface.
    normals: [DVec3; 2],
    triangle: u32,
    painted: Painted,
}

impl SolidShape {
    /// Where a ray first meets it.
    fn nearest(&self, ray: &Ray) -> Option<Met> {
        // One on which the eye itself lies does not blind it.
        match self {
            Self::Mesh(mesh) => {
                let hit = mesh.nearest(ray, 0.0)?;
                Some(Met {
                    distance_m: hit.distance_m,
                    normals: [hit.normal, hit.smooth_normal],
                    triangle: hit.triangle_index as u32,
                    painted: hit.painted,
                })
            }
            Self::Heights(field) => {
                let hit = field.nearest(ray, 0.0)?;
                Some(Met {
                    distance_m: hit.distance_m,
                    normals: [hit.normal, hit.smooth_normal],
                    triangle: 0,
                    painted: Painted::default(),
                })
            }
        }
    }

    fn is_met(&self, ray: &Ray) -> bool {
        match self {
            Self::Mesh(mesh) => mesh.is_met(ray, 0.0),
            Self::Heights(field) => field.is_met(ray, 0.0),
        }
    }
}

/// The surfaces of a picture: a map of distances, meshes, terrain.
///
/// ```
/// use ndarray::array;
/// use niji_render::Surfaces;
/// // A wall 12 m away, sky above it.
/// let surfaces = Surfaces::new(array![[f32::INFINITY, f32::NAN], [12.0, 12.0]])?;
/// assert!(Surfaces::new(array![[-1.0]]).is_err());
/// # drop(surfaces);
/// # Ok::<(), niji_render::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surfaces {
    distance_m: Option<Array2<f32>>,
    solids: Vec<Solid>,
    stands_for_pixels: bool,
}

impl Surfaces {
    /// Surfaces by row and column: distances along the view rays in metres, infinite or NaN for the
    /// sky.
    ///
    /// # Errors
    /// [`Error::SurfaceDistance`] for a distance below 0, [`Error::NoSurfaces`] for a map that is
    /// empty or NaN everywhere.
    pub fn new(mut distance_m: Array2<f32>) -> Result<Self, Error> {
        if distance_m.iter().all(|distance| distance.is_nan()) {
            return Err(Error::NoSurfaces);
        }
        for ((y, x), distance) in distance_m.indexed_iter_mut() {
            if distance.is_nan() {
                *distance = f32::INFINITY;
            }
            if *distance < 0.0 {
                let found_m = *distance;
                return Err(Error::SurfaceDistance { x, y, found_m });
            }
        }
        Ok(Self {
            distance_m: Some(distance_m),
            solids: Vec::new(),
            stands_for_pixels: false,
        })
    }

    /// The triangles of a mesh in the world (m), which hide and nothing else.
    #[must_use]
    pub fn of_mesh(mesh: MeshBvh) -> Self {
        Self::default().with_mesh(mesh)
    }

    /// The same with the triangles of such a mesh before or behind them.
    #[must_use]
    pub fn with_mesh(self, mesh: MeshBvh) -> Self {
        self.with(Solid {
            shape: SolidShape::Mesh(mesh),
            albedo: None,
        })
    }

    /// The same with a surface before or behind them.
    #[must_use]
    pub fn with(mut self, solid: Solid) -> Self {
        self.solids.push(solid);
        self.stands_for_pixels = false;
        self
    }

    /// What each of the solids gives back.
    pub(crate) fn albedos(&self) -> impl Iterator<Item = Option<&SurfaceColor>> {
        self.solids.iter().map(|solid| solid.albedo.as_ref())
    }

    /// Whether a ray meets any solid.
    pub(crate) fn are_met(&self, ray: &Ray) -> bool {
        self.solids.iter().any(|solid| solid.shape.is_met(ray))
    }

    /// Where each of the solids is.
    pub(crate) fn shapes(&self) -> impl Iterator<Item = &SolidShape> {
        self.solids.iter().map(|solid| &solid.shape)
    }

    /// Cover the slopes of sights, from a point along a horizontal unit vector, in which solids stand; terrain from its
    /// horizon down, whose tangent may be known of one solid.
    pub(crate) fn cover(
        &self,
        (origin, along): (DVec3, DVec3),
        known: Option<(usize, f64)>,
        covered: &mut CoveredSlopes,
    ) {
        for (index, solid) in self.solids.iter().enumerate() {
            match (&solid.shape, known) {
                (_, Some((known, horizon))) if known == index => {
                    covered.add([f64::NEG_INFINITY, horizon]);
                }
                (SolidShape::Mesh(mesh), _) => mesh.cover(origin, along, covered),
                (SolidShape::Heights(field), _) => {
                    let least = covered.gaps().next().map_or(0.0, |gap| gap.start);
                    let horizon = field.horizon(origin, along, least);
                    covered.add([f64::NEG_INFINITY, horizon]);
                }
            }
        }
    }

    /// The same map as distances of whole pixels, as those of a photograph are: each pixel has the light of the surface
    /// in its middle, so that an edge beside it is no error of its own.
    #[must_use]
    pub fn of_whole_pixels(self) -> Self {
        Self {
            stands_for_pixels: self.solids.is_empty(),
            ..self
        }
    }

    /// Do width and height have the ratio of the picture's, up to the rounding of a pixel?
    pub(crate) fn check_shape(&self, camera: &Camera) -> Result<(), Error> {
        let Some(distance_m) = &self.distance_m else {
            return Ok(());
        };
        let (height, width) = distance_m.dim();
        let expected = (camera.width_px(), camera.height_px());
        let (w, h) = (f64::from(expected.0), f64::from(expected.1));
        let pixel = 1.0 / w.min(h).min(width.min(height) as f64);
        let ratio = (width as f64 * h) / (height as f64 * w);
        if (ratio - 1.0).abs() <= pixel {
            return Ok(());
        }
        let found = (width, height);
        Err(Error::SurfaceShape { found, expected })
    }

    /// Distance along the ray through a point of a picture of `size` pixels, infinite for the sky, and the lit place
    /// there.
    fn end(&self, ray: &Ray, point: (f64, f64), size: (u32, u32)) -> (f64, Option<Face>) {
        let of_map = self.distance_m.as_ref();
        let of_map_m = of_map.map_or(f64::INFINITY, |map| {
            let is_of_pixels = map.dim() == (size.1 as usize, size.0 as usize);
            if is_of_pixels && !self.stands_for_pixels {
                map_edge::distance_m(map, point)
            } else {
                nearest_pixel_m(map, point, size)
            }
        });
        self.nearer_solid(ray, of_map_m)
    }

    /// Where a ray in the world ends at a solid, and the lit place there: maps of distances know of view rays only.
    pub(crate) fn sight(&self, ray: Ray) -> Sight {
        let (surface_m, face) = self.nearer_solid(&ray, f64::INFINITY);
        Sight {
            ray,
            surface_m,
            face,
            foot: None,
        }
    }

    /// Distance of the nearest solid along a ray that is nearer than a distance, which is kept otherwise, and the lit
    /// place there.
    fn nearer_solid(&self, ray: &Ray, within_m: f64) -> (f64, Option<Face>) {
        let mut end = (within_m, None);
        for (index, solid) in self.solids.iter().enumerate() {
            let Some(met) = solid.shape.nearest(ray) else {
                continue;
            };
            if met.distance_m < end.0 {
                let [side, normal] = if met.normals[0].dot(ray.direction) > 0.0 {
                    met.normals.map(|normal| -normal)
                } else {
                    met.normals
                };
                let face = Face {
                    side,
                    normal,
                    solid: index,
                    triangle: met.triangle,
                    painted: met.painted,
                };
                end = (met.distance_m, solid.albedo.as_ref().map(|_| face));
            }
        }
        end
    }
}

/// Distance at a point of a picture of `size` pixels in a map of it.
fn nearest_pixel_m(map: &Array2<f32>, (x_px, y_px): (f64, f64), size: (u32, u32)) -> f64 {
    let (height, width) = map.dim();
    let index = |place: f64, n_of_picture: u32, n: usize| {
        ((place * n as f64 / f64::from(n_of_picture)) as usize).min(n - 1)
    };
    let (x, y) = (index(x_px, size.0, width), index(y_px, size.1, height));
    f64::from(map[[y, x]])
}

/// A view ray and the surface that ends it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    /// The ray.
    pub(crate) ray: Ray,
    /// Distance of the surface (m); infinite where there is none.
    pub(crate) surface_m: f64,
    /// The place there, where it is lit.
    pub(crate) face: Option<Face>,
    /// The same, where it is water.
    pub(crate) foot: Option<Foot>,
}

/// What the eye sees.
#[derive(Clone, Copy)]
pub(crate) struct Eye<'a> {
    /// Where the rays go.
    pub(crate) camera: &'a Camera,
    /// Where they end.
    pub(crate) surfaces: Option<&'a Surfaces>,
    /// Water at which they end, too.
    pub(crate) water: Option<WaterSurface>,
}

impl Eye<'_> {
    /// Whether the surface in the middle of a pixel is that of all of it.
    pub(crate) fn sees_whole_pixels(&self) -> bool {
        self.surfaces.is_some_and(|it| it.stands_for_pixels)
    }

    /// The sight through a point of the picture, in pixels from its top left corner; `None` where the
    /// camera sees nothing.
    pub(crate) fn sight(&self, x_px: f64, y_px: f64) -> Option<Sight> {
        let ray = self.camera.ray(x_px, y_px)?;
        let size = (self.camera.width_px(), self.camera.height_px());
        let nothing = (f64::INFINITY, None);
        let (surface_m, face) = self
            .surfaces
            .map_or(nothing, |surfaces| surfaces.end(&ray, (x_px, y_px), size));
        let foot = self.water.and_then(|water| water.met(&ray));
        Some(match foot.filter(|foot| foot.distance_m < surface_m) {
            Some(foot) => Sight {
                ray,
                surface_m: foot.distance_m,
                face: None,
                foot: Some(foot),
            },
            None => Sight {
                ray,
                surface_m,
                face,
                foot: None,
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn a_map_of_another_size_gives_its_nearest_pixel() {
        let surfaces = Surfaces::new(array![[1.0, 2.0, 3.0], [4.0, 5.0, f32::NAN]]).unwrap();
        let map = surfaces.distance_m.unwrap();
        let size = (6, 4);
        for (point, expected) in [
            ((0.5, 0.5), 1.0),
            ((1.9, 1.9), 1.0),
            ((2.1, 2.1), 5.0),
            ((5.5, 0.5), 3.0),
            ((5.5, 3.5), f64::INFINITY),
            // The outer edge belongs to the last pixel.
            ((6.0, 0.0), 3.0),
        ] {
            // Stored values come back.
            assert_eq!(nearest_pixel_m(&map, point, size), expected, "{point:?}");
        }
    }

    #[test]
    fn maps_without_a_distance_or_below_0_are_refused() {
        for map in [Array2::zeros((0, 0)), Array2::from_elem((2, 2), f32::NAN)] {
            assert_eq!(Surfaces::new(map), Err(Error::NoSurfaces));
        }
        let (x, y, found_m) = (1, 0, -3.0);
        assert_eq!(
            Surfaces::new(array![[1.0, -3.0]]),
            Err(Error::SurfaceDistance { x, y, found_m })
        );
    }
}
