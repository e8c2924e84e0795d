//! How the density of a constituent runs with height.
//!
//! exponential  rho = exp(-h/H)                         H scale height
//! tent         rho rises linearly from 0 at the bottom to 1 at the peak and falls to 0 at the top
//! tabulated    nodes, with either law between them
//! Densities are relative: 1 is where the coefficients of the constituent hold. Below its lowest node a profile has
//! the density of that node, above the highest there is nothing: so look-ups have it, and columns.

use std::cmp::Ordering;

use niji_exchange::DensityLaw;

use crate::error::Error;
use crate::error::positive;

/// Depth below sea level down to which profiles reach, m: deeper than any land under open air.
const BOTTOM_M: f64 = -1000.0;
/// Scale heights above which an exponential profile ends: e^-22 = 3e-10 of it is cut off.
const SCALE_HEIGHTS: f64 = 22.0;

/// Relative density by height.
#[derive(Debug, Clone, PartialEq)]
pub enum DensityProfile {
    /// exp(-h/H), 1 at sea level, up to the top of the air or 22 H, which is lower.
    Exponential {
        /// Height over which the density falls to 1/e, m.
        scale_height_m: f64,
    },
    /// Rises linearly to 1 and falls linearly.
    Tent {
        /// Where it begins, m.
        bottom_m: f64,
        /// Where it is 1, m.
        peak_m: f64,
        /// Where it ends, m.
        top_m: f64,
    },
    /// Nodes with a law between them.
    Tabulated {
        /// Law between the nodes.
        law: DensityLaw,
        /// Rising heights, m, and relative densities. Below the first height its density holds, above the
        /// last there is nothing.
        nodes: Vec<[f64; 2]>,
    },
}

/// A profile as nodes with a law between them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Nodes {
    pub(crate) law: DensityLaw,
    pub(crate) height_m: Vec<f64>,
    pub(crate) density: Vec<f64>,
}

impl DensityProfile {
    /// Integral of the relative density over all heights from sea level, m, without an upper end.
    pub fn vertical_length_m(&self) -> f64 {
        match self {
            Self::Exponential { scale_height_m } => *scale_height_m,
            Self::Tent {
                bottom_m,
                peak_m,
                top_m,
            } => {
                let nodes = [[*bottom_m, 0.0], [*peak_m, 1.0], [*top_m, 0.0]];
                from_sea_level_m(DensityLaw::Linear, &nodes)
            }
            Self::Tabulated { law, nodes } => from_sea_level_m(*law, nodes),
        }
    }

    /// Relative density at sea level.
    pub fn at_sea_level(&self) -> f64 {
        match self {
            Self::Exponential { .. } => 1.0,
            Self::Tent {
                bottom_m,
                peak_m,
                top_m,
            } => {
                let rising = -bottom_m / (peak_m - bottom_m);
                let falling = top_m / (top_m - peak_m);
                rising.min(falling).max(0.0)
            }
            Self::Tabulated { law, nodes } => between(*law, nodes, 0.0),
        }
    }

    /// The profile as nodes that end at or below `top_m`.
    pub(crate) fn nodes(&self, top_m: f64) -> Result<Nodes, Error> {
        let nodes = match self {
            Self::Exponential { scale_height_m } => {
                let scale_height_m = positive("scale height", *scale_height_m, "m")?;
                let end_m = top_m.min(SCALE_HEIGHTS * scale_height_m);
                let density = |height_m: f64| (-height_m / scale_height_m).exp();
                Nodes {
                    law: DensityLaw::Exponential,
                    height_m: vec![BOTTOM_M, 0.0, end_m],
                    density: vec![density(BOTTOM_M), 1.0, density(end_m)],
                }
            }
            Self::Tent {
                bottom_m,
                peak_m,
                top_m: end_m,
            } => Nodes {
                law: DensityLaw::Linear,
                height_m: vec![*bottom_m, *peak_m, *end_m],
                density: vec![0.0, 1.0, 0.0],
            },
            Self::Tabulated { law, nodes } => Nodes {
                law: *law,
                height_m: nodes.iter().map(|node| node[0]).collect(),
                density: nodes.iter().map(|node| node[1]).collect(),
            },
        };
        nodes.check(top_m)?;
        Ok(nodes)
    }
}

impl Nodes {
    fn check(&self, top_m: f64) -> Result<(), Error> {
        let bad = |problem: String| Err(Error::Profile { problem });
        if self.height_m.len() < 2 {
            return bad(format!(
                "{} nodes found, expected at least 2",
                self.height_m.len()
            ));
        }
        // Also where a height is NaN.
        let falls = |pair: &&[f64]| pair[1].partial_cmp(&pair[0]) != Some(Ordering::Greater);
        if let Some([low_m, high_m]) = self.height_m.windows(2).find(falls) {
            return bad(format!(
                "height {high_m} m found after {low_m} m, expected rising"
            ));
        }
        let last_m = self.height_m[self.height_m.len() - 1];
        if last_m > top_m {
            return bad(format!(
                "it ends at {last_m} m, expected below the top of the air, {top_m} m"
            ));
        }
        let is_bad = |density: f64| match self.law {
            DensityLaw::Exponential => !(density > 0.0 && density.is_finite()),
            DensityLaw::Linear => !(density >= 0.0 && density.is_finite()),
        };
        match self.density.iter().find(|&&density| is_bad(density)) {
            Some(density) => bad(format!(
                "density {density} found, expected a positive number"
            )),
            None => Ok(()),
        }
    }
}

/// Relative density of nodes at a height: that of the lowest below it, 0 above the highest.
fn between(law: DensityLaw, nodes: &[[f64; 2]], height_m: f64) -> f64 {
    let above = nodes.partition_point(|node| node[0] <= height_m);
    if above == 0 {
        return nodes.first().map_or(0.0, |node| node[1]);
    }
    let Some([high_m, high]) = nodes.get(above) else {
        return 0.0;
    };
    let [low_m, low] = nodes[above - 1];
    let share = (height_m - low_m) / (high_m - low_m);
    match law {
        DensityLaw::Linear => low + (high - low) * share,
        DensityLaw::Exponential => low * (high / low).powf(share),
    }
}

/// Integral over all heights from sea level, m.
fn from_sea_level_m(law: DensityLaw, nodes: &[[f64; 2]]) -> f64 {
    let above: Vec<[f64; 2]> = [[0.0, between(law, nodes, 0.0)]]
        .into_iter()
        .chain(nodes.iter().copied().filter(|node| node[0] > 0.0))
        .collect();
    above.windows(2).map(|pair| layer_m(law, pair)).sum()
}

/// Integral over one layer, m.
fn layer_m(law: DensityLaw, pair: &[[f64; 2]]) -> f64 {
    let [[low_m, low], [high_m, high]] = [pair[0], pair[1]];
    let thickness_m = high_m - low_m;
    match law {
        DensityLaw::Linear => 0.5 * (low + high) * thickness_m,
        DensityLaw::Exponential => {
            let log_ratio = (low / high).ln();
            // (1 - e^-x)/x without cancellation for nearly constant density.
            let mean = if log_ratio.abs() < 1e-8 {
                1.0
            } else {
                -(-log_ratio).exp_m1() / log_ratio
            };
            low * mean * thickness_m
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tabulated_exponential_has_the_length_of_its_scale_height() {
        let nodes = (0..=40)
            .map(|i| 5e3 * f64::from(i))
            .map(|h| [h, (-h / 8e3).exp()])
            .collect();
        let profile = DensityProfile::Tabulated {
            law: DensityLaw::Exponential,
            nodes,
        };
        assert!((profile.vertical_length_m() / 8e3 - 1.0).abs() < 1e-10);
    }

    /// Linear nodes.
    fn linear(nodes: &[[f64; 2]]) -> DensityProfile {
        DensityProfile::Tabulated {
            law: DensityLaw::Linear,
            nodes: nodes.to_vec(),
        }
    }

    #[test]
    fn columns_begin_at_sea_level_wherever_the_nodes_do() {
        let length_m = |profile: DensityProfile| profile.vertical_length_m();
        // As dense below the first node as there.
        assert!((length_m(linear(&[[2e3, 1.0], [4e3, 1.0]])) - 4e3).abs() < 1e-9);
        assert!((length_m(linear(&[[500.0, 1.0], [1500.0, 0.0]])) - 1e3).abs() < 1e-9);
        assert!((length_m(linear(&[[500.0, 0.0], [1500.0, 1.0]])) - 500.0).abs() < 1e-9);
        // What lies below sea level is no part of it: a shore of the Dead Sea, 0.3 left of 1 at sea level.
        let shore = linear(&[[-430.0, 1.0], [0.0, 0.3], [570.0, 0.0]]);
        assert!((length_m(shore) - 0.5 * 0.3 * 570.0).abs() < 1e-9);
        let across = linear(&[[-500.0, 1.0], [500.0, 0.0]]);
        assert!((length_m(across) - 0.5 * 0.5 * 500.0).abs() < 1e-9);
        assert_eq!(length_m(linear(&[[-500.0, 1.0], [-100.0, 1.0]])), 0.0);
        // exp(-h/H) from below sea level to 40 H.
        let exponential = DensityProfile::Tabulated {
            law: DensityLaw::Exponential,
            nodes: vec![[-1e3, 0.125_f64.exp()], [320e3, (-40.0_f64).exp()]],
        };
        assert!((length_m(exponential) / 8e3 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_tent_across_sea_level_has_the_column_above_it() {
        let tent = |bottom_m: f64, peak_m: f64, top_m: f64| {
            let tent = DensityProfile::Tent {
                bottom_m,
                peak_m,
                top_m,
            };
            tent.vertical_length_m()
        };
        assert!((tent(10e3, 25e3, 40e3) - 15e3).abs() < 1e-9);
        // From 1/2 at sea level up to 1 and down again; from 1/2 down.
        assert!((tent(-1e3, 1e3, 3e3) - (0.75 * 1e3 + 0.5 * 2e3)).abs() < 1e-9);
        assert!((tent(-3e3, -1e3, 1e3) - 0.5 * 0.5 * 1e3).abs() < 1e-9);
    }

    #[test]
    fn constant_layers_are_no_division_of_0_by_0() {
        let nodes = vec![[0.0, 1.0], [1e3, 1.0]];
        let profile = DensityProfile::Tabulated {
            law: DensityLaw::Exponential,
            nodes,
        };
        assert!((profile.vertical_length_m() - 1e3).abs() < 1e-9);
    }

    #[test]
    fn profiles_that_no_air_can_have_are_refused() {
        let nodes_of = |nodes: Vec<[f64; 2]>| {
            DensityProfile::Tabulated {
                law: DensityLaw::Exponential,
                nodes,
            }
            .nodes(1e5)
        };
        assert!(nodes_of(vec![[0.0, 1.0]]).is_err());
        assert!(nodes_of(vec![[0.0, 1.0], [0.0, 0.5]]).is_err());
        assert!(nodes_of(vec![[0.0, 1.0], [1e3, 0.0]]).is_err());
        assert!(nodes_of(vec![[0.0, 1.0], [f64::NAN, 0.5]]).is_err());
        assert!(nodes_of(vec![[0.0, 1.0], [2e5, 0.5]]).is_err());
        assert!(
            DensityProfile::Exponential {
                scale_height_m: 0.0
            }
            .nodes(1e5)
            .is_err()
        );
    }
}
