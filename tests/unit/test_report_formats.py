"""Each output format is one module and one line: the options of the commands follow from it."""

from __future__ import annotations

import importlib
import pkgutil
import sys
from pathlib import Path
from types import ModuleType

import click
import pytest
from click.testing import CliRunner

from shaderlab.cli import cli, options as files
from shaderlab.cli.options import SUMMARY_VARIABLE
from shaderlab.errors import UsageError
from shaderlab.model.records import Run
from shaderlab.report import formats
from tests.unit.test_report_samples import record, run


def test_every_module_of_the_folder_is_a_format() -> None:
    modules = {module.name for module in pkgutil.iter_modules(formats.__path__)}
    assert {format.name for format in formats.FORMATS} == modules


@pytest.mark.parametrize("format", formats.FORMATS)
@pytest.mark.parametrize("command", ["run", "report"])
def test_commands_have_an_option_for_each(command: str, format: formats.Format) -> None:
    help = CliRunner().invoke(cli, [command, "-h"]).output
    assert f"--{format.name} FILE" in help and format.help in " ".join(help.split())


@pytest.mark.parametrize("format", formats.FORMATS)
def test_a_run_without_records_can_be_written(format: formats.Format) -> None:
    assert isinstance(format.render(run()), str)


@pytest.mark.parametrize("format", formats.FORMATS)
def test_a_format_of_findings_has_a_function_for_them(format: formats.Format) -> None:
    module = importlib.import_module(f"{formats.__name__}.{format.name}")
    assert hasattr(module, "render_findings") is format.findings
    if format.findings:
        assert isinstance(format.render_findings([], "compile"), str)


def test_a_new_format_is_a_module_and_a_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def render(run: Run) -> str:
        return " ".join(record.id for record in run.records)

    module = ModuleType("shaderlab.report.formats.names")
    module.render = render  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, module.__name__, module)
    line = formats.Format("names", "Write the names of all cases.")
    monkeypatch.setattr(files, "FORMATS", (*formats.FORMATS, line))

    @click.command()
    @files.output_options
    def command(outputs: dict[str, str]) -> None:
        assert files.uses_stdout(outputs)
        assert not list(files.write_outputs(run(record("a"), record("b")), outputs))

    result = CliRunner().invoke(command, ["--names", "-"], catch_exceptions=False)
    assert result.output == "a b"


def test_one_output_at_most_goes_to_stdout() -> None:
    assert not files.uses_stdout({"json": "a.json"})
    with pytest.raises(UsageError, match="only one of --json and --junit"):
        files.uses_stdout({"json": "-", "junit": "-"})


def test_an_output_that_cannot_be_written_stops_no_other(tmp_path: Path) -> None:
    summary = tmp_path / "summary.md"
    outputs = {"json": str(tmp_path), "markdown": str(summary)}
    (problem,) = files.write_outputs(run(), outputs)
    assert isinstance(problem, UsageError) and problem.file == str(tmp_path)
    assert summary.read_text()


def test_a_jobs_summary_keeps_what_earlier_steps_wrote(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    summary = tmp_path / "summary.md"
    summary.write_text("## Earlier\n\n")
    monkeypatch.setenv(SUMMARY_VARIABLE, str(summary))
    (tmp_path / "link.md").symlink_to("summary.md")
    outputs = {"markdown": str(tmp_path / "link.md"), "json": str(tmp_path / "out.json")}
    for _ in range(2):
        assert not list(files.write_outputs(run(), outputs))
    (text,) = (f.render(run()) for f in formats.FORMATS if f.name == "markdown")
    assert summary.read_text() == f"## Earlier\n\n\n{text}\n{text}"
    monkeypatch.delenv(SUMMARY_VARIABLE)
    assert not list(files.write_outputs(run(), outputs))
    assert summary.read_text() == text
