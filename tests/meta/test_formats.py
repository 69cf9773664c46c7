"""The JSON that other tools read keeps its schemas."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from shaderlab.model.records import (
    CallsRecord,
    Disagreement,
    DriverResult,
    LineCoverage,
    ModulesRecord,
    Run,
)
from shaderlab.report.formats import json as run_json
from tests.meta.schemas import FOLDER, schemas
from tests.unit.test_report_samples import NAN, record, run


def validate(name: str, repository: Path, output: Any) -> None:
    """Hold an output against a schema, and refuse fields that the schema does not name."""
    schema = json.loads((repository / FOLDER / f"{name}.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.Draft202012Validator(closed(schema)).validate(output)


def closed(schema: Any) -> Any:
    if isinstance(schema, list):
        return [closed(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    found = {name: closed(each) for name, each in schema.items()}
    return found | {"additionalProperties": False} if "properties" in found else found


def full() -> Run:
    """A run with something in each list."""
    calls = CallsRecord(pass_name="p", draw=None, calls=("glClear();",))
    own = record(
        seconds=NAN, timings={"draw": 0.5}, gl_calls=(calls,),
        modules=ModulesRecord(
            judged=1, coverage=(LineCoverage(file="a.frag", line=3, was_run=True),)
        ),
    )  # fmt: skip
    result = DriverResult(driver="x", renderer="y", id="lamp", variant="50", status="pass")
    apart = Disagreement(
        id="lamp", variant="50", output="p.c", drivers=("x", "y"), pixels=4, differing=1, ulp=2.0,
        verdict="within", outside=(), pixel=(1, 2),
    )  # fmt: skip
    return replace(run(own), drivers=(result,), disagreements=(apart,))


@pytest.mark.parametrize(("path", "text"), schemas().items())
def test_a_schema_is_what_the_records_make(repository: Path, path: str, text: str) -> None:
    assert (repository / path).read_text() == text, "run `python -m tests.meta.schemas`"


@pytest.mark.parametrize("made", [run(), run(record()), full()])
def test_runs_keep_their_schema(repository: Path, made: Run) -> None:
    validate("run", repository, json.loads(run_json.render(made)))


def test_a_field_of_another_type_breaks_the_schema(repository: Path) -> None:
    for change in ({"seconds": "soon"}, {"version": 2}, {"extra": 1}):
        with pytest.raises(jsonschema.ValidationError):
            validate("run", repository, json.loads(run_json.render(full())) | change)


def test_lists_keep_their_schema(repository: Path) -> None:
    said = CliRunner().invoke(cli, ["list", "attenuation", "--json", "-"])
    validate("list", repository, json.loads(said.stdout))
