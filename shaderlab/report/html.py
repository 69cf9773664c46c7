"""The report as one self-contained HTML file that asks nothing of any network."""

from __future__ import annotations

import base64
import hashlib
import importlib
import json
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shaderlab import pictures
from shaderlab.records import Run
from shaderlab.report import markup, mutants, text
from shaderlab.report.atomic import write_text
from shaderlab.report.build import build
from shaderlab.report.compare import compare
from shaderlab.report.drivers import driver_table
from shaderlab.report.grouping import STATUS_WORDS, STATUSES
from shaderlab.report.inline import Pictures

if TYPE_CHECKING:
    from jinja2 import Environment

FILE_NAME = "index.html"
AGAINST_NAME = "against.html"

# In this order; each is one file of the package's style folder.
_STYLES = (
    "base", "front", "overview", "case", "check", "inspector", "chart", "passes", "compare",
    "code", "print",
)  # fmt: skip
_SCRIPTS = (
    "numbers", "values", "paint", "view", "marks", "histogram", "readout", "pointer", "inspector",
    "inspect", "assembly", "curves", "copies", "blink", "filter", "open",
)  # fmt: skip


def write(run: Run, folder: str | Path, against: tuple[Run, Path] | None = None) -> Path:
    """Write `folder`/index.html from a run whose pictures lie in `folder`; return its path.

    With an earlier run and its folder in `against`, it is `folder`/against.html and begins with
    what changed.

    The page is one file: pictures, styles and scripts are in it, and its own security policy
    forbids everything else. A report that was there stays unless the new one was all written.

    What `shaderlab mutate --report` left in the folder is shown too.

    Raises:
        ShaderlabError: the file can't be written, or that is damaged. A picture that is missing
            is only noted.
    """
    target = Path(folder)
    page = build(run, Pictures(target), mutants.load(target))
    style = _together("style", _STYLES, "css")
    script = _together("script", _SCRIPTS, "js")
    compared = against and compare(run, target, *against, page.anchors)
    template = _environment().get_template("page.html.j2")
    pieces = template.stream(
        page=page,
        run=run,
        against=compared,
        drivers=driver_table(run, page.anchors),
        style=style,
        script=script,
        style_hash=_hash(style),
        script_hash=_hash(script),
    )
    path = target / (AGAINST_NAME if against else FILE_NAME)
    pieces.enable_buffering(256)
    write_text(path, pieces)
    return path


def load_libraries() -> None:
    """Import what pages are made with, a fifth of a second's work that can be done while workers
    draw; `write` does it otherwise."""
    for name in ("latex2mathml.converter", "markdown_it", "pygments.lexers", "pygments.formatters"):
        importlib.import_module(name)
    _environment().get_template("page.html.j2")


def _together(folder: str, names: tuple[str, ...], suffix: str) -> str:
    root = files(__package__).joinpath(folder)
    parts = [root.joinpath(f"{name}.{suffix}").read_text(encoding="utf-8") for name in names]
    # Browsers hash what stands between the tags after line ends are normalised.
    return "\n".join(parts).replace("\r\n", "\n")


def _hash(source: str) -> str:
    digest = hashlib.sha256(source.encode("utf-8")).digest()
    return "sha256-" + base64.b64encode(digest).decode("ascii")


@cache
def _environment() -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader(__package__, "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_finalize,
        auto_reload=False,  # a stat of each template at each of its uses
        trim_blocks=True,
        lstrip_blocks=True,
    )
    for function in (
        text.count,
        text.day,
        text.duration,
        text.figure,
        text.plural,
        text.share,
        text.short,
        markup.code_spans,
    ):
        environment.filters[function.__name__] = function
    environment.globals.update(
        statuses=STATUSES,
        words=STATUS_WORDS,
        chart_size=_chart_size(),
        colours={
            "low": _css(pictures.BAND_LOW),
            "middle": _css(pictures.BAND_MIDDLE),
            "high": _css(pictures.BAND_HIGH),
            "outside": [_css(colour) for colour in pictures.OUTSIDE],
            "uncovered": _css(pictures.UNCOVERED),
        },
        script_colours=_script_colours,
    )
    return environment


def _finalize(value: Any) -> Any:
    """What every `{{ … }}` goes through before it is escaped."""
    if isinstance(value, str) and not hasattr(value, "__html__"):
        return text.clean(value)
    return value


def _css(colour: tuple[int, int, int]) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)


def _script_colours() -> str:
    """The colours that the inspector paints with, as JSON: the same as in the pictures' files."""
    named = {
        "palette": pictures.palette(),
        "low": pictures.BAND_LOW,
        "middle": pictures.BAND_MIDDLE,
        "high": pictures.BAND_HIGH,
        "outside": pictures.OUTSIDE,
        "uncovered": pictures.UNCOVERED,
        "broken": pictures.NOT_FINITE,
    }
    return json.dumps(named, separators=(",", ":"))


def _chart_size() -> dict[str, float]:
    from shaderlab.report import chart

    names = ("WIDTH", "HEIGHT", "LEFT", "RIGHT", "TOP", "BOTTOM", "STRIP_TOP", "STRIP_BOTTOM")
    size = {name.lower(): getattr(chart, name) for name in names}
    height = chart.STRIP_BOTTOM - chart.STRIP_TOP
    size["band_top"] = chart.STRIP_TOP + height * (chart.FURTHEST - 1) / (2 * chart.FURTHEST)
    size["band_height"] = height / chart.FURTHEST
    return size
