#!/bin/sh
# An iceberg under a rainbow: ice by path tracing, the bow by the ray integral, ended by the ice.
#
#     examples/iceberg_under_a_rainbow.sh OUT [NIJI]
#
# OUT is a new folder; NIJI is the program, `niji` where it is not given. OUT/rainbow.png is the picture,
# OUT/ice.exr the ice alone and OUT/image.exr the bow alone.
set -eu
out=$1
niji=${2:-niji}
scenes=$(dirname "$0")/../data/scenes
rain=$scenes/ice-iceberg-rainbow-rain.toml

mkdir "$out"
"$niji" ice "$scenes/ice-iceberg-rainbow.toml" -o "$out/ice.exr"
"$niji" drops --scene "$rain" -o "$out/drops.vdb"
"$niji" airy -o "$out/airy.exr"
"$niji" scatter --scene "$rain" --airy "$out/airy.exr" -o "$out/scatter.exr"
"$niji" atmosphere --scene "$rain" -o "$out/atmosphere.exr"
"$niji" render --scene "$rain" --drops "$out/drops.vdb" --table "$out/scatter.exr" \
    --air "$out/atmosphere.exr" --depth "$out/ice.exr" -o "$out/image.exr"
# Both count in sunlit white cards.
"$niji" composite "$out/ice.exr" --image "$out/image.exr" --exposure 1 --show-ev 1.5 \
    -o "$out/rainbow.png"
