"""The page's templates, and what is kept of them: they take longer to compile than to fill in.

Jinja keeps compiled templates in a folder of the user's own below the system's for temporary files,
and takes one only for the very same text. What else its code depends on, functions of this room,
is in the files' names. Where there is no such folder, or no room in it, nothing is kept.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import pickle
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import (
    Environment,
    FileSystemBytecodeCache,
    PackageLoader,
    StrictUndefined,
    Template,
)
from jinja2.bccache import Bucket
from jinja2.runtime import Context

from shaderlab import pictures
from shaderlab.report import chart, markup, text
from shaderlab.report.grouping import STATUS_WORDS, STATUSES

# These grow with the cases, their variants or their checks, and are given out piece by piece.
_IN_PIECES = frozenset({"page", "overview", "compare", "chapter", "case", "judged", "variant"})


class _Part(Template):
    """A template that gives what it is filled with as one piece of text, where Jinja gives a piece
    for each word: every piece passes through all the templates around it."""

    @classmethod
    def from_code(cls, *args: Any, **more: Any) -> Template:
        made = super().from_code(*args, **more)
        if str(made.name).partition(".")[0] not in _IN_PIECES:
            made.root_render_func = _in_one_piece(made.root_render_func)
        return made


def _in_one_piece(pieces: Callable[[Context], Iterator[str]]) -> Callable[[Context], Iterator[str]]:
    def whole(context: Context) -> Iterator[str]:
        yield "".join(pieces(context))

    return whole


class _Environment(Environment):
    template_class = _Part


@cache
def environment() -> Environment:
    """The templates, each compiled when it is first asked for."""
    made = _Environment(
        bytecode_cache=_kept(),
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
        made.filters[function.__name__] = function
    made.globals.update(
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
    return made


def _finalize(value: Any) -> Any:
    """What every `{{ … }}` goes through before it is escaped; markup is clean already."""
    if type(value) is str or (isinstance(value, str) and not hasattr(value, "__html__")):
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
    names = ("WIDTH", "HEIGHT", "LEFT", "RIGHT", "TOP", "BOTTOM", "STRIP_TOP", "STRIP_BOTTOM")
    size = {name.lower(): getattr(chart, name) for name in names}
    height = chart.STRIP_BOTTOM - chart.STRIP_TOP
    size["band_top"] = chart.STRIP_TOP + height * (chart.FURTHEST - 1) / (2 * chart.FURTHEST)
    size["band_height"] = height / chart.FURTHEST
    return size


class _Kept(FileSystemBytecodeCache):
    """Compiled templates that may be damaged or missing, and that need not be kept."""

    def load_bytecode(self, bucket: Bucket) -> None:
        try:
            super().load_bytecode(bucket)
        except (OSError, EOFError, ValueError, pickle.UnpicklingError):
            bucket.reset()

    def dump_bytecode(self, bucket: Bucket) -> None:
        with contextlib.suppress(OSError):
            super().dump_bytecode(bucket)


def _kept() -> _Kept | None:
    try:
        return _Kept(pattern=f"shaderlab-{_fingerprint()}-%s")
    except (OSError, RuntimeError):
        return None


def _fingerprint() -> str:
    """Another one whenever a module of this room is: by time and size, as Python's own cache."""
    found = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        known = path.stat()
        found.update(f"{path}|{known.st_mtime_ns}|{known.st_size}\n".encode())
    return found.hexdigest()[:16]
