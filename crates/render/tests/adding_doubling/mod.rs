//! Light of a plane-parallel layer that absorbs nothing, by adding and doubling: all orders of scattering without chance.
//!
//! I_i = sum_j R_ij I'_j,   I_i = sum_j T_ij I'_j        azimuthal means at cosines mu_i with weights w_i
//! thin:    R = d M^-1 h(mu, -mu') W/2,   T = 1 - d M^-1 (1 - h(mu, mu') W/2),   M = diag mu, W = diag w
//! doubled: D = (1 - R R)^-1,   R' = R + T D R T,   T' = T D T
//! h(mu, mu') = sum_l (2 l + 1) c_l P_l(mu) P_l(mu'),   c_l = 1/2 int p(x) P_l(x) dx,   c_0 = 1
//!
//! `d` optical depth, `p` phase function, of which n cosines hold moments below 2 n exactly.
//! H. C. van de Hulst, Multiple Light Scattering, Academic Press (1980), chapter 4.

use ndarray::Array1;
use ndarray::Array2;

/// A layer thinner than that scatters once.
const THIN: f64 = 1e-7;

/// Weight of cosines that are looked at and take no part.
const NO_WEIGHT: f64 = 1e-12;

/// Light of a layer under a sun in the zenith, for unit irradiance.
pub(crate) struct LayerLight {
    /// Radiance of light sent up and of light sent down at the cosines asked for [1/sr].
    pub(crate) up_sr1: Vec<f64>,
    pub(crate) down_sr1: Vec<f64>,
    /// Shares of the light that leave upwards, and downwards with what was not scattered.
    pub(crate) reflectance: f64,
    pub(crate) transmittance: f64,
    /// Shares of light from all directions evenly.
    pub(crate) even_transmittance: f64,
}

/// Nodes and weights of Gauss on -1..1, ascending.
pub(crate) fn gauss(n: usize) -> Vec<(f64, f64)> {
    let node = |index: usize| {
        let mut x = -(std::f64::consts::PI * (index as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 0.0;
        for _ in 0..8 {
            let p = legendre(x, n);
            slope = n as f64 * (x * p[n] - p[n - 1]) / (x * x - 1.0);
            x -= p[n] / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(node).collect()
}

/// The same on 0..1.
pub(crate) fn gauss_of_cosines(n: usize) -> Vec<(f64, f64)> {
    let nodes = gauss(n).into_iter();
    nodes.map(|(x, w)| (0.5 * (1.0 + x), 0.5 * w)).collect()
}

/// P_0 to P_n.
fn legendre(x: f64, n: usize) -> Vec<f64> {
    let mut p = vec![1.0, x];
    for l in 1..n {
        let l_f = l as f64;
        p.push(((2.0 * l_f + 1.0) * x * p[l] - l_f * p[l - 1]) / (l_f + 1.0));
    }
    p
}

/// The first n moments of a phase function at the nodes of Gauss.
pub(crate) fn moments(nodes: &[(f64, f64)], phase: &[f64], n: usize) -> Vec<f64> {
    let mut sums = vec![0.0; n];
    for ((x, w), phase) in nodes.iter().zip(phase) {
        for (sum, p) in sums.iter_mut().zip(legendre(*x, n)) {
            *sum += 0.5 * w * phase * p;
        }
    }
    let norm = sums[0];
    sums.into_iter().map(|sum| sum / norm).collect()
}

/// Light of a layer with these moments, 2n of them for n cosines, looked at along cosines.
pub(crate) fn layer(depth: f64, moments: &[f64], cosines: &[f64]) -> LayerLight {
    // The sun, the views and the nodes.
    let extra = std::iter::once(1.0).chain(cosines.iter().copied());
    let mut nodes: Vec<(f64, f64)> = extra.map(|mu| (mu, NO_WEIGHT)).collect();
    nodes.extend(gauss_of_cosines(moments.len() / 2));
    let (r, t) = doubled(&nodes, moments, depth);
    let from_sun = |operator: &Array2<f64>, node: usize| {
        let diffuse = operator[[node, 0]];
        diffuse / (2.0 * std::f64::consts::PI * NO_WEIGHT)
    };
    // The sun's own column holds its direct light on the diagonal.
    let flux = |operator: &Array2<f64>| {
        let terms = nodes.iter().enumerate().skip(1);
        let flux: f64 = terms
            .map(|(node, (mu, w))| w * mu * operator[[node, 0]])
            .sum();
        flux / NO_WEIGHT
    };
    let views = 1..=cosines.len();
    let even = nodes.iter().enumerate().map(|(node, (mu, w))| {
        let light: f64 = t.row(node).sum();
        2.0 * w * mu * light
    });
    LayerLight {
        up_sr1: views.clone().map(|node| from_sun(&r, node)).collect(),
        down_sr1: views.map(|node| from_sun(&t, node)).collect(),
        reflectance: flux(&r),
        transmittance: flux(&t) + (-depth).exp(),
        even_transmittance: even.sum(),
    }
}

/// R and T of a layer.
fn doubled(nodes: &[(f64, f64)], moments: &[f64], depth: f64) -> (Array2<f64>, Array2<f64>) {
    let n_doublings = (depth / THIN).log2().ceil().max(0.0) as u32;
    let thin = depth / f64::from(n_doublings).exp2();
    let rows: Vec<Vec<f64>> = nodes
        .iter()
        .map(|(mu, _)| legendre(*mu, moments.len() - 1))
        .collect();
    let n = nodes.len();
    let h = |i: usize, j: usize, sign: f64| {
        let (mut sum, mut parity) = (0.0, 1.0);
        for (l, c) in moments.iter().enumerate() {
            sum += (2.0 * l as f64 + 1.0) * c * parity * rows[i][l] * rows[j][l];
            parity *= sign;
        }
        sum
    };
    let scattered =
        |i: usize, j: usize, sign: f64| 0.5 * thin / nodes[i].0 * h(i, j, sign) * nodes[j].1;
    let mut r = Array2::from_shape_fn((n, n), |(i, j)| scattered(i, j, -1.0));
    let mut t = Array2::from_shape_fn((n, n), |(i, j)| {
        let passes = if i == j { 1.0 - thin / nodes[i].0 } else { 0.0 };
        passes + scattered(i, j, 1.0)
    });
    for _ in 0..n_doublings {
        let between = Array2::eye(n) - r.dot(&r);
        let back_and_forth = solved(between, t.clone());
        // R and D are functions of the same matrix.
        r = &r + &t.dot(&r.dot(&back_and_forth));
        t = t.dot(&back_and_forth);
    }
    (r, t)
}

/// A^-1 B, by elimination with pivots.
fn solved(mut a: Array2<f64>, mut b: Array2<f64>) -> Array2<f64> {
    let n = a.nrows();
    let subtract = |m: &mut Array2<f64>, (row, pivot): (usize, usize), factor: f64| {
        let above: Array1<f64> = m.row(pivot).to_owned();
        m.row_mut(row).scaled_add(-factor, &above);
    };
    let largest = |a: &Array2<f64>, column: usize| {
        (column..n).max_by(|i, j| a[[*i, column]].abs().total_cmp(&a[[*j, column]].abs()))
    };
    for column in 0..n {
        let pivot = largest(&a, column).unwrap();
        for other in 0..n {
            a.swap([column, other], [pivot, other]);
            b.swap([column, other], [pivot, other]);
        }
        for row in column + 1..n {
            let factor = a[[row, column]] / a[[column, column]];
            subtract(&mut a, (row, column), factor);
            subtract(&mut b, (row, column), factor);
        }
    }
    for column in (0..n).rev() {
        let scale = a[[column, column]].recip();
        b.row_mut(column).mapv_inplace(|value| value * scale);
        for row in 0..column {
            let factor = a[[row, column]];
            subtract(&mut b, (row, column), factor);
        }
    }
    b
}
