//! Authoring: shapes of rain, fountains and fog as drop volumes.

mod error;
mod gradient;
mod rain_shaft;
mod shape;
mod uniform;

pub use error::Error;
pub use gradient::Axis;
pub use gradient::Gradient;
pub use rain_shaft::Footprint;
pub use rain_shaft::RainShaft;
pub use shape::Shape;
pub use uniform::Uniform;
