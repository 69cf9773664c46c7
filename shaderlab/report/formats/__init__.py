"""The formats in which a run can be written to one file besides the page.

Each is a module of this folder with a function `render(run) -> str`, and a line in FORMATS, from
which `shaderlab run` and `shaderlab report` get the option `--NAME FILE`. A module is imported
when it is used. Those of findings have a function `render_findings` too.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from shaderlab.model.records import Run
    from shaderlab.report.findings import Finding


class Format(NamedTuple):
    """One output format: the name of its module and its option, and the option's help."""

    name: str
    help: str

    def render(self, run: Run) -> str:
        """The run in this format."""
        text: str = importlib.import_module(f"{__name__}.{self.name}").render(run)
        return text

    def render_findings(self, findings: Iterable[Finding], command: str) -> str:
        """What a command found in this format, which is one of FINDING_FORMATS."""
        module = importlib.import_module(f"{__name__}.{self.name}")
        text: str = module.render_findings(findings, command)
        return text


FORMATS = (
    Format("json", "Write results as JSON; - for stdout."),
    Format("junit", "Write results as JUnit XML; - for stdout."),
    Format("markdown", "Write a summary in Markdown; - for stdout."),
    Format("sarif", "Write what is wrong, with file and line, as SARIF; - for stdout."),
    Format("annotations", "Write it as annotations of GitHub's reviews; - for stdout."),
)
FINDING_FORMATS = tuple(format for format in FORMATS if format.name in ("sarif", "annotations"))
"""Those that show findings, and nothing else of a run: commands without a run have them too."""
