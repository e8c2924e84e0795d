"""Asks somebody else's validator whether the shipped scenes are as the JSON Schemas say.

usage: check_schema.py DATA_FOLDER
"""

import json
import sys
import tomllib
from pathlib import Path

from jsonschema import Draft202012Validator


def validator(path: Path) -> Draft202012Validator:
    """The validator of a schema that is itself as the draft says."""
    schema = json.loads(path.read_text(encoding="utf-8"))
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def faults(scene: dict, schema: Draft202012Validator) -> list[str]:
    """What is wrong in a scene, with its place."""
    return [f"{error.json_path}: {error.message}" for error in schema.iter_errors(scene)]


def main() -> int:
    data = Path(sys.argv[1])
    drops = validator(data / "scene.schema.json")
    ice = validator(data / "ice-scene.schema.json")
    paths = sorted([*data.glob("scenes/*.toml"), *data.glob("measurements/*.toml")])
    n_faults = 0
    for path in paths:
        scene = tomllib.loads(path.read_text(encoding="utf-8"))
        schema = ice if "ice" in scene else drops
        for fault in faults(scene, schema):
            print(f"{path}: {fault}", file=sys.stderr)
            n_faults += 1
        # A key that no scene has is refused at the top and in a section.
        for wrong in [{**scene, "no_such_key": 1}, {**scene, "camera": {"no_such_key": 1}}]:
            if not faults(wrong, schema):
                print(f"{path}: a key that no scene has was accepted", file=sys.stderr)
                n_faults += 1
    print(f"{len(paths)} scenes, {n_faults} faults")
    return 1 if n_faults or not paths else 0


if __name__ == "__main__":
    sys.exit(main())
