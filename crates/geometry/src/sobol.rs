//! Direction numbers of Sobol's sequence, whose points fill a cube evenly however many there are.
//!
//! x_d(k) = sum over the set bits j of k of v_dj, without carry
//!
//! I. M. Sobol', USSR Comput. Math. Math. Phys. 7(4), 86-112 (1967); polynomials and first numbers from
//! [JK08] S. Joe and F. Y. Kuo, "Constructing Sobol sequences with better two-dimensional
//! projections", SIAM J. Sci. Comput. 30, 2635-2654 (2008).

/// Dimensions there are numbers for.
pub const N_SOBOL_DIMENSIONS: usize = 8;

/// Bits of a coordinate.
const N_BITS: usize = 32;

/// Degree, inner coefficients and first direction numbers of the primitive polynomials (JK08, file
/// new-joe-kuo-6.21201); the first dimension needs none.
const POLYNOMIALS: [(usize, u32, &[u32]); N_SOBOL_DIMENSIONS - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
];

/// By dimension and bit j of an index, lowest first: v_dj as 32 binary digits after the point.
///
/// ```
/// use niji_geometry::SOBOL_DIRECTIONS;
///
/// // Point 3 has bits 0 and 1; in the first dimension that is 0.1 and 0.01 in binary: 0.75.
/// let digits = SOBOL_DIRECTIONS[0][0] ^ SOBOL_DIRECTIONS[0][1];
/// assert_eq!(f64::from(digits) / 2_f64.powi(32), 0.75);
/// ```
pub static SOBOL_DIRECTIONS: [[u32; N_BITS]; N_SOBOL_DIMENSIONS] = directions();

/// The recurrence of each polynomial (JK08, eqs. 2 and 3).
const fn directions() -> [[u32; N_BITS]; N_SOBOL_DIMENSIONS] {
    let mut directions = [[0; N_BITS]; N_SOBOL_DIMENSIONS];
    let mut bit = 0;
    while bit < N_BITS {
        directions[0][bit] = 1 << (N_BITS - 1 - bit);
        bit += 1;
    }
    let mut dimension = 1;
    while dimension < N_SOBOL_DIMENSIONS {
        let (degree, coefficients, first) = POLYNOMIALS[dimension - 1];
        let mut bit = 0;
        while bit < N_BITS {
            directions[dimension][bit] = if bit < degree {
                first[bit] << (N_BITS - 1 - bit)
            } else {
                let before = directions[dimension][bit - degree];
                let mut value = before ^ (before >> degree);
                let mut term = 1;
                while term < degree {
                    if (coefficients >> (degree - 1 - term)) & 1 == 1 {
                        value ^= directions[dimension][bit - term];
                    }
                    term += 1;
                }
                value
            };
            bit += 1;
        }
        dimension += 1;
    }
    directions
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(index: u32, dimension: usize) -> f64 {
        let set = SOBOL_DIRECTIONS[dimension].iter().enumerate();
        let digits = set
            .filter(|(bit, _)| (index >> bit) & 1 == 1)
            .fold(0, |digits, (_, direction)| digits ^ direction);
        f64::from(digits) / 4_294_967_296.0
    }

    #[test]
    fn the_first_points_are_sobols() {
        // In the order of binary, not Gray, counting.
        let points: Vec<[f64; 3]> = (1..4).map(|k| [0, 1, 2].map(|d| point(k, d))).collect();
        assert_eq!(points[0], [0.5, 0.5, 0.5]);
        assert_eq!(points[1], [0.25, 0.75, 0.75]);
        assert_eq!(points[2], [0.75, 0.25, 0.25]);
    }

    #[test]
    fn every_power_of_two_points_hit_every_interval_of_each_dimension_once() {
        for dimension in 0..N_SOBOL_DIMENSIONS {
            let mut hit = [false; 256];
            for index in 256..512 {
                hit[(256.0 * point(index, dimension)) as usize] = true;
            }
            assert!(hit.iter().all(|hit| *hit), "{dimension}");
        }
    }
}
