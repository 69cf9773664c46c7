"""The report as one self-contained HTML file that asks nothing of any network."""

from __future__ import annotations

import base64
import hashlib
import importlib
import threading
from importlib.resources import files
from pathlib import Path

from shaderlab.files import write_text
from shaderlab.records import Run
from shaderlab.report import mutants
from shaderlab.report.build import build
from shaderlab.report.compare import compare
from shaderlab.report.drivers import driver_table
from shaderlab.report.inline import Pictures

FILE_NAME = "index.html"
AGAINST_NAME = "against.html"

# In this order; each is one file of the package's style folder.
_STYLES = (
    "base", "front", "way", "overview", "case", "check", "inspector", "chart", "passes", "compare",
    "code", "print",
)  # fmt: skip
_SCRIPTS = (
    "numbers", "values", "paint", "view", "marks", "histogram", "readout", "pointer", "inspector",
    "curves", "blink", "filter", "folds", "way",
)  # fmt: skip


def write(run: Run, folder: str | Path, against: tuple[Run, Path] | None = None) -> Path:
    """Write `folder`/index.html from a run whose pictures lie in `folder`; return its path.

    With an earlier run and its folder in `against`, it is `folder`/against.html and begins with
    what changed.

    The page is one file: pictures, styles and scripts are in it, and its own security policy
    forbids everything else. A report that was there stays unless the new one was all written.

    The results of `shaderlab mutate --report` in that folder are shown too.

    Raises:
        ShaderlabError: the file can't be written, or `mutation.json` is damaged. Missing pictures
            are only noted.
    """
    from shaderlab.report.environment import environment

    target = Path(folder)
    page = build(run, Pictures(target), mutants.load(target))
    style = _together("style", _STYLES, "css")
    script = _together("script", _SCRIPTS, "js")
    compared = against and compare(run, target, *against, page.anchors)
    pieces = (
        environment()
        .get_template("page.html.j2")
        .stream(
            page=page,
            run=run,
            against=compared,
            drivers=driver_table(run, page.anchors),
            style=style,
            script=script,
            style_hash=_hash(style),
            script_hash=_hash(script),
        )
    )
    path = target / (AGAINST_NAME if against else FILE_NAME)
    write_text(path, pieces)
    return path


def load_libraries() -> None:
    """Import the page's libraries and read its templates in a background thread.

    This takes a third of a second, during which workers can draw; `write` does it otherwise. A
    run that is interrupted does not wait for the thread.
    """
    # Not in the thread: two threads should not import modules that import each other.
    from shaderlab.report.environment import environment

    def load() -> None:
        importlib.import_module("cattrs")
        for name in environment().list_templates():
            environment().get_template(name)
        coloured_lines = importlib.import_module("shaderlab.report.colouring").coloured_lines
        for language in ("glsl", "python"):
            coloured_lines("\n", language)
        for name in ("OpenImageIO", "markdown_it", "latex2mathml.converter"):
            importlib.import_module(name)

    threading.Thread(target=load, daemon=True).start()


def _together(folder: str, names: tuple[str, ...], suffix: str) -> str:
    root = files(__package__).joinpath(folder)
    parts = [root.joinpath(f"{name}.{suffix}").read_text(encoding="utf-8") for name in names]
    # Browsers hash what stands between the tags after line ends are normalised.
    return "\n".join(parts).replace("\r\n", "\n")


def _hash(source: str) -> str:
    digest = hashlib.sha256(source.encode("utf-8")).digest()
    return "sha256-" + base64.b64encode(digest).decode("ascii")
