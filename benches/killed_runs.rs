//! Kills runs, sequences, tiles, saved rows, ice and sweeps at random moments and has them go on; and asks every stage
//! by itself to end.
//!
//!     cargo bench --bench killed_runs -- [KILLS] [SEED] [JOB]
//!
//! Half of the kills cannot be caught (SIGKILL), half ask (SIGTERM). Ends with a message at the first file that is
//! torn, differs from that of an undisturbed job, or is left over.

#[cfg(unix)]
#[path = "../tests/support/killed.rs"]
mod killed;
#[cfg(unix)]
#[path = "../tests/support/mod.rs"]
mod support;

/// Kills of each job in a hundred: rows and a sweep take longest.
#[cfg(unix)]
const SHARES: [u32; 6] = [26, 24, 24, 10, 8, 8];

#[cfg(unix)]
fn main() {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|it| it != "--bench")
        .collect();
    let number = |index: usize, default: u64| {
        let given = arguments.get(index);
        given.map_or(default, |it| it.parse().expect("a whole number"))
    };
    let (n_kills, seed) = (number(0, 500), number(1, 1));
    let wanted = arguments.get(2).map_or("", String::as_str);
    println!("{n_kills} kills, seed {seed}");
    for (job, share) in killed::jobs().iter().zip(SHARES) {
        if !job.name.contains(wanted) {
            continue;
        }
        let n_kills = (n_kills as u32 * share).div_ceil(100);
        let start = std::time::Instant::now();
        let tally = job.kill(n_kills, seed);
        println!(
            "{:<9} killed {} times ({} asked, {} with rows saved), done {} times: same bytes, nothing torn, nothing left; {:.0} s",
            job.name,
            tally.killed,
            tally.asked,
            tally.with_rows,
            tally.done,
            start.elapsed().as_secs_f64()
        );
    }
    if "stages".contains(wanted) {
        ask_stages(n_kills.div_ceil(100), seed);
    }
}

/// Asks every stage to end so many times, and says how long each took at most.
#[cfg(unix)]
fn ask_stages(n_times: u64, seed: u64) {
    let job = killed::stages();
    let rounds: Vec<_> = (seed..seed + n_times)
        .map(|seed| job.ask_each(seed))
        .collect();
    for (index, (command, _)) in rounds[0].iter().enumerate() {
        let longest = rounds.iter().map(|round| round[index].1).max();
        let longest_ms = longest.unwrap_or_default().as_millis();
        println!("asked to end {n_times} times, within {longest_ms} ms: niji {command}");
    }
}

#[cfg(not(unix))]
fn main() {
    println!("kills by signals, which this system does not have");
}
