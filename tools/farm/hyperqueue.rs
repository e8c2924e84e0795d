//! A job for HyperQueue: a script of Python, which builds it in loops and submits it.
//!
//! HyperQueue's job files have a line for every task and cannot wait within an array, so that a sequence in tiles
//! would take tens of megabytes; and its package of Python is what PyPI has. A picture is put together as soon as
//! its own tiles are there. Tasks that wait for one that failed are given up, all others are made.

use std::fmt::Write as _;

use serde_json::json;

use super::bundle::Bundle;
use super::bundle::BundleFile;
use super::bundle::Places;
use super::job::Shares;
use super::job::Step;
use super::job::Word;
use super::needs::Needs;

/// The script.
const SUBMIT: &str = "submit.py";

/// What comes first.
const HEAD: &str = r#"#!/usr/bin/env python3
"""Hands the job to the HyperQueue server of HQ_SERVER_DIR [default: ~/.hq-server] and prints its number.

Workers that `hq worker start` made offer "mem"; for others (a LocalCluster) say NIJI_MEMORY=any.
"""
import os

from hyperqueue import Client, Job
from hyperqueue.ffi.protocol import ResourceRequest

NIJI = os.environ.get("NIJI", "niji")
"#;

/// What the steps are made with.
const TOOLS: &str = r#"
os.chdir(os.path.dirname(os.path.abspath(__file__)))
os.makedirs("log", exist_ok=True)
needs = {"cpus": THREADS}
if os.environ.get("NIJI_MEMORY") != "any":
    needs["resources"] = {"mem": MEMORY_MIB}
job = Job(name=NAME, default_workdir="log", max_fails=None)
made = {}


def numbers(chunk):
    """The frames of `1-3,7,10-20:2`."""
    for part in chunk.split(","):
        span, _, every = part.partition(":")
        first, _, last = span.partition("-")
        yield from range(int(first), int(last or first) + 1, int(every or 1))


def step(name, after, command, frames=("",), tiles=("",)):
    """A task for each chunk of frames times each of tiles; it waits for those before it that have its frames."""
    earlier = made.get(after, {})
    made[name] = {}
    for mine in frames:
        own = set(numbers(mine)) if mine else {0}
        before = {task.task_id: task for key in own & earlier.keys() or earlier for task in earlier[key]}
        tasks = [
            job.program(
                command(mine, tile),
                name=" ".join(filter(None, (name, mine, tile))),
                deps=list(before.values()),
                stdout="%{JOB_ID}.%{TASK_ID}.out",
                stderr="%{JOB_ID}.%{TASK_ID}.log",
                resources=ResourceRequest(**needs),
            )
            for tile in tiles
        ]
        made[name].update((frame, tasks) for frame in own)


"#;

/// What comes last.
const TAIL: &str = "\nprint(Client(os.environ.get(\"HQ_SERVER_DIR\")).submit(job).id)\n";

/// The script of a job.
pub(super) fn bundle(steps: &[Step], places: &Places, needs: Needs) -> Bundle {
    let name = places
        .scene
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy();
    let mut text = HEAD.to_owned();
    for (key, value) in [
        ("SCENE", json!(places.scene.to_string_lossy())),
        ("OUT", json!(places.out.to_string_lossy())),
        ("NAME", json!(format!("niji {name}"))),
        ("THREADS", json!(needs.threads)),
        ("MEMORY_MIB", json!(needs.memory_mib)),
    ] {
        // Writing to a String cannot fail. A string of JSON is one of Python.
        let _ = writeln!(text, "{key} = {value}");
    }
    text += TOOLS;
    for step in steps {
        write_step(step, needs, &mut text);
    }
    text += TAIL;
    Bundle {
        files: vec![BundleFile {
            name: SUBMIT.to_owned(),
            text,
        }],
        submitted_by: &["python3", SUBMIT],
    }
}

fn write_step(step: &Step, needs: Needs, text: &mut String) {
    let words: Vec<String> = step.command.iter().map(|it| in_python(it, needs)).collect();
    let _ = write!(
        text,
        "step(\n    {},\n    {},\n    lambda frames, tiles: [NIJI, {}],\n",
        json!(step.name),
        step.begins
            .after()
            .map_or("None".to_owned(), |it| json!(it).to_string()),
        words.join(", ")
    );
    for (name, shares) in [("frames", &step.frames), ("tiles", &step.tiles)] {
        let lists = shares
            .iter()
            .flat_map(Shares::lists)
            .map(|it| it.to_string());
        let lists: Vec<String> = lists.collect();
        if !lists.is_empty() {
            let _ = writeln!(text, "    {name}={}.split(),", json!(lists.join(" ")));
        }
    }
    *text += ")\n";
}

fn in_python(part: &Word, needs: Needs) -> String {
    match part {
        Word::Text(text) => json!(text).to_string(),
        Word::Scene => "SCENE".to_owned(),
        Word::Out => "OUT".to_owned(),
        Word::Inside(file) => format!("os.path.join(OUT, {})", json!(file)),
        Word::Frames => "frames".to_owned(),
        Word::TilesOf(n_tiles) => format!("f\"{{tiles}}/{n_tiles}\""),
        Word::Threads => json!(needs.threads.to_string()).to_string(),
    }
}
