//! Our side of the speed comparison with OpenVDB that `tests/peers/vdb_speed.py` runs.
//!
//! `read FILE` reads a file and looks at every value; `write FILE OUT none|zip` reads a file, then
//! writes it. Either prints one line: seconds, active voxels, the sum of the bits of all active
//! values, and the peak memory of the process in MiB. Only reading or writing itself is timed.

use std::error::Error;
use std::fs::File;
use std::path::Path;
use std::time::Instant;

use niji_vdb::Compression;
use niji_vdb::Leaf;
use niji_vdb::SparseTree;
use niji_vdb::VdbFile;

const USAGE: &str = "usage: vdb_speed read FILE | write FILE OUT none|zip";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = std::env::args().skip(1).collect::<Vec<_>>();
    let arguments = arguments.iter().map(String::as_str).collect::<Vec<_>>();
    let (file, seconds) = match arguments[..] {
        ["read", path] => {
            let start = Instant::now();
            let file = VdbFile::read(Path::new(path))?;
            (file, start.elapsed().as_secs_f64())
        }
        ["write", path, out, compression] => {
            let compression = match compression {
                "none" => Compression::None,
                "zip" => Compression::Zip,
                _ => return Err(USAGE.into()),
            };
            let file = VdbFile::read(Path::new(path))?;
            let start = Instant::now();
            file.write(File::create(out)?, compression)?;
            let seconds = start.elapsed().as_secs_f64();
            (file, seconds)
        }
        _ => return Err(USAGE.into()),
    };
    let (mut n_active, mut bits) = (0_u64, 0_u64);
    let trees = file.grids.iter().filter_map(|grid| grid.tree.as_float());
    for (_, value) in trees.flat_map(SparseTree::leaves).flat_map(Leaf::active) {
        n_active += 1;
        bits += u64::from(value.to_bits());
    }
    println!("{seconds} {n_active} {bits} {}", peak_mib()?);
    Ok(())
}

/// Peak memory of this process, as Linux tells it.
fn peak_mib() -> Result<f64, Box<dyn Error>> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.ok_or("no VmHWM in /proc/self/status")?;
    Ok(kilobytes.trim().trim_end_matches(" kB").parse::<f64>()? / 1024.0)
}
