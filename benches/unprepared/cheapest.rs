//! What the choice for a tolerance costs beside the cheapest that would have kept it.
//!
//! From the scene as it is, coarser tolerances are tried, each twice the last, then, one by one on top of the cheapest of
//! these, other theories and every effect that was decided to be on, off. What errs by less than was asked, against the
//! truth, and takes less processor time is kept. Small pictures of the plan are not counted: both have them.

use std::path::Path;
use std::process::Command;

use nix::sys::resource::UsageWho;
use nix::sys::resource::getrusage;

use super::Result;
use super::Run;
use super::processor_time::processor_time;
use super::scene_file;
use super::with_key;

/// Tolerances over what is asked.
const COARSER: [f64; 5] = [2.0, 4.0, 8.0, 16.0, 32.0];
const THEORIES: [&str; 2] = ["uniform", "airy"];
/// A cost below that of another is less where it is below this part of it.
const LESS: f64 = 0.97;

/// A way to make the picture.
struct Way {
    text: String,
    processor_s: f64,
    run: Run,
}

/// Prints what a scene costs as it was chosen, and the cheapest way that keeps what was asked.
pub(crate) fn search(name: &str) -> Result<()> {
    let path = scene_file(name);
    let folder = path.parent().unwrap_or(Path::new("."));
    let text = std::fs::read_to_string(&path)?;
    let chosen = Way::of((name, folder), text)?;
    let plan = &chosen.run.report["plan"];
    let asked = plan["tolerance"]
        .as_f64()
        .ok_or("a plan without tolerance")?;
    let effects = plan["effects"].as_array().into_iter().flatten();
    let effects = effects.filter(|it| it["asked"] == "auto" && it["on"] == true);
    let effects = effects.filter_map(|it| it["effect"].as_str());
    let off = effects.map(|it| format!("effects.{it} = \"off\""));
    let theories = THEORIES.map(|it| format!("accuracy.theory = \"{it}\""));
    let coarser = COARSER.map(|times| format!("accuracy.tolerance = {}", times * asked));

    let (mut best, mut changes) = (None::<Way>, Vec::new());
    for change in coarser.into_iter().chain(theories).chain(off) {
        let least = best.as_ref().unwrap_or(&chosen);
        let way = Way::of((name, folder), with_key(&least.text, &change)?);
        // What has no light, or no such theory, is no way.
        let Ok(way) = way else { continue };
        if way.run.true_error() <= asked && way.processor_s < LESS * least.processor_s {
            best = Some(way);
            changes.push(change);
        }
    }
    let least = best.as_ref().unwrap_or(&chosen);
    println!(
        "{name:<20} chosen {:>6.2} s, {:.3} % off; cheapest {:>6.2} s, {:.3} % off: {:.2} times; {}",
        chosen.processor_s,
        100.0 * chosen.run.true_error(),
        least.processor_s,
        100.0 * least.run.true_error(),
        chosen.processor_s / least.processor_s,
        changes.join(", ")
    );
    Ok(())
}

impl Way {
    /// Makes the picture of a scene; its files lie in the folder.
    fn of((name, folder): (&str, &Path), text: String) -> Result<Self> {
        let named = tempfile::Builder::new()
            .suffix(".toml")
            .tempfile_in(folder)?;
        std::fs::write(named.path(), &text)?;
        let choices = tempfile::tempdir()?;
        let choice = choices.path().join("choice.toml");
        let plan = Command::new(env!("CARGO_BIN_EXE_niji"))
            .args(["plan", "-o"])
            .arg(&choice)
            .arg(named.path())
            .output()?;
        if !plan.status.success() {
            return Err(String::from_utf8_lossy(&plan.stderr).into());
        }
        let choice = choice.to_str().ok_or("a path that is no text")?;
        let flags = ["--choice", choice].map(str::to_owned);
        let before_s = processor_seconds()?;
        let run = Run::of((name, named.path()), &flags)?.map_err(|(_, said)| said)?;
        Ok(Self {
            text,
            processor_s: processor_seconds()? - before_s,
            run,
        })
    }
}

/// Processor time of all programs that were started and have ended.
fn processor_seconds() -> Result<f64> {
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN)?;
    Ok(processor_time(&usage).as_secs_f64())
}
