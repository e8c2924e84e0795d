//! A plan for people to read.

use std::fmt;

use niji_radiometry::Bytes;

use crate::figures::brief;
use crate::figures::length;

use super::decide::SHARE_FOR_EFFECTS;
use super::decided::Plan;
use super::stages::Estimate;
use super::stages::Stage;

impl fmt::Display for Plan {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "{}", self.scene)?;
        writeln!(
            out,
            "{} {:.2} degrees high, azimuth {:.2}",
            self.sun.body.name(),
            self.sun.elevation_deg,
            self.sun.azimuth_deg
        )?;
        self.write_view(out)?;
        writeln!(
            out,
            "\neffects (bounds over display white, {} cd/m2)",
            brief(self.display_white_cd_m2)
        )?;
        for decision in &self.effects {
            let state = if decision.on { "on" } else { "off" };
            writeln!(
                out,
                "  {:<21} {state:<4} {:<27} {}",
                decision.effect, decision.bound, decision.reason
            )?;
        }
        writeln!(
            out,
            "  left out by the plan: {} of {} allowed (half of the tolerance {})",
            brief(self.left_out),
            brief(SHARE_FOR_EFFECTS * self.tolerance),
            brief(self.tolerance)
        )?;
        writeln!(out, "\nlevels")?;
        for (key, level) in self.levels.named() {
            writeln!(out, "  {key:<21} {level}")?;
        }
        writeln!(out, "\nstages")?;
        for stage in &self.stages {
            let name = stage.stage.name();
            writeln!(
                out,
                "  {name:<11} {:<36} {}",
                in_words(stage.stage, &stage.estimate),
                stage.makes
            )?;
        }
        for warning in &self.warnings {
            writeln!(out, "\nwarning: {warning}")?;
        }
        Ok(())
    }
}

impl Plan {
    fn write_view(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Some((low, high)), Some((near_m, far_m))) =
            (self.view.theta_deg, self.view.distance_m)
        else {
            return writeln!(out, "no drops in view");
        };
        writeln!(
            out,
            "drops within {} to {} of the camera, scattering angles {low:.1} to {high:.1} degrees, optical depth up \
             to {} in view and {} towards the sun",
            length(near_m),
            length(far_m),
            brief(self.view.max_optical_depth),
            brief(self.view.max_sun_optical_depth)
        )
    }
}

fn in_words(stage: Stage, estimate: &Estimate) -> String {
    // Pictures are compressed.
    let at_most = if stage == Stage::Render { "<= " } else { "" };
    let memory = estimate.memory_bytes.map(in_units);
    let file = estimate.file_bytes.map(in_units);
    match (memory, file) {
        (Some(memory), Some(file)) => format!("{memory} memory, {at_most}{file} file"),
        (Some(bytes), None) | (None, Some(bytes)) => bytes,
        (None, None) => String::new(),
    }
}

fn in_units(count: u64) -> String {
    Bytes(u128::from(count)).to_string()
}
