//! An example for the help of each shape of `niji drops`.

/// Shapes and a command that makes drops in each.
const EXAMPLES: [(&str, &str); 10] = [
    (
        "uniform",
        "  niji drops uniform --box-min-m=-50,0,-150 --box-max-m=50,60,-50 --voxel-m 2 \\
      --law monodisperse --radius-um 100 --number-density-m3 1000 -o spray.vdb",
    ),
    (
        "gradient",
        "  niji drops gradient --box-min-m=-200,0,-300 --box-max-m=200,150,-100 --voxel-m 5 \\
      --axis y --radius-at-min-um 1500 --radius-at-max-um 10 \\
      --number-density-at-min-m3 1000 --number-density-at-max-m3 1000 -o gradient.vdb",
    ),
    (
        "rain-shaft",
        "  niji drops rain-shaft --rain-rate-mm-h 5 --footprint column --radius-m 300 \\
      --center-xz-m 0,-500 --base-y-m 0 --top-y-m 800 --voxel-m 20 -o rain.vdb",
    ),
    (
        "rain-cell",
        "  niji drops rain-cell --max-rain-rate-mm-h 30 --radius-m 700 --center-xz-m 0,-3000 \\
      --base-y-m 0 --top-y-m 1800 --turbulence-strength 0.6 --turbulence-eddy-m 400 \\
      --voxel-m 60 -o cell.vdb",
    ),
    (
        "fountain",
        "  niji drops fountain --nozzle-m 0,0.3,-10 --speed-m-s 14 --spread-deg 14 \\
      --flow-kg-s 0.3 --effective-radius-um 400 --effective-variance 0.1 --basin-y-m 0 \\
      --voxel-m 0.25 -o fountain.vdb",
    ),
    (
        "waterfall",
        "  niji drops waterfall --foot-m 0,0,-140 --azimuth-deg 180 --height-m 40 --width-m 120 \\
      --flow-kg-s 900 --splash-fraction 0.05 --mist-fraction 0.003 \\
      --curtain-effective-radius-um 800 --splash-effective-radius-um 300 \\
      --mist-effective-radius-um 50 --wind-xz-m-s 1.5,0.4 --voxel-m 2 -o waterfall.vdb",
    ),
    (
        "fog-bank",
        "  niji drops fog-bank --box-min-m=-200,-60,-140 --box-max-m=200,60,-20 --profile even \\
      --max-lwc-g-m3 0.06 --max-effective-radius-um 9 --effective-variance 0.08 \\
      --voxel-m 5 -o fog.vdb",
    ),
    (
        "sea-spray",
        "  niji drops sea-spray --box-min-m=-200,0,-180 --box-max-m=200,30,-12 \\
      --surface-lwc-g-m3 0.5 --scale-height-m 6 --median-radius-um 40 \\
      --geometric-standard-deviation 1.6 --voxel-m 2 -o spray.vdb",
    ),
    (
        "cloud",
        "  niji drops cloud --form cumulus --center-xz-m 0,-3000 --width-x-m 2400 --width-z-m 1800 \\
      --base-y-m 900 --top-y-m 2100 --number-density-m3 3e8 --turbulence-strength 0.6 \\
      --turbulence-eddy-m 500 --voxel-m 40 -o cloud.vdb",
    ),
    (
        "from-vdb",
        "  niji drops from-vdb smoke.vdb --grid density --density-means water --scale 0.3 \\
      --effective-radius-um 200 -o drops.vdb
  niji drops from-vdb smoke.vdb --density-means optical-depth --scale 2 \\
      --effective-radius-um 200 --effective-variance 0.1 -o drops.vdb
  niji drops from-vdb steam.vdb --density-means water --scale 0.3 --up z --units-per-m 100 \\
      --effective-radius-um '6 + 0.5*sqrt(age)' -o drops.vdb",
    ),
];

/// What the help of a shape ends with; nothing for a shape that has no example.
pub(super) fn of(name: &str) -> String {
    let found = EXAMPLES.iter().find(|(shape, _)| *shape == name);
    found.map_or_else(String::new, |(_, lines)| format!("Example:\n{lines}"))
}
