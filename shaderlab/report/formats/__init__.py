"""The formats in which a run can be written to one file besides the page.

Each is a module of this folder with a function `render(run) -> str`, and a line in FORMATS, from
which `shaderlab run` and `report` get the option `--NAME FILE`. It is imported when used.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from shaderlab.model.records import Run
    from shaderlab.report.findings import Finding


class Format(NamedTuple):
    """One output format.

    Attributes:
        name: of its module and its option.
        findings: whether the module has `render_findings` too: then commands that make no run,
            such as `compile`, have the option as well.
    """

    name: str
    help: str
    findings: bool = False

    def render(self, run: Run) -> str:
        text: str = importlib.import_module(f"{__name__}.{self.name}").render(run)
        return text

    def render_findings(self, findings: Iterable[Finding], command: str) -> str:
        """Return what a command found in this format, which is one of FINDING_FORMATS."""
        module = importlib.import_module(f"{__name__}.{self.name}")
        text: str = module.render_findings(findings, command)
        return text


FORMATS = (
    Format("json", "Write results as JSON; - for stdout."),
    Format("junit", "Write results as JUnit XML; - for stdout."),
    Format("lcov", "Write which lines of fragment shaders ran as LCOV, for coverage services."),
    Format("markdown", "Write a summary in Markdown; - for stdout."),
    Format("sarif", "Write failures with file and line as SARIF; - for stdout.", findings=True),
)
FINDING_FORMATS = tuple(format for format in FORMATS if format.findings)
