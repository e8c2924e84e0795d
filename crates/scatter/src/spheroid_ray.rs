//! A ray through a spheroid, with its derivatives by where it enters and by how flat the drop is.
//!
//! |x|² + κ (x·z)² = 1,   κ = 1/q² − 1 = 4 e/(1 − e)²
//! enter, leave:  u' = η u + (±sqrt(1 − η² (1 − (u·ν)²)) − η u·ν) ν,   reflect:  u' = u − 2 (u·ν) ν
//! `x` points in units of the long half axis, `z` unit vector along the short axis, `q` axis ratio,
//! e = (1 − q)/(1 + q), `u` direction of the light, `ν` outward normal along x + κ (x·z) z, `η` ratio of
//! indices (1/n, then n), the sign that of u·ν.
//!
//! Light travels along +x and enters at (y, z) = (b, c). Each quantity is a [`Jet`] in (b, c, e) at
//! (b, 0, 0), a ray of the sphere in the plane z = 0.

use crate::jet::Jet;

/// Places of the three variables in a [`Jet`].
pub(crate) const IN_PLANE: usize = 0;
/// See [`IN_PLANE`].
pub(crate) const ACROSS: usize = 1;
/// See [`IN_PLANE`].
pub(crate) const ECCENTRICITY: usize = 2;

type Vector = [Jet; 3];

/// Which ray: index of the drop, order, and the distance b from the axis at which it enters.
#[derive(Clone, Copy)]
pub(crate) struct Entry {
    pub(crate) index: f64,
    pub(crate) order: u32,
    pub(crate) offset: f64,
}

/// Direction in which the ray leaves a drop whose short axis lies along `axis`.
pub(crate) fn exit_direction(entry: Entry, axis: [f64; 3]) -> Vector {
    let e = Jet::variable(ECCENTRICITY, 0.0);
    let rest = (Jet::constant(1.0) - e).recip();
    let drop = Spheroid {
        axis,
        kappa: e.scaled(4.0) * rest * rest,
    };
    let mut u = [1.0, 0.0, 0.0].map(Jet::constant);
    let plane = [
        Jet::constant(0.0),
        Jet::variable(IN_PLANE, entry.offset),
        Jet::variable(ACROSS, 0.0),
    ];
    let mut x = drop.first_point(plane, u);
    u = refracted(u, drop.normal(x), 1.0 / entry.index);
    for _ in 1..entry.order {
        x = drop.next_point(x, u);
        u = reflected(u, drop.normal(x));
    }
    x = drop.next_point(x, u);
    refracted(u, drop.normal(x), entry.index)
}

struct Spheroid {
    axis: [f64; 3],
    kappa: Jet,
}

impl Spheroid {
    /// u·v + κ (u·z)(v·z): the surface is where x with itself gives 1.
    fn form(&self, u: Vector, v: Vector) -> Jet {
        dot(u, v) + self.kappa * self.along(u) * self.along(v)
    }

    fn along(&self, u: Vector) -> Jet {
        let [x, y, z] = [0, 1, 2].map(|j| u[j].scaled(self.axis[j]));
        x + y + z
    }

    /// Where light through `x` along `u` meets the surface from outside.
    fn first_point(&self, x: Vector, u: Vector) -> Vector {
        let (a, b) = (self.form(u, u), self.form(x, u));
        let c = self.form(x, x) - Jet::constant(1.0);
        let length = (Jet::constant(0.0) - b - (b * b - a * c).sqrt()) * a.recip();
        sum(x, scaled(u, length))
    }

    /// Where light from the point `x` of the surface meets it again.
    fn next_point(&self, x: Vector, u: Vector) -> Vector {
        let length = self.form(x, u).scaled(-2.0) * self.form(u, u).recip();
        sum(x, scaled(u, length))
    }

    fn normal(&self, x: Vector) -> Vector {
        let along = self.kappa * self.along(x);
        let gradient = sum(x, self.axis.map(|z| along.scaled(z)));
        scaled(gradient, dot(gradient, gradient).sqrt().recip())
    }
}

fn refracted(u: Vector, normal: Vector, ratio: f64) -> Vector {
    let along = dot(u, normal).scaled(ratio);
    let root = (Jet::constant(1.0 - ratio * ratio) + along * along).sqrt();
    let across = root.scaled(along.value.signum()) - along;
    sum(u.map(|u| u.scaled(ratio)), scaled(normal, across))
}

fn reflected(u: Vector, normal: Vector) -> Vector {
    sum(u, scaled(normal, dot(u, normal).scaled(-2.0)))
}

fn dot(u: Vector, v: Vector) -> Jet {
    u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
}

fn sum(u: Vector, v: Vector) -> Vector {
    [0, 1, 2].map(|j| u[j] + v[j])
}

fn scaled(u: Vector, factor: Jet) -> Vector {
    u.map(|u| u * factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENTRY: Entry = Entry {
        index: 1.333,
        order: 3,
        offset: 0.7,
    };

    #[test]
    fn a_spheres_ray_turns_as_descartes_says() {
        let u = exit_direction(ENTRY, [0.6, 0.0, 0.8]);
        let (i, r) = (0.7_f64.asin(), (0.7_f64 / 1.333).asin());
        let deviation = 2.0 * i - 6.0 * r + 2.0 * std::f64::consts::PI;
        assert!((u[0].value - deviation.cos()).abs() < 1e-14);
        assert!((u[1].value + deviation.sin()).abs() < 1e-14);
        assert_eq!(u[2].value, 0.0);
        // D' = 2/cos i − 2 p/(n cos r); the azimuth follows that of the point.
        let slope = 2.0 / i.cos() - 6.0 / (1.333 * r.cos());
        assert!((u[0].first[IN_PLANE] + slope * deviation.sin()).abs() < 1e-13);
        assert!((u[2].first[ACROSS] * ENTRY.offset - u[1].value).abs() < 1e-14);
    }

    #[test]
    fn directions_stay_unit_vectors_to_second_order() {
        let u = exit_direction(ENTRY, [0.48, 0.6, 0.64]);
        let square = dot(u, u);
        assert!((square.value - 1.0).abs() < 1e-14);
        for j in 0..3 {
            assert!(square.first[j].abs() < 1e-12);
            assert!((0..3).all(|k| square.second(j, k).abs() < 1e-10));
        }
    }

    #[test]
    fn a_drop_seen_along_its_axis_bends_light_in_the_plane_only() {
        let u = exit_direction(ENTRY, [1.0, 0.0, 0.0]);
        assert_eq!(u[2].first[ECCENTRICITY], 0.0);
        assert_eq!(u[2].second(ECCENTRICITY, IN_PLANE), 0.0);
    }
}
