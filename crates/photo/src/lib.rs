//! Photographs: reading them, and setting a bow into them.
//!
//! A [`Photograph`] becomes linear light with what its camera noted ([`ExifNotes`]); its field of view
//! comes from a [`Lens`]. [`sun_from_picks`] says where the sun stands, [`propose_layers`] and
//! [`depth_from_values`] how far surfaces are, [`composite`] sets the [`AddedLight`] of a rendered image
//! into it, and the contradictions ([`Finding`]) tell what nature would not do.
//!
//! ```
//! use glam::DVec3;
//! use niji_geometry::direction_from_azimuth_elevation;
//! use niji_photo::circle_through_picks;
//! use niji_radiometry::Radians;
//!
//! // Three points of the wanted bow as directions; at this place they make an arc of 42 degrees.
//! let antisolar = direction_from_azimuth_elevation(Radians(0.0), Radians::from_degrees(-20.0));
//! let (across, up) = (DVec3::X, DVec3::X.cross(antisolar));
//! let picks = [0.4_f64, 1.6, 2.7].map(|turn| {
//!     let (sin, cos) = 42_f64.to_radians().sin_cos();
//!     cos * antisolar + sin * (turn.cos() * across + turn.sin() * up)
//! });
//! let circle = circle_through_picks(picks).expect("they are no line");
//! assert!((circle.bow_angle.to_degrees() - 42.0).abs() < 1e-9);
//! // The sun stands opposite its center.
//! let elevation_deg = (-circle.antisolar.y).asin().to_degrees();
//! assert!((elevation_deg - 20.0).abs() < 1e-9);
//! ```

mod added_light;
mod bow_fit;
mod bow_path;
mod circle_through_picks;
mod color_profile;
mod compositing;
mod contradictions;
mod depth_map;
mod error;
mod exif_notes;
mod exposure;
mod finding;
mod horizon;
mod joint_bilateral;
mod jpeg_end;
mod k_means;
mod layers;
mod layers_file;
mod lens;
mod light_at_surfaces;
mod linear_picture;
mod perceptual;
mod photograph;
mod pick_diagnosis;
mod picture_files;
mod picture_light;
mod picture_provenance;
mod plate;
mod published_directions;
mod resample;
mod sky_border;
mod sky_colors;
mod sky_mask;
mod sky_prior;
mod sky_score;
mod sun_below_apex;
mod sun_from_picks;
mod surroundings;

pub use added_light::distance_of_light;
pub use added_light::surface_of_light;
pub use bow_fit::BowAnglePrior;
pub use bow_fit::BowFit;
pub use bow_fit::FitErrors;
pub use bow_fit::FitRequest;
pub use bow_path::bow_path;
pub use bow_path::broken_lines;
pub use bow_path::draw_line;
pub use circle_through_picks::PickCircle;
pub use circle_through_picks::circle_through_picks;
pub use color_profile::Profile;
pub use compositing::AddedLight;
pub use compositing::alpha_over;
pub use compositing::composite;
pub use compositing::on_region;
pub use compositing::scale_to_white;
pub use contradictions::DropSource;
pub use contradictions::bow_on_the_suns_side;
pub use contradictions::bow_outside_picture;
pub use contradictions::cloud_cover;
pub use contradictions::contrast_too_low;
pub use contradictions::flattened_drops;
pub use contradictions::fogbow_of_large_drops;
pub use contradictions::hidden_by_surface;
pub use contradictions::inside_not_brighter;
pub use contradictions::shadows_point_elsewhere;
pub use contradictions::sun_below_horizon;
pub use contradictions::sun_elsewhere;
pub use contradictions::sun_too_high;
pub use contradictions::supernumeraries_washed_out;
pub use depth_map::Anchor;
pub use depth_map::DepthAlong;
pub use depth_map::DepthKind;
pub use depth_map::depth_from_values;
pub use depth_map::read_depth_map;
pub use depth_map::read_depth_of_frame;
pub use depth_map::read_depth_values;
pub use depth_map::write_depth_map;
pub use error::Error;
pub use exif_notes::ExifNotes;
pub use exposure::Exposure;
pub use exposure::card_value;
pub use exposure::mean_luminance_where;
pub use finding::Finding;
pub use finding::Severity;
pub use horizon::tilt_from_horizon;
pub use horizon::tilt_from_sky;
pub use joint_bilateral::upsample_depth;
pub use joint_bilateral::upsample_labels;
pub use layers::ClusterCount;
pub use layers::Layer;
pub use layers::Layers;
pub use layers::LayersRequest;
pub use layers::depth_of_layers;
pub use layers::propose_layers;
pub use layers_file::layers_to_toml;
pub use layers_file::read_labels;
pub use layers_file::read_layer_distances;
pub use layers_file::write_labels;
pub use lens::Lens;
pub use lens::is_cropped;
pub use linear_picture::LinearPicture;
pub use linear_picture::square_means;
pub use photograph::Encoding;
pub use photograph::Photograph;
pub use photograph::read_texture;
pub use pick_diagnosis::PickedEdge;
pub use pick_diagnosis::diagnose_picks;
pub use picture_files::Frame;
pub use picture_files::PremultipliedPicture;
pub use picture_files::write_jpeg;
pub use picture_files::write_png;
pub use picture_light::SeenBow;
pub use picture_light::hidden_share;
pub use picture_light::luminance_around_bow;
pub use picture_light::peak_contrast;
pub use picture_provenance::read_picture_provenance;
pub use plate::Plate;
pub use published_directions::DirectionExample;
pub use published_directions::published_directions;
pub use sky_mask::SURE_OF_SKY;
pub use sky_mask::SkyMask;
pub use sky_mask::find_sky;
pub use sun_below_apex::sun_below_apex;
pub use sun_from_picks::SunSolution;
pub use sun_from_picks::Verdict;
pub use sun_from_picks::sun_from_picks;
pub use surroundings::Surroundings;
