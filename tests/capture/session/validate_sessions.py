"""Validates session documents against docs/session.schema.json.

usage: validate_sessions.py SCHEMA FOLDER
Prints, for each *.json of FOLDER in order, its name and "valid" or "invalid". Exits with 77 when
the jsonschema package is absent.
"""
import json
import pathlib
import sys

try:
    import jsonschema
except ImportError:
    print("python3-jsonschema is not installed")
    sys.exit(77)

schema = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)
for path in sorted(pathlib.Path(sys.argv[2]).glob("*.json")):
    try:
        valid = validator.is_valid(json.loads(path.read_text(encoding="utf-8")))
    except json.JSONDecodeError:
        valid = False
    print(path.stem, "valid" if valid else "invalid")
