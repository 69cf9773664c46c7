"""The formats in which a run can be written to one file besides the page.

Each is a module of this folder with a function `render(run) -> str`, and a line in FORMATS, from
which `shaderlab run` and `shaderlab report` get the option `--NAME FILE`. A module is imported
when it is used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from shaderlab.records import Run


class Format(NamedTuple):
    """One output format: the name of its module and its option, and the option's help."""

    name: str
    help: str

    def render(self, run: Run) -> str:
        """The run in this format."""
        text: str = importlib.import_module(f"{__name__}.{self.name}").render(run)
        return text


FORMATS = (
    Format("json", "Write results as JSON; - for stdout."),
    Format("junit", "Write results as JUnit XML; - for stdout."),
    Format("markdown", "Write a summary in Markdown; - for stdout."),
)
