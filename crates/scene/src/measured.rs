//! Measured levels of accuracy: what each costs and how wrong it is.
//!
//! One CSV file holds all measurements, with the columns `stage,level,scene,error,luminance_error,
//! light,radius_um,relative_time,seconds,work,date`; `stage` is a key of the section `[accuracy]` of a
//! scene (or the name of a stage for its total), `level` a level as [`crate::Levels::measured_names`]
//! spells it, with lengths in voxels. `error` is relative to the decision's best level,
//! `relative_time` over that of the standard level. What lets a figure be carried to another scene
//! stands beside it: `luminance_error` and the `light` that it is an error of, both RMS over the picture
//! in gray cards in the sun; the effective radius; the `work` that took the seconds. Figures that were
//! not measured are empty, and the columns of all but `stage`, `level`, `scene` and `date` may be
//! missing.

use serde::Deserialize;
use serde::Serialize;
use thiserror::Error;

/// One level, measured on one scene.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasuredLevel {
    /// Which decision the level belongs to, as `integration`.
    pub stage: String,
    /// The level, as `adaptive relative_error=0.01`.
    pub level: String,
    /// The scene it was measured on.
    pub scene: String,
    /// Relative RMSE of radiance against the reference level.
    #[serde(default)]
    pub error: Option<f64>,
    /// RMSE of luminance against the reference level, in gray cards in the sun.
    #[serde(default)]
    pub luminance_error: Option<f64>,
    /// RMS of the light that the decision is about, as the plan bounds it, in gray cards in the sun.
    #[serde(default)]
    pub light: Option<f64>,
    /// Smallest effective radius of the scene's drops, um.
    #[serde(default)]
    pub radius_um: Option<f64>,
    /// Time over that of the standard level.
    #[serde(default)]
    pub relative_time: Option<f64>,
    /// Time of the stage, s.
    #[serde(default)]
    pub seconds: Option<f64>,
    /// What took that time, in the units of the stage's work.
    #[serde(default)]
    pub work: Option<f64>,
    /// Day of the measurement, as 2026-11-21.
    pub date: String,
}

/// A file of measurements that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("measured levels, line {line}: {message}")]
pub struct MeasuredError {
    /// Line of the file, counted from 1.
    pub line: u64,
    /// What is wrong there.
    pub message: String,
}

/// All measurements.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasuredLevels {
    levels: Vec<MeasuredLevel>,
}

impl MeasuredLevels {
    /// Reads the CSV file.
    ///
    /// ```
    /// use niji_scene::MeasuredLevels;
    ///
    /// let csv = "stage,level,scene,error,relative_time,seconds,date\n\
    ///            sky,none,fog,0.2,0.8,,2026-11-21\n\
    ///            sky,single-scattering,fog,0,1,0.5,2026-11-21\n";
    /// let measured = MeasuredLevels::from_csv(csv)?;
    /// let cheaper = measured.next_cheaper("sky", "single-scattering", "fog").unwrap();
    /// assert_eq!((cheaper.level.as_str(), cheaper.error), ("none", Some(0.2)));
    /// # Ok::<(), niji_scene::MeasuredError>(())
    /// ```
    ///
    /// # Errors
    /// The first line that is not a measurement: columns missing or no numbers, negative or not
    /// finite.
    pub fn from_csv(text: &str) -> Result<Self, MeasuredError> {
        let mut levels = Vec::new();
        for (index, record) in csv::Reader::from_reader(text.as_bytes())
            .deserialize()
            .enumerate()
        {
            let fallback = index as u64 + 2;
            let level: MeasuredLevel = record.map_err(|error: csv::Error| MeasuredError {
                line: error.position().map_or(fallback, csv::Position::line),
                message: error.to_string(),
            })?;
            let figures = [
                level.error,
                level.luminance_error,
                level.light,
                level.radius_um,
                level.relative_time,
                level.seconds,
                level.work,
            ];
            if figures
                .into_iter()
                .flatten()
                .any(|figure| !(figure.is_finite() && figure >= 0.0))
            {
                let message = "expected figures that are finite and not below 0".to_string();
                return Err(MeasuredError {
                    line: fallback,
                    message,
                });
            }
            levels.push(level);
        }
        Ok(Self { levels })
    }

    /// Every measurement, in the order of the file.
    pub fn levels(&self) -> &[MeasuredLevel] {
        &self.levels
    }

    /// The measurements of a level on every scene, with these very settings.
    pub fn of_level<'a>(
        &'a self,
        stage: &'a str,
        level: &'a str,
    ) -> impl Iterator<Item = &'a MeasuredLevel> + 'a {
        let is_it = move |row: &&MeasuredLevel| row.stage == stage && row.level == level;
        self.levels.iter().filter(is_it)
    }

    /// The measurement of a level: on the scene if there is one, else the first on any scene; with
    /// the same settings if there is one, else the first of the same name.
    pub fn find(&self, stage: &str, level: &str, scene: &str) -> Option<&MeasuredLevel> {
        let candidates = || {
            self.levels
                .iter()
                .filter(|measured| measured.stage == stage)
        };
        let name = |level: &str| level.split(' ').next().unwrap_or_default().to_string();
        let exact = || candidates().filter(|measured| measured.level == level);
        let named = || candidates().filter(|measured| name(&measured.level) == name(level));
        exact()
            .find(|measured| measured.scene == scene)
            .or_else(|| named().find(|measured| measured.scene == scene))
            .or_else(|| exact().next())
            .or_else(|| named().next())
    }

    /// Of the levels that are faster on the same scene, the slowest.
    pub fn next_cheaper(&self, stage: &str, level: &str, scene: &str) -> Option<&MeasuredLevel> {
        let (here, time) = self.timed(stage, level, scene)?;
        self.siblings(here)
            .filter(|other| other.relative_time.is_some_and(|other| other < time))
            .max_by(|a, b| by_time(a, b))
    }

    /// Of the levels that are slower on the same scene, the fastest.
    pub fn next_dearer(&self, stage: &str, level: &str, scene: &str) -> Option<&MeasuredLevel> {
        let (here, time) = self.timed(stage, level, scene)?;
        self.siblings(here)
            .filter(|other| other.relative_time.is_some_and(|other| other > time))
            .min_by(|a, b| by_time(a, b))
    }

    fn timed(&self, stage: &str, level: &str, scene: &str) -> Option<(&MeasuredLevel, f64)> {
        let here = self.find(stage, level, scene)?;
        here.relative_time.map(|time| (here, time))
    }

    fn siblings<'a>(
        &'a self,
        here: &'a MeasuredLevel,
    ) -> impl Iterator<Item = &'a MeasuredLevel> + 'a {
        self.levels.iter().filter(|other| {
            other.stage == here.stage && other.scene == here.scene && other.level != here.level
        })
    }
}

fn by_time(a: &MeasuredLevel, b: &MeasuredLevel) -> std::cmp::Ordering {
    a.relative_time
        .unwrap_or(0.0)
        .total_cmp(&b.relative_time.unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CSV: &str = "stage,level,scene,error,relative_time,seconds,date\n\
        integration,fixed-step step_m=1,rain,0.01,3,6.0,2026-11-20\n\
        integration,cell-exact,rain,0.0004,1,2.0,2026-11-20\n\
        integration,adaptive relative_error=0.01,rain,0.003,0.7,,2026-11-20\n\
        integration,cell-exact,fog,0.0001,1,1.0,2026-11-20\n\
        theory,airy,rain,,,,\n";

    #[test]
    fn neighbors_in_cost_are_found_on_the_same_scene() {
        let measured = MeasuredLevels::from_csv(CSV).unwrap();
        let level = |found: Option<&MeasuredLevel>| found.map(|found| found.level.clone());
        let cheaper = measured.next_cheaper("integration", "cell-exact", "rain");
        assert_eq!(
            level(cheaper).as_deref(),
            Some("adaptive relative_error=0.01")
        );
        let dearer = measured.next_dearer("integration", "cell-exact", "rain");
        assert_eq!(level(dearer).as_deref(), Some("fixed-step step_m=1"));
        assert_eq!(
            measured.next_dearer("integration", "cell-exact", "fog"),
            None
        );
        let dearest = measured.next_dearer("integration", "fixed-step step_m=1", "rain");
        assert_eq!(dearest, None);
    }

    #[test]
    fn other_settings_and_other_scenes_stand_in() {
        let measured = MeasuredLevels::from_csv(CSV).unwrap();
        let found = measured
            .find("integration", "adaptive relative_error=0.2", "snow")
            .unwrap();
        assert_eq!((found.error, found.seconds), (Some(0.003), None));
        assert_eq!(measured.find("integration", "guess", "rain"), None);
        let blank = measured.find("theory", "airy", "rain").unwrap();
        assert_eq!((blank.error, blank.relative_time), (None, None));
        assert_eq!(measured.next_cheaper("theory", "airy", "rain"), None);
    }

    #[test]
    fn damaged_files_are_refused_with_the_line() {
        for (right, wrong) in [
            ("0.01,3", "x,3"),
            ("0.01,3", "0.01,-3"),
            ("0.01,3", "NaN,3"),
        ] {
            let error = MeasuredLevels::from_csv(&CSV.replace(right, wrong)).unwrap_err();
            assert_eq!(error.line, 2, "{error}");
        }
        assert!(MeasuredLevels::from_csv("stage,level\na,b\n").is_err());
        assert!(MeasuredLevels::from_csv("").unwrap().levels().is_empty());
    }
}
