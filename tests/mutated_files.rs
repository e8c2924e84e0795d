//! Mutated files of every kind are refused or read, never a panic; `cargo bench --bench mutated_files` tries more.

#[path = "support/mutations.rs"]
mod mutations;

/// Files of each kind, each of a seed of its own.
const N_FILES: u64 = 120;

#[test]
fn mutated_files_of_every_kind_are_an_error_or_a_result() {
    let folder = tempfile::tempdir().expect("a folder for mutated files");
    for reader in mutations::readers() {
        let is_broken = |seed: &u64| reader.try_seed(*seed, folder.path()).is_broken;
        let broken: Vec<u64> = (0..N_FILES / reader.cost).filter(is_broken).collect();
        assert!(broken.is_empty(), "{}: seeds {broken:?}", reader.file);
    }
}

#[test]
fn the_files_that_are_mutated_are_sound() {
    let folder = tempfile::tempdir().expect("a folder for files");
    for reader in mutations::readers() {
        // Of those that take long, some.
        let samples = reader.samples.iter().step_by(reader.cost as usize);
        for (index, sample) in samples.enumerate() {
            reader.put(folder.path(), sample);
            assert!(reader.read(folder.path()), "{}: {index}", reader.file);
        }
    }
}
