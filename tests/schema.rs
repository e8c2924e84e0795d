//! `niji schema` prints the files in `data/` that editors read.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

use std::fs;
use std::path::Path;
use std::process::Command;

#[test]
fn the_program_prints_the_schemas_in_data() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    for (arguments, name) in [
        (&["schema"][..], "scene.schema.json"),
        (&["schema", "--ice"], "ice-scene.schema.json"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_niji"))
            .args(arguments)
            .output()
            .unwrap();
        assert!(output.status.success());
        assert!(
            output.stdout == fs::read(data.join(name)).unwrap(),
            "{name}"
        );
    }
}
