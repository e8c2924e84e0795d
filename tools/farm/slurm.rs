//! A job for Slurm: a script a step, which is an array of tasks, and one that submits them.
//!
//! A batch script is copied when it is submitted, so it holds its frames itself: a job that is written over while
//! another one waits changes nothing for that one. An array has as many tasks as `MaxArraySize` allows; where a
//! step has more, it is several arrays, and each script is told which task of the step is the first of its array.

use std::fmt::Write as _;

use super::bundle::Bundle;
use super::bundle::BundleFile;
use super::bundle::Places;
use super::job::Begins;
use super::job::Shares;
use super::job::Step;
use super::job::Word;
use super::needs::Needs;
use crate::shell_word::quoted;
use crate::shell_word::word;

/// What submits the job.
const SUBMIT: &str = "submit.sh";

/// The head of the script that submits. Dependents of a step that failed are removed, not kept waiting.
const HEAD: &str = r#"#!/bin/bash
# Hands the job to Slurm and prints the numbers of its jobs. What is said here goes to every sbatch:
#   submit.sh --account=weather --partition=long --time=2:00:00
set -euo pipefail
cd -- "$(dirname -- "${BASH_SOURCE[0]}")"
mkdir -p log

limit() { scontrol show config | sed -n "s/^$1 *= *//p"; }
if ((n_tasks >= $(limit MaxJobCount))); then
    echo "$n_tasks tasks, and this Slurm keeps fewer (MaxJobCount): larger chunks by niji farm --chunk" >&2
    exit 2
fi
most=$(limit MaxArraySize)

# step NAME TASKS DEPENDENCY: its jobs in $jobs, as a dependency has them.
step() {
    local name=$1 n=$2 dependency=$3 first last job
    jobs=
    for ((first = 0; first < n; first += most)); do
        last=$((n - first < most ? n - first - 1 : most - 1))
        job=$(sbatch --parsable --requeue --kill-on-invalid-dep=yes --chdir="$PWD/log" --open-mode=append \
            --output=%x.%A.%a.log ${dependency:+"--dependency=$dependency"} --array="0-$last" \
            "${flags[@]}" "$PWD/$name.sbatch" "$first")
        jobs+=:${job%%;*}
    done
    echo "$name ${jobs#:}"
}

"#;

/// The scripts of a job.
pub(super) fn bundle(steps: &[Step], places: &Places, needs: Needs) -> Bundle {
    let mut files: Vec<BundleFile> = steps
        .iter()
        .map(|step| BundleFile {
            name: format!("{}.sbatch", step.name),
            text: script(step, places, needs),
        })
        .collect();
    files.push(BundleFile {
        name: SUBMIT.to_owned(),
        text: submit(steps),
    });
    Bundle {
        files,
        submitted_by: &["bash", SUBMIT],
    }
}

fn submit(steps: &[Step]) -> String {
    let n_tasks: usize = steps.iter().map(Step::n_tasks).sum();
    let (shebang, rest) = HEAD.split_at(HEAD.find("set -").unwrap_or(0));
    let mut text = format!("{shebang}n_tasks={n_tasks} flags=(\"$@\")\n{rest}");
    for step in steps {
        let dependency = match step.begins {
            Begins::AtOnce => String::new(),
            Begins::AfterSuccess(before) => format!("afterok${before}"),
            Begins::AfterEnd(before) => format!("afterany${before}"),
        };
        let (name, n_tasks) = (step.name, step.n_tasks());
        // Writing to a String cannot fail.
        let _ = writeln!(text, "step {name} {n_tasks} \"{dependency}\"\n{name}=$jobs");
    }
    text
}

fn script(step: &Step, places: &Places, needs: Needs) -> String {
    let mut text = format!(
        "#!/bin/bash\n#SBATCH --job-name=niji-{}\n#SBATCH --cpus-per-task={}\n#SBATCH --mem={}M\nset -euo pipefail\n\
         scene={}\nout={}\n",
        step.name,
        needs.threads,
        needs.memory_mib,
        quoted(&places.scene),
        quoted(&places.out)
    );
    let n_columns = step.tiles.as_ref().map_or(1, Shares::n_tasks);
    let shared = [
        ("frames", &step.frames, format!("task / {n_columns}")),
        ("tiles", &step.tiles, format!("task % {n_columns}")),
    ];
    if step.n_tasks() > 1 {
        text += "task=$(($1 + SLURM_ARRAY_TASK_ID))\n";
    } else {
        text += "task=0\n";
    }
    for (name, shares, index) in &shared {
        let Some(shares) = shares else { continue };
        let lists: Vec<String> = shares.lists().iter().map(ToString::to_string).collect();
        let lists = lists.join(" ");
        let _ = write!(
            text,
            "all_{name}=({lists})\n{name}=${{all_{name}[{index}]}}\n"
        );
    }
    text += "exec \"${NIJI:-niji}\"";
    for part in &step.command {
        text += " ";
        text += &in_shell(part);
    }
    text + "\n"
}

fn in_shell(part: &Word) -> String {
    match part {
        Word::Text(text) => word(text.as_ref()),
        Word::Scene => "\"$scene\"".to_owned(),
        Word::Out => "\"$out\"".to_owned(),
        Word::Inside(file) => format!("\"$out\"/{file}"),
        Word::Frames => "\"$frames\"".to_owned(),
        Word::TilesOf(n_tiles) => format!("\"$tiles/{n_tiles}\""),
        Word::Threads => "\"$SLURM_CPUS_PER_TASK\"".to_owned(),
    }
}
