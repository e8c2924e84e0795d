//! Where the bows stand in the frame, for people: before any light is computed.

use std::fmt::Write as _;

use niji_picture::BowTop;
use niji_picture::PlannedScene;
use niji_picture::SkyMarks;
use niji_scene::Effect;
use niji_scene::PickedBow;
use niji_scene::PickedColor;

use crate::failure::Failure;

/// A line for each bow that is on, and one where no drops stand in the primary.
///
/// # Errors
/// A camera that cannot be.
pub(crate) fn text(planned: &PlannedScene) -> Result<String, Failure> {
    let marks = SkyMarks::of(&planned.scene)?;
    let mut text = String::new();
    for (bow, effect, name) in [
        (PickedBow::Primary, Effect::PrimaryBow, "primary"),
        (PickedBow::Secondary, Effect::SecondaryBow, "secondary"),
    ] {
        if planned.plan.is_on(effect) {
            let top = BowTop::of(&planned.scene, bow)?;
            let _ = writeln!(text, "  {name:<9} {}", place(&marks, bow, top));
        }
    }
    if text.is_empty() {
        return Ok(text);
    }
    Ok(format!(
        "\nbows (of large round drops)\n{text}{}",
        drops_beside(planned, &marks)
    ))
}

/// Where a bow stands.
fn place(marks: &SkyMarks, bow: PickedBow, top: BowTop) -> String {
    let crosses = (marks.bows.iter()).any(|(edge, lines)| edge.bow == bow && !lines.is_empty());
    let of_frame = match (top.place_px, crosses) {
        (Some([x, y]), _) => format!("at column {x:.0}, row {y:.0}"),
        (None, true) => "outside the frame, into which its sides reach".to_owned(),
        (None, false) => format!(
            "outside the frame; camera.azimuth_deg = {:.0} and elevation_deg = {:.0} look there",
            top.azimuth_deg, top.elevation_deg
        ),
    };
    let height = if top.elevation_deg < 0.0 {
        "below the horizon, seen from above only"
    } else {
        "high"
    };
    format!(
        "its top is {:.1} degrees {height}, azimuth {:.0}, {of_frame}",
        top.elevation_deg.abs(),
        top.azimuth_deg
    )
}

/// That no drops in view stand at the angles of the primary bow, and what to move.
fn drops_beside(planned: &PlannedScene, marks: &SkyMarks) -> String {
    let Some((low, high)) = planned.plan.view.theta_deg else {
        return String::new();
    };
    let edge = |color: PickedColor| {
        let mut edges = marks.bows.iter().map(|(edge, _)| edge);
        let found = edges.find(|it| it.bow == PickedBow::Primary && it.color == color);
        found.map_or(0.0, |it| it.angle().to_degrees())
    };
    let [inner, outer] = [PickedColor::Violet, PickedColor::Red].map(edge);
    let [nearest, farthest] = [180.0 - high, 180.0 - low];
    if farthest < inner {
        format!(
            "  all drops in view are inside the primary bow: up to {farthest:.1} degrees from the point opposite to \
             the sun, the bow at {inner:.1} to {outer:.1}. Go nearer to them or let them reach farther\n"
        )
    } else if nearest > outer {
        format!(
            "  all drops in view are outside the primary bow: {nearest:.1} degrees or more from the point opposite to \
             the sun, the bow at {inner:.1} to {outer:.1}. Look farther away from the sun\n"
        )
    } else {
        String::new()
    }
}
