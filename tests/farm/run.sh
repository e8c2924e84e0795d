#!/usr/bin/env bash
# `niji farm` on engines that are installed: the pictures of one run, byte by byte, whatever happens on the way.
#   run.sh NIJI FOLDER VENV
set -euo pipefail
niji=$(realpath "$1") venv=$(realpath "$3")
PATH=$venv/bin:$PATH
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$2"
mkdir -p "$2"
work=$(realpath "$2")
cp "$here/picture.toml" "$work/picture.toml"
cat "$here/picture.toml" - >"$work/sequence.toml" <<'TOML'
[sequence]
sun.elevation_deg = [[1, 19.5], [12, 20.5]]
TOML
"$niji" run "$work/sequence.toml" -o "$work/one" --frames 1-12 -q >/dev/null
"$niji" run "$work/picture.toml" -o "$work/one-picture" -q >/dev/null

if command -v slurmctld slurmd munged >/dev/null; then
    "$here/slurm.sh" "$niji" "$work"
else
    echo "left out: Slurm is not installed"
fi
if "$venv/bin/python" -c 'import openjd.cli' 2>/dev/null; then
    "$here/openjd.sh" "$niji" "$work" "$venv"
else
    echo "left out: openjd-cli is not installed"
fi
if "$venv/bin/python" -c 'import hyperqueue' 2>/dev/null; then
    "$venv/bin/python" "$here/hyperqueue_farm.py" "$niji" "$work"
else
    echo "left out: hyperqueue is not installed"
fi
