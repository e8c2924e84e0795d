//! Single scattering by nested adaptive Gauss-Kronrod quadrature, from densities as formulas.
//!
//! Shares nothing with the crate: heights are differences of two radii (1e-9 m in f64), distances
//! come from the quadratic formula, profiles from their definition; no table, no fixed rule.

use std::f64::consts::PI;

use super::RADIUS_M;

/// Top of the air in all tests, m.
const TOP_M: f64 = 100e3;
/// Depth of the nested halvings.
const MAX_DEPTH: u32 = 16;

/// Relative density of one constituent.
#[derive(Clone, Copy)]
pub(crate) enum Density {
    /// exp(-h/H) up to 22 H or the top of the air.
    Exponential(f64),
    /// Bottom, peak and top of a tent, m.
    Tent([f64; 3]),
}

/// One constituent with its coefficients at three wavelengths.
#[derive(Clone, Copy)]
pub(crate) struct Layer {
    pub(crate) density: Density,
    pub(crate) extinction_m1: [f64; 3],
    /// Scattering coefficient times phase function, 1/(m sr).
    pub(crate) directed_m1: [f64; 3],
}

impl Density {
    fn at(self, h: f64) -> f64 {
        match self {
            Self::Exponential(scale_m) if h <= self.top_m() => (-h.max(-1000.0) / scale_m).exp(),
            Self::Tent([bottom, peak, top]) if h > bottom && h < top => {
                ((h - bottom) / (peak - bottom)).min((top - h) / (top - peak))
            }
            Self::Exponential(_) | Self::Tent(_) => 0.0,
        }
    }

    fn top_m(self) -> f64 {
        match self {
            Self::Exponential(scale_m) => (22.0 * scale_m).min(TOP_M),
            Self::Tent([_, _, top]) => top,
        }
    }

    /// Heights at which the density is not smooth.
    fn kinks_m(self) -> Vec<f64> {
        match self {
            Self::Exponential(_) => vec![self.top_m()],
            Self::Tent(nodes) => nodes.to_vec(),
        }
    }
}

/// A point as its distance from the center and the cosine of the angle of a line to the vertical.
type Start = [f64; 2];

fn height(start: Start, s: f64) -> f64 {
    let [r, mu] = start;
    (r * r + 2.0 * r * mu * s + s * s).sqrt() - RADIUS_M
}

/// Where a line crosses a sphere, behind or before its start.
fn crossings([r, mu]: Start, shell_m: f64) -> Vec<f64> {
    let d2 = r * r * (mu * mu - 1.0) + (RADIUS_M + shell_m).powi(2);
    if d2 < 0.0 {
        return Vec::new();
    }
    vec![-r * mu - d2.sqrt(), -r * mu + d2.sqrt()]
}

/// Whether a line meets the ground ahead.
fn is_blocked([r, mu]: Start) -> bool {
    mu < 0.0 && r * (1.0 - mu * mu).max(0.0).sqrt() < RADIUS_M
}

/// Equivalent length of a layer over `from..to` of a line.
pub(crate) fn length(density: Density, start: Start, [from, to]: [f64; 2]) -> f64 {
    let perigee = -start[0] * start[1];
    let mut cuts: Vec<f64> = density
        .kinks_m()
        .into_iter()
        .flat_map(|kink_m| crossings(start, kink_m))
        .chain([perigee, from, to])
        .filter(|&s| s >= from && s <= to)
        .collect();
    cuts.sort_by(f64::total_cmp);
    let piece = |ends: &[f64]| {
        let f = |s: f64| [density.at(height(start, s)), 0.0, 0.0];
        if density.at(height(start, 0.5 * (ends[0] + ends[1]))) <= 0.0 {
            return 0.0;
        }
        integral(&f, [ends[0], ends[1]], [1e-10, 1e-6])[0]
    };
    cuts.windows(2).map(piece).sum()
}

/// Equivalent length to the top of the air of a line that does not meet the ground.
pub(crate) fn column(density: Density, start: Start) -> f64 {
    let end = crossings(start, density.top_m()).last().copied();
    end.filter(|&end| end > 0.0)
        .map_or(0.0, |end| length(density, start, [0.0, end]))
}

/// View ray: height, cosines of the zenith angles of view and sun, cosine between both.
pub(crate) struct Ray {
    pub(crate) height_m: f64,
    pub(crate) mu: f64,
    pub(crate) mu_s: f64,
    pub(crate) nu: f64,
    pub(crate) length_m: f64,
}

/// Radiance over the sun's irradiance at three wavelengths, 1/sr.
pub(crate) fn radiance(layers: &[Layer], ray: &Ray) -> [f64; 3] {
    let start = [RADIUS_M + ray.height_m, ray.mu];
    let Some(&[enter, exit]) = crossings(start, TOP_M).as_chunks().0.first() else {
        return [0.0; 3];
    };
    let mut end = exit.min(ray.length_m);
    if is_blocked(start) {
        end = end.min(crossings(start, 0.0)[0].max(0.0));
    }
    let begin = enter.max(0.0);
    if end <= begin {
        return [0.0; 3];
    }
    let sun_at = |s: f64| {
        let r = RADIUS_M + height(start, s);
        [r, ((start[0] * ray.mu_s + s * ray.nu) / r).clamp(-1.0, 1.0)]
    };
    let source = |s: f64| {
        let sun = sun_at(s);
        if is_blocked(sun) {
            return [0.0; 3];
        }
        let mut depth = [0.0; 3];
        let mut light = [0.0; 3];
        for layer in layers {
            let length_m = length(layer.density, start, [begin, s]) + column(layer.density, sun);
            let density = layer.density.at(sun[0] - RADIUS_M);
            for i in 0..3 {
                depth[i] += layer.extinction_m1[i] * length_m;
                light[i] += layer.directed_m1[i] * density;
            }
        }
        [0, 1, 2].map(|i| light[i] * (-depth[i]).exp())
    };
    let cuts = cuts(layers, start, [begin, end], &|s| is_blocked(sun_at(s)));
    let mut sum = [0.0; 3];
    // The largest source sets the scale below which nothing counts.
    let largest = cuts
        .windows(2)
        .map(|ends| source(0.5 * (ends[0] + ends[1])));
    let largest = largest.fold(0.0_f64, |most, light| most.max(light[2]).max(light[0]));
    for ends in cuts.windows(2) {
        if is_blocked(sun_at(0.5 * (ends[0] + ends[1]))) {
            continue;
        }
        let absolute = 1e-12 * largest * (ends[1] - ends[0]);
        let part = integral(&source, [ends[0], ends[1]], [1e-7, absolute]);
        for i in 0..3 {
            sum[i] += part[i];
        }
    }
    sum
}

/// Ends, kinks, perigee and the walls of the shadow, which are found by bisection.
fn cuts(
    layers: &[Layer],
    start: Start,
    [begin, end]: [f64; 2],
    is_dark: &dyn Fn(f64) -> bool,
) -> Vec<f64> {
    let kinks = layers.iter().flat_map(|layer| layer.density.kinks_m());
    let mut cuts: Vec<f64> = kinks
        .flat_map(|kink_m| crossings(start, kink_m))
        .chain([-start[0] * start[1], begin, end])
        .filter(|&s| s >= begin && s <= end)
        .collect();
    let n = 4000;
    let at = |i: i32| begin + (end - begin) * f64::from(i) / f64::from(n);
    for i in 0..n {
        let [mut a, mut b] = [at(i), at(i + 1)];
        if is_dark(a) == is_dark(b) {
            continue;
        }
        for _ in 0..60 {
            let middle = 0.5 * (a + b);
            if is_dark(middle) == is_dark(a) {
                a = middle;
            } else {
                b = middle;
            }
        }
        cuts.extend([a, b]);
    }
    cuts.sort_by(f64::total_cmp);
    cuts
}

/// Gauss-Kronrod nodes and weights of 15 points, and the weights of Gauss's 7 among them (QUADPACK,
/// Piessens and others 1983).
const NODES: [f64; 8] = [
    0.991455371120812639206854697526329,
    0.949107912342758524526189684047851,
    0.864864423359769072789712788640926,
    0.741531185599394439863864773280788,
    0.586087235467691130294144691693013,
    0.405845151377397166906606412076961,
    0.207784955007898467600689403773245,
    0.000000000000000000000000000000000,
];
const KRONROD: [f64; 8] = [
    0.022935322010529224963732008058970,
    0.063092092629978553290700663189204,
    0.104790010322250183839876322541518,
    0.140653259715525918745189590510238,
    0.169004726639267902826583426598550,
    0.190350578064785409913256402421014,
    0.204432940075298892414161999234649,
    0.209482141084727828012999174891714,
];
const GAUSS: [f64; 4] = [
    0.129484966168869693270611432679082,
    0.279705391489276667901467771423780,
    0.381830050505118944950369775488975,
    0.417959183673469387755102040816327,
];

/// Integral of three functions at once, by halving until Gauss and Kronrod agree to a relative or an
/// absolute error.
fn integral(f: &dyn Fn(f64) -> [f64; 3], ends: [f64; 2], errors: [f64; 2]) -> [f64; 3] {
    halved(f, ends, errors, MAX_DEPTH)
}

fn halved(
    f: &dyn Fn(f64) -> [f64; 3],
    [a, b]: [f64; 2],
    [relative, absolute]: [f64; 2],
    depth: u32,
) -> [f64; 3] {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let mut kronrod = [0.0; 3];
    let mut gauss = [0.0; 3];
    for (i, (&node, &weight)) in NODES.iter().zip(&KRONROD).enumerate() {
        let both = if i == 7 {
            f(middle)
        } else {
            let (low, high) = (f(middle - half * node), f(middle + half * node));
            [0, 1, 2].map(|k| low[k] + high[k])
        };
        for k in 0..3 {
            kronrod[k] += half * weight * both[k];
            if i % 2 == 1 {
                gauss[k] += half * GAUSS[i / 2] * both[k];
            }
        }
    }
    let agree = (0..3).all(|k| {
        let error = (kronrod[k] - gauss[k]).abs();
        error <= relative * kronrod[k].abs() || error <= absolute
    });
    if agree || depth == 0 {
        return kronrod;
    }
    let errors = [relative, absolute];
    let low = halved(f, [a, middle], errors, depth - 1);
    let high = halved(f, [middle, b], errors, depth - 1);
    [0, 1, 2].map(|k| low[k] + high[k])
}

/// Rayleigh's phase function with the depolarisation of a King factor F: rho = 6 (F - 1)/(7 F + 3).
pub(crate) fn rayleigh(king_factor: f64, nu: f64) -> f64 {
    let rho = 6.0 * (king_factor - 1.0) / (7.0 * king_factor + 3.0);
    let gamma = rho / (2.0 - rho);
    let shape = (1.0 + 3.0 * gamma) + (1.0 - gamma) * nu * nu;
    3.0 / (16.0 * PI * (1.0 + 2.0 * gamma)) * shape
}

/// Henyey and Greenstein's phase function.
pub(crate) fn henyey_greenstein(g: f64, nu: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * nu).powf(1.5))
}
