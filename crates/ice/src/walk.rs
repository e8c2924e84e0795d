//! One random path from the eye to the light.
//!
//! L = sum over its vertices of  w exp(-alpha d) f(sun) E_sun   +  w exp(-alpha d) L_sky  at its end
//! `w` product of the weights of the directions drawn, `d` way through ice so far, `f` what the vertex
//! sends of sunlight into the path [1/sr]. The sun is small, and no random path would find it;
//! everything else is found by the path itself. Inside ice radiance counts as that outside would, see
//! `diffuse_surface`: a camera in the ice sees the light that it would see through a flat window.

use std::f64::consts::PI;

use glam::DVec3;
use niji_geometry::Ray;

use crate::body::Body;
use crate::body::Crossing;
use crate::body::Way;
use crate::bubbles::Bubbles;
use crate::diffuse_surface::DiffuseSurface;
use crate::ground::Ground;
use crate::light::Light;
use crate::radiance_sum::RadianceSum;
use crate::sampler::Sampler;
use crate::sampler::VertexNumbers;
use crate::snow::Snow;
use crate::surface::Arrival;
use crate::surface::Scattered;
use crate::surface::Side;
use crate::surface::SurfaceAt;

/// From this vertex on a path goes on with [`SURVIVAL`] only.
const FIRST_ROULETTE: u32 = 64;
const SURVIVAL: f64 = 0.9;
/// No path has so many vertices: the chance is 0.9^4000.
const MOST_VERTICES: u32 = 4096;

/// Everything that a path meets.
pub(crate) struct World<'a> {
    pub(crate) body: &'a Body,
    /// Bare ice, by wavelength.
    pub(crate) surfaces: Vec<SurfaceAt>,
    pub(crate) snow: Option<Snow>,
    pub(crate) bubbles: Option<Bubbles>,
    pub(crate) light: &'a Light,
    pub(crate) ground: Ground,
    /// Height of the plane, just below 0, so that a body stands on it and not in it.
    pub(crate) ground_y_m: f64,
    /// Radiance of what is below the plane.
    pub(crate) glow: Vec<f64>,
    /// Where light that goes in comes out with this spectrum, whatever its way: the mean chord.
    pub(crate) mean_chord_light: Option<Vec<f64>>,
}

/// A path so far.
struct Path {
    ray: Ray,
    /// How often the surface winds around it: 0 outside.
    winding: i32,
    weight: f64,
    ice_m: f64,
    /// Where its random numbers come from.
    sampler: Sampler,
    /// The number of the vertex that it goes to.
    vertex: u32,
}

impl World<'_> {
    /// Adds what one path from the eye along `ray` finds; the surface winds `winding` times around the
    /// eye.
    pub(crate) fn follow(&self, ray: Ray, winding: i32, sampler: Sampler, sum: &mut RadianceSum) {
        let mut path = Path {
            ray,
            winding,
            weight: 1.0,
            ice_m: 0.0,
            sampler,
            vertex: 0,
        };
        for vertex in 0..MOST_VERTICES {
            path.vertex = vertex;
            let goes_on = if path.winding > 0 {
                self.inside(&mut path, sum)
            } else {
                self.outside(&mut path, sum)
            };
            if !goes_on || path.weight <= 0.0 {
                return;
            }
            if vertex >= FIRST_ROULETTE {
                if sampler.coordinate(vertex, 7) >= SURVIVAL {
                    return;
                }
                path.weight /= SURVIVAL;
            }
        }
    }

    /// Follows a path outside to the next vertex; says whether it goes on.
    fn outside(&self, path: &mut Path, sum: &mut RadianceSum) -> bool {
        let height_m = path.ray.origin.y - self.ground_y_m;
        if height_m < 0.0 {
            sum.add(&self.glow, path.weight, path.ice_m);
            return false;
        }
        let ice = self.body.enter(&path.ray);
        let ground_m = if path.ray.direction.y < 0.0 {
            -height_m / path.ray.direction.y
        } else {
            f64::INFINITY
        };
        match ice {
            Some(crossing) if crossing.distance_m <= ground_m => self.surface(path, crossing, sum),
            _ if ground_m.is_finite() => self.on_ground(path, ground_m, sum),
            _ => {
                sum.add_sky(path.ray.direction, path.weight, path.ice_m);
                false
            }
        }
    }

    /// Follows a path inside to the next vertex.
    fn inside(&self, path: &mut Path, sum: &mut RadianceSum) -> bool {
        let free_m = match &self.bubbles {
            Some(bubbles) => bubbles.free_path_m(path.free_path_number()),
            None => f64::INFINITY,
        };
        match (
            self.body.leave(&path.ray, path.winding, free_m),
            &self.bubbles,
        ) {
            (Way::Within(winding), Some(bubbles)) => {
                let [_, u, v] = path.choice_and_direction();
                path.ray = Ray {
                    origin: path.ray.at(free_m),
                    direction: bubbles.scattered(path.ray.direction, [u, v]),
                };
                path.ice_m += free_m;
                path.winding = winding;
                true
            }
            // Only bubbles end a way within the ice.
            (Way::Within(_), None) => false,
            (Way::Out(crossing), _) => {
                path.ice_m += crossing.distance_m;
                self.surface(path, crossing, sum)
            }
        }
    }

    /// What the surface of the ice does with a path that reaches it.
    fn surface(&self, path: &mut Path, crossing: Crossing, sum: &mut RadianceSum) -> bool {
        let point = path.ray.at(crossing.distance_m);
        let arrival = Arrival {
            side: if path.winding > 0 {
                Side::Inside
            } else {
                Side::Outside
            },
            back: -path.ray.direction,
        };
        let surface = self.surface_at(&crossing, point, sum);
        let mut random = path.numbers();
        let sun = self.light.towards_disc([random.next(), random.next()]);
        let (lit_per_sr, scattered) = surface.scatter(crossing.normal, arrival, sun, random);
        if lit_per_sr > 0.0 && self.is_sunlit(point, sun) {
            sum.add_sun(path.weight * lit_per_sr, path.ice_m);
        }
        let Some(scattered) = scattered else {
            return false;
        };
        path.go_on(point, scattered);
        if let (Some(light), Side::Inside) = (&self.mean_chord_light, scattered.side) {
            sum.add(light, path.weight, 0.0);
            return false;
        }
        true
    }

    fn on_ground(&self, path: &mut Path, distance_m: f64, sum: &mut RadianceSum) -> bool {
        let mut point = path.ray.at(distance_m);
        // Exactly on the plane, or the next step might begin below it.
        point.y = self.ground_y_m;
        let back = -path.ray.direction;
        let mut random = path.numbers();
        let sun = self.light.towards_disc([random.next(), random.next()]);
        let (lit_per_sr, scattered) = self.ground.scatter(back, sun, random);
        if lit_per_sr > 0.0 && self.is_sunlit(point, sun) {
            sum.add_sun(path.weight * lit_per_sr, path.ice_m);
        }
        let Some(scattered) = scattered else {
            return false;
        };
        path.go_on(point, scattered);
        true
    }

    /// Adds the sunlight on a surface as if it were diffuse and white.
    pub(crate) fn add_sun_on(&self, point: DVec3, normal: DVec3, sum: &mut RadianceSum) {
        let sun = self.light.sun_direction;
        let share_per_sr = normal.dot(sun).max(0.0) / PI;
        if share_per_sr > 0.0 && self.is_sunlit(point, sun) {
            sum.add_sun(share_per_sr, 0.0);
        }
    }

    /// The surface at a point: snow or bare ice.
    fn surface_at(&self, crossing: &Crossing, point: DVec3, sum: &RadianceSum) -> SurfaceAt {
        let bare = self.surfaces[sum.carried.leading(self.surfaces.len())];
        let lies = |snow: &&Snow| {
            let cos_slope = self.body.cos_slope(crossing, point);
            snow.lies_at(point, cos_slope, self.body.diagonal_m())
        };
        match self.snow.as_ref().filter(lies) {
            Some(snow) => SurfaceAt::Diffuse(DiffuseSurface::patch(snow.albedo, bare.kappa())),
            None => bare,
        }
    }

    /// Whether the sun is above the horizon and nothing stands between its point `sun` and a point
    /// outside.
    fn is_sunlit(&self, point: DVec3, sun: DVec3) -> bool {
        let towards_sun = Ray {
            origin: point,
            direction: sun,
        };
        // What the horizon hides of the disc its irradiance lacks already.
        let is_up = self.light.sun_direction.y > 0.0;
        is_up && point.y >= self.ground_y_m && self.body.enter(&towards_sun).is_none()
    }
}

impl Path {
    fn go_on(&mut self, point: DVec3, scattered: Scattered) {
        self.ray = Ray {
            origin: point,
            direction: scattered.direction,
        };
        self.winding = match scattered.side {
            Side::Outside => 0,
            Side::Inside => 1,
        };
        self.weight *= scattered.weight;
    }

    /// The random numbers of the vertex.
    fn numbers(&self) -> VertexNumbers {
        VertexNumbers::new(
            self.choice_and_direction(),
            self.sampler.stream(self.vertex),
        )
    }

    fn choice_and_direction(&self) -> [f64; 3] {
        match self.vertex {
            0 => self.sampler.coordinates(0, [6, 0, 1]),
            1 => self.sampler.coordinates(0, [7, 2, 3]),
            vertex => self.sampler.coordinates(vertex, [2, 0, 1]),
        }
    }

    fn free_path_number(&self) -> f64 {
        match self.vertex {
            0 => self.sampler.coordinate(1, 1),
            1 => self.sampler.coordinate(1, 2),
            vertex => self.sampler.coordinate(vertex, 3),
        }
    }
}

/// Radiance of what is below the plane: what it gives back of the daylight, W m^-2 sr^-1 nm^-1.
pub(crate) fn glow(light: &Light, ground: &Ground) -> Vec<f64> {
    let share = ground.albedo() / PI;
    let irradiance = light.ground_irradiance();
    irradiance.into_iter().map(|value| share * value).collect()
}

/// Where in the pixel a path starts, 0..1 each. The eight coordinates of the first set are those that
/// matter most: two directions, the place in the pixel, two choices.
pub(crate) fn place_in_pixel(sampler: Sampler) -> [f64; 2] {
    sampler.coordinates(0, [4, 5])
}

/// A random number for the wavelength of a path.
pub(crate) fn wavelength_number(sampler: Sampler) -> f64 {
    sampler.coordinate(1, 0)
}
