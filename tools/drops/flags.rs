//! The parameters of each shape on the command line.

use clap::Args;
use clap::ValueEnum;
use niji_droplets::Axis;
use niji_droplets::Footprint;
use niji_droplets::Gradient;
use niji_droplets::RainShaft;
use niji_droplets::Shape;
use niji_droplets::Uniform;

use crate::cli::numbers;
use crate::failure::Failure;
use crate::law_flags::LawFlags;

/// The box of a shape.
#[allow(clippy::struct_field_names, reason = "the unit is part of a name")]
#[derive(Debug, Args)]
struct BoxFlags {
    /// Lowest corner.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    box_min_m: [f64; 3],
    /// Highest corner.
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    box_max_m: [f64; 3],
    /// Edge length of a voxel.
    #[arg(long, value_name = "M")]
    voxel_m: f64,
}

/// A box of the same drops everywhere.
#[derive(Debug, Args)]
pub(super) struct UniformFlags {
    #[command(flatten)]
    grid: BoxFlags,
    #[command(flatten)]
    law: LawFlags,
}

impl UniformFlags {
    pub(super) fn shape(&self) -> Result<Shape, Failure> {
        Ok(Shape::Uniform(Uniform {
            box_min_m: self.grid.box_min_m,
            box_max_m: self.grid.box_max_m,
            voxel_m: self.grid.voxel_m,
            law: self.law.size_law()?,
            number_density_m3: self.law.number_density_m3,
        }))
    }
}

/// A box in which radius and number density run linearly along an axis.
#[derive(Debug, Args)]
pub(super) struct GradientFlags {
    #[command(flatten)]
    grid: BoxFlags,
    /// The axis along which both run: x east, y up, z south.
    #[arg(long, default_value = "y")]
    axis: AxisName,
    /// Radius at the low face.
    #[arg(long, value_name = "UM")]
    radius_at_min_um: f64,
    /// Radius at the high face.
    #[arg(long, value_name = "UM")]
    radius_at_max_um: f64,
    /// Number density at the low face.
    #[arg(long, value_name = "1/M3")]
    number_density_at_min_m3: f64,
    /// Number density at the high face.
    #[arg(long, value_name = "1/M3")]
    number_density_at_max_m3: f64,
    /// Effective variance everywhere.
    #[arg(long, value_name = "V", default_value_t = 0.0)]
    effective_variance: f64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum AxisName {
    X,
    Y,
    Z,
}

impl GradientFlags {
    pub(super) fn shape(&self) -> Shape {
        Shape::Gradient(Gradient {
            box_min_m: self.grid.box_min_m,
            box_max_m: self.grid.box_max_m,
            voxel_m: self.grid.voxel_m,
            axis: match self.axis {
                AxisName::X => Axis::X,
                AxisName::Y => Axis::Y,
                AxisName::Z => Axis::Z,
            },
            radius_at_min_um: self.radius_at_min_um,
            radius_at_max_um: self.radius_at_max_um,
            number_density_at_min_m3: self.number_density_at_min_m3,
            number_density_at_max_m3: self.number_density_at_max_m3,
            effective_variance: self.effective_variance,
        })
    }
}

/// A shaft of Marshall-Palmer rain below a cloud.
#[derive(Debug, Args)]
pub(super) struct RainShaftFlags {
    /// Rain rate.
    #[arg(long, value_name = "MM/H")]
    rain_rate_mm_h: f64,
    /// Smallest drop diameter.
    #[arg(long, value_name = "MM")]
    d_min_mm: Option<f64>,
    /// Largest drop diameter.
    #[arg(long, value_name = "MM")]
    d_max_mm: Option<f64>,
    /// Radius of a round shaft.
    #[arg(long, value_name = "M", required_unless_present = "width_m")]
    radius_m: Option<f64>,
    /// Extent of a rectangular shaft east-west and north-south.
    #[arg(long, value_name = "X,Z", value_parser = pair, conflicts_with = "radius_m")]
    width_m: Option<[f64; 2]>,
    /// Middle of the shaft at its top.
    #[arg(long, value_name = "X,Z", value_parser = pair, default_value = "0,0", allow_hyphen_values = true)]
    center_m: [f64; 2],
    /// Height of the lower end.
    #[arg(long, value_name = "M", default_value_t = 0.0)]
    base_m: f64,
    /// Height of the cloud base.
    #[arg(long, value_name = "M")]
    top_m: f64,
    /// Wind shear: change of the wind towards x and z per metre of height.
    #[arg(long, value_name = "X,Z", value_parser = pair, default_value = "0,0", allow_hyphen_values = true)]
    wind_shear_1_s: [f64; 2],
    /// Width over which the edge fades.
    #[arg(long, value_name = "M", default_value_t = 0.0)]
    edge_m: f64,
    /// Edge length of a voxel.
    #[arg(long, value_name = "M")]
    voxel_m: f64,
}

impl RainShaftFlags {
    pub(super) fn shape(&self) -> Result<Shape, Failure> {
        let footprint = match (self.radius_m, self.width_m) {
            (Some(radius_m), _) => Footprint::Column { radius_m },
            (None, Some([width_x_m, width_z_m])) => Footprint::Box {
                width_x_m,
                width_z_m,
            },
            (None, None) => {
                return Err(Failure::Usage(
                    "expected --radius-m or --width-m".to_owned(),
                ));
            }
        };
        Ok(Shape::RainShaft(RainShaft {
            rain_rate_mm_h: self.rain_rate_mm_h,
            d_min_mm: self.d_min_mm,
            d_max_mm: self.d_max_mm,
            footprint,
            center_xz_m: self.center_m,
            base_y_m: self.base_m,
            top_y_m: self.top_m,
            wind_shear_xz_1_s: self.wind_shear_1_s,
            edge_m: self.edge_m,
            voxel_m: self.voxel_m,
        }))
    }
}

fn triple(text: &str) -> Result<[f64; 3], String> {
    list(text)
}

fn pair(text: &str) -> Result<[f64; 2], String> {
    list(text)
}

fn list<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let values = numbers(text)?;
    values
        .try_into()
        .map_err(|_| format!("found {text:?}, expected {N} numbers as 1,2,3"))
}
