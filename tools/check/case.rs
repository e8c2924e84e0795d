//! What nature would not do, asked of everything that a call of `niji check` gives.

use std::path::Path;

use glam::DVec3;
use ndarray::Array2;
use niji_exchange::SpectralImage;
use niji_geometry::PinholeCamera;
use niji_geometry::direction_from_azimuth_elevation;
use niji_photo::AddedLight;
use niji_photo::DropSource;
use niji_photo::Exposure;
use niji_photo::Finding;
use niji_photo::Photograph;
use niji_photo::SeenBow;
use niji_photo::bow_on_the_suns_side;
use niji_photo::bow_outside_picture;
use niji_photo::bow_path;
use niji_photo::card_value;
use niji_photo::cloud_cover;
use niji_photo::contrast_too_low;
use niji_photo::flattened_drops;
use niji_photo::fogbow_of_large_drops;
use niji_photo::hidden_by_surface;
use niji_photo::hidden_share;
use niji_photo::inside_not_brighter;
use niji_photo::luminance_around_bow;
use niji_photo::peak_contrast;
use niji_photo::read_depth_map;
use niji_photo::shadows_point_elsewhere;
use niji_photo::sun_below_horizon;
use niji_photo::sun_elsewhere;
use niji_photo::sun_too_high;
use niji_photo::supernumeraries_washed_out;
use niji_picture::BowEdge;
use niji_radiometry::Micrometers;
use niji_radiometry::Radians;
use niji_radiometry::RgbPrimaries;
use niji_scene::Moment;
use niji_scene::PickedColor;

use super::CheckCommand;
use super::Source;
use crate::failure::Failure;
use crate::schema_flags::name;

/// What all checks of one call share.
struct Case<'a> {
    command: &'a CheckCommand,
    photo: &'a Photograph,
    camera: PinholeCamera,
    sun: DVec3,
    elevation: Radians,
    bow_angle: Radians,
    path_px: Vec<[f64; 2]>,
}

/// Everything that speaks against the bow, the worst first.
///
/// # Errors
/// Inputs that cannot be read.
pub(super) fn findings(command: &CheckCommand) -> Result<Vec<Finding>, Failure> {
    let photo = Photograph::read(&command.source.photo)
        .map_err(|error| Failure::bad_input(&command.source.photo, error))?;
    let camera = command.camera.camera(&photo)?.pinhole()?;
    let elevation = Radians::from_degrees(command.sun_elevation_deg);
    let azimuth = Radians::from_degrees(command.sun_azimuth_deg);
    let sun = direction_from_azimuth_elevation(azimuth, elevation);
    if !sun.is_finite() {
        return Err(Failure::Usage(
            "expected finite angles of the sun".to_owned(),
        ));
    }
    let red = BowEdge {
        bow: command.bow,
        color: PickedColor::Red,
        water: command.water.water()?,
    };
    let bow_angle = red.angle();
    let path = bow_path(&camera.into(), -sun, bow_angle);
    let case = Case {
        command,
        photo: &photo,
        camera,
        sun,
        elevation,
        bow_angle,
        path_px: path.into_iter().flatten().collect(),
    };
    let mut findings = case.geometry();
    findings.extend(case.weather_and_drops());
    findings.extend(case.ephemeris()?);
    findings.extend(case.files()?);
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    Ok(findings)
}

impl Case<'_> {
    fn geometry(&self) -> Vec<Finding> {
        let (width, height) = (
            f64::from(self.camera.width_px()),
            f64::from(self.camera.height_px()),
        );
        let corner = |x: f64, y: f64| self.camera.ray(x * width, y * height).direction;
        let corners = [
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(0.0, 1.0),
            corner(1.0, 1.0),
        ];
        let lowest = corners.iter().map(|view| view.y).fold(1.0, f64::min);
        let forward = self.camera.forward();
        let half_diagonal = corners
            .iter()
            .map(|view| view.angle_between(forward))
            .fold(0.0, f64::max);
        let from_sun = Radians(forward.angle_between(self.sun));
        [
            sun_below_horizon(self.elevation),
            sun_too_high(self.elevation, self.bow_angle, Radians(lowest.asin())),
            bow_on_the_suns_side(from_sun, Radians(half_diagonal)),
            bow_outside_picture(self.path_px.len()),
            self.shadow_error().and_then(shadows_point_elsewhere),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Angle on the ground between a shadow and the direction away from the sun.
    fn shadow_error(&self) -> Option<Radians> {
        let [x, y, tip_x, tip_y] = self.command.shadow?;
        let ground = |x: f64, y: f64| {
            let view = self.camera.ray(x, y).direction;
            (view.y < 0.0).then(|| view / -view.y)
        };
        let along = ground(tip_x, tip_y)? - ground(x, y)?;
        let away = DVec3::new(-self.sun.x, 0.0, -self.sun.z);
        let angle = along.angle_between(away);
        angle.is_finite().then_some(Radians(angle))
    }

    fn weather_and_drops(&self) -> Vec<Finding> {
        let command = self.command;
        let source = match command.drops {
            Source::Rain => DropSource::Rain,
            Source::Spray => DropSource::Spray,
            Source::Fog => DropSource::Fog,
        };
        let radius = command.radius_um.map(Micrometers);
        let fringes = command.variance.filter(|_| command.supernumeraries);
        [
            command
                .cloud_cover
                .and_then(|cover| cloud_cover(cover, source)),
            radius.and_then(|radius| flattened_drops(radius, self.elevation)),
            radius
                .filter(|_| command.fogbow)
                .and_then(fogbow_of_large_drops),
            fringes.and_then(supernumeraries_washed_out),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    fn ephemeris(&self) -> Result<Option<Finding>, Failure> {
        let (command, notes) = (self.command, &self.photo.notes);
        let time = command.time.or(notes.local_time);
        let offset = command.utc_offset_h.or(notes.utc_offset_h);
        let place = command.place_deg.or(notes.position_deg);
        let (Some(local_time), Some(utc_offset_h), Some([latitude_deg, longitude_deg])) =
            (time, offset, place)
        else {
            return Ok(None);
        };
        let at = Moment {
            local_time,
            utc_offset_h,
            latitude_deg,
            longitude_deg,
        };
        let difference = Radians(at.sun()?.direction().angle_between(self.sun));
        let error = Radians::from_degrees(command.sun_error_deg);
        let Some(mut finding) = sun_elsewhere(difference, error) else {
            return Ok(None);
        };
        let (shift_h, left) = at.best_shift_h(self.sun)?;
        if shift_h != 0 && left.0 < 0.5 * difference.0 {
            finding.suggestion = format!(
                "a clock {:+} hours ahead of UTC would fit to {:.1} degrees: is the camera on another \
                 time zone?",
                utc_offset_h + f64::from(shift_h),
                left.to_degrees()
            );
        }
        Ok(Some(finding))
    }

    fn files(&self) -> Result<Vec<Finding>, Failure> {
        let mut findings = Vec::new();
        let command = self.command;
        if let Some(path) = &command.image {
            let image = SpectralImage::read_spectral(path)
                .map_err(|error| Failure::bad_input(path, error))?;
            let of_image = |error: niji_photo::Error| Failure::bad_input(path, error);
            let light = AddedLight::of_image(&image, RgbPrimaries::Rec709).map_err(of_image)?;
            let added = light.resized(self.photo.light.dim()).map_err(of_image)?;
            let gain = card_value(Exposure::GreyWorld, &self.photo.light, &self.photo.notes)
                .map_err(of_image)?;
            let contrast = peak_contrast(&self.photo.light, &added, gain).map_err(of_image)?;
            findings.extend(contrast_too_low(contrast, &name(command.bow)));
        }
        let depth_m = command.depth.as_ref().map(|path| self.depth_m(path));
        let depth_m = depth_m.transpose()?;
        if let (Some(depth_m), Some(drops_m)) = (&depth_m, command.drops_distance_m) {
            let hidden = hidden_share(&self.path_px, depth_m, drops_m);
            findings.extend(hidden_by_surface(hidden));
        }
        let is_sky = depth_m.map(|it| it.mapv(f32::is_infinite));
        let bow = SeenBow {
            camera: &self.camera,
            antisolar: -self.sun,
            bow_angle: self.bow_angle,
        };
        let [inside, outside] = luminance_around_bow(&self.photo.light, &bow, is_sky.as_ref());
        findings.extend(inside_not_brighter(inside, outside));
        Ok(findings)
    }

    /// The distances of what was photographed.
    fn depth_m(&self, path: &Path) -> Result<Array2<f32>, Failure> {
        let depth_m = read_depth_map(path).map_err(|error| Failure::bad_input(path, error))?;
        if depth_m.dim() != self.photo.light.dim() {
            let message = "found another size than that of the photograph";
            return Err(Failure::bad_input(path, message));
        }
        Ok(depth_m)
    }
}
