#!/usr/bin/env bash
# `niji farm` on Open Job Description: every template is checked, and run by the reference implementation.
#   openjd.sh NIJI FOLDER VENV    as tests/farm/slurm.sh
set -euo pipefail
niji=$(realpath "$1") work=$(realpath "$2") openjd=$(realpath "$3")/bin/openjd
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
# shellcheck source=SCRIPTDIR/tools.sh
. "$here/tools.sh"

# job PROGRAM ARGUMENTS...: writes a job and runs it with another program in its tasks.
job() {
    local program=$1 folder
    shift
    folder=$("$niji" farm "$@" --engine openjd -q)
    "$openjd" check "$folder/template.json"
    # What `deadline bundle` reads, in the form of openjd.
    python3 -c 'import json, sys
values = json.load(open(sys.argv[1]))["parameterValues"]
print(json.dumps({it["name"]: it["value"] for it in values} | {"Niji": sys.argv[2]}))' \
        "$folder/parameter_values.json" "$program" >"$work/parameters.json"
    "$openjd" run "$folder/template.json" --step check --run-dependencies \
        --job-param "file://$work/parameters.json" >"$work/openjd.log" 2>&1
}

out="$work/o d {{x}}'\"" # a name that has to be quoted
echo "openjd: frames, of which some fail"
printf '#!/bin/bash\ncase "$*" in *"--frames 7-9 "*) exit 1 ;; esac\nexec "%s" "$@"\n' "$niji" >"$work/fails"
chmod +x "$work/fails"
job "$work/fails" "$work/sequence.toml" -o "$out" --frames 1-12 --chunk 3 && exit 1
left=$(left_in "$out")
[[ ",$left" == *7-* ]] # the engine goes on as it likes
job "$niji" "$work/sequence.toml" -o "$out" --frames "$left"
same "$work/one" "$out"
lose "$out"
job "$niji" "$work/sequence.toml" -o "$out" --frames 5,9 --force
same "$work/one" "$out"

echo "openjd: a picture in tiles, two a task, and frames in tiles"
job "$niji" "$work/picture.toml" -o "$work/o-tiles" --tiles 8 --chunk 2
same "$work/one-picture" "$work/o-tiles"
job "$niji" "$work/sequence.toml" -o "$work/o-all" --frames 1-12 --tiles 4
same "$work/one" "$work/o-all"
echo "openjd: done"
