//! A job for Open Job Description: one template, which AWS Deadline Cloud and others read.
//!
//! Paths are parameters, so that a farm can map them; a template may not hold an absolute path itself, so they stand
//! beside it in the form that `deadline bundle` reads. Frames and tiles are ranges, of which the engine makes the
//! chunks (`TASK_CHUNKING`): a chunk reads `1-3,7`, as this program does. A step begins when those before it
//! succeeded as a whole; there is no other way to wait.

use serde_json::Value;
use serde_json::json;

use super::bundle::Bundle;
use super::bundle::BundleFile;
use super::bundle::Places;
use super::job::Shares;
use super::job::Step;
use super::job::Word;
use super::needs::Needs;

/// Most letters of a job's name.
const MOST_LETTERS: usize = 64;

/// The template and its parameters.
pub(super) fn bundle(steps: &[Step], places: &Places, needs: Needs) -> Bundle {
    let template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "extensions": ["TASK_CHUNKING"],
        "name": name(places),
        "parameterDefinitions": [
            {"name": "Scene", "type": "PATH", "objectType": "FILE", "dataFlow": "IN",
                "description": "The scene. What it names lies beside it."},
            {"name": "Out", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "INOUT",
                "description": "The folder of the pictures, one for all machines."},
            {"name": "Niji", "type": "STRING", "default": "niji", "description": "The program."},
        ],
        "steps": steps.iter().map(|it| step(it, needs)).collect::<Vec<_>>(),
    });
    let value = |name: &str, value: &str| json!({"name": name, "value": value});
    let values = json!({"parameterValues": [
        value("Scene", &places.scene.to_string_lossy()),
        value("Out", &places.out.to_string_lossy()),
    ]});
    let file = |name: &str, value: &Value| BundleFile {
        name: name.to_owned(),
        text: format!("{value:#}\n"),
    };
    Bundle {
        files: vec![
            file("template.json", &template),
            file("parameter_values.json", &values),
        ],
        submitted_by: &["deadline", "bundle", "submit", "."],
    }
}

/// The name of the scene, without what a template would take for more than letters.
fn name(places: &Places) -> String {
    let stem = places
        .scene
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy();
    let letters = stem.chars().filter(|it| !"{}".contains(*it));
    format!("niji {}", letters.take(MOST_LETTERS).collect::<String>())
}

fn step(step: &Step, needs: Needs) -> Value {
    let arguments: Vec<String> = step
        .command
        .iter()
        .map(|it| in_template(it, needs))
        .collect();
    let mut value = json!({
        "name": step.name,
        "hostRequirements": {"amounts": [
            {"name": "amount.worker.vcpu", "min": needs.threads},
            {"name": "amount.worker.memory", "min": needs.memory_mib},
        ]},
        "script": {"actions": {"onRun": {
            "command": "{{Param.Niji}}",
            "args": arguments,
            "cancelation": {"mode": "NOTIFY_THEN_TERMINATE"},
        }}},
    });
    if let Some(before) = step.begins.after() {
        value["dependencies"] = json!([{"dependsOn": before}]);
    }
    let parameters: Vec<Value> = [("Frames", &step.frames), ("Tiles", &step.tiles)]
        .into_iter()
        .filter_map(|(name, shares)| Some(parameter(name, shares.as_ref()?)))
        .collect();
    if !parameters.is_empty() {
        value["parameterSpace"] = json!({"taskParameterDefinitions": parameters});
    }
    value
}

/// A step has one parameter in chunks at most.
fn parameter(name: &str, shares: &Shares) -> Value {
    let range = shares.all.to_string();
    if shares.most == 1 {
        return json!({"name": name, "type": "INT", "range": range});
    }
    json!({"name": name, "type": "CHUNK[INT]", "range": range,
        "chunks": {"defaultTaskCount": shares.most, "rangeConstraint": "NONCONTIGUOUS"}})
}

fn in_template(part: &Word, needs: Needs) -> String {
    match part {
        Word::Text(text) => text.clone(),
        Word::Scene => "{{Param.Scene}}".to_owned(),
        Word::Out => "{{Param.Out}}".to_owned(),
        Word::Inside(file) => format!("{{{{Param.Out}}}}/{file}"),
        Word::Frames => "{{Task.Param.Frames}}".to_owned(),
        Word::TilesOf(n_tiles) => format!("{{{{Task.Param.Tiles}}}}/{n_tiles}"),
        Word::Threads => needs.threads.to_string(),
    }
}
