"""The page's templates, and a cache of them: compiling them all takes 0.3 s of the processor.

Jinja caches compiled templates in the user's own folder below the system's for temporary files, and
uses one only for the very same text. What else its code depends on, functions of this room, is in
the files' names. Without such a folder, or room in it, nothing is cached.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import pickle
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import (
    Environment,
    FileSystemBytecodeCache,
    PackageLoader,
    StrictUndefined,
)
from jinja2.bccache import Bucket
from markupsafe import Markup

from shaderlab.model import pictures
from shaderlab.report import inline, markup, search, text
from shaderlab.report.grouping import STATUS_WORDS, STATUSES


@cache
def environment() -> Environment:
    """The environment of the templates, each of which is compiled when it is first used."""
    made = Environment(
        bytecode_cache=_cache(),
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
        inline.numbers,
        search.words,
    ):
        made.filters[function.__name__] = function
    made.globals.update(
        statuses=STATUSES,
        words=STATUS_WORDS,
        colours={
            "low": _css(pictures.BAND_LOW),
            "middle": _css(pictures.BAND_MIDDLE),
            "high": _css(pictures.BAND_HIGH),
            "outside": [_css(colour) for colour in pictures.OUTSIDE],
            "uncovered": _css(pictures.UNCOVERED),
        },
        script_colours=_script_colours,
        fixed=_fixed,
    )
    # An attribute is one, and an error where there is none: Jinja would look for an item, too.
    made.getattr = getattr  # type: ignore[method-assign, assignment]
    return made


@cache
def _fixed(name: str) -> Markup:
    """A template that is the same wherever it stands."""
    return Markup(environment().get_template(name).render())


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
        "palette": pictures.VIRIDIS,
        "low": pictures.BAND_LOW,
        "middle": pictures.BAND_MIDDLE,
        "high": pictures.BAND_HIGH,
        "outside": pictures.OUTSIDE,
        "uncovered": pictures.UNCOVERED,
        "broken": pictures.NOT_FINITE,
    }
    return json.dumps(named, separators=(",", ":"))


class _TolerantCache(FileSystemBytecodeCache):
    """A cache whose files may be damaged or missing, and in a full file system."""

    def load_bytecode(self, bucket: Bucket) -> None:
        try:
            super().load_bytecode(bucket)
        except (OSError, EOFError, ValueError, pickle.UnpicklingError):
            bucket.reset()

    def dump_bytecode(self, bucket: Bucket) -> None:
        with contextlib.suppress(OSError):
            super().dump_bytecode(bucket)


def _cache() -> _TolerantCache | None:
    try:
        return _TolerantCache(pattern=f"shaderlab-{_fingerprint()}-%s")
    except (OSError, RuntimeError):
        return None


def _fingerprint() -> str:
    """Changes with each module of this room: with its time and size, as in Python's own cache."""
    found = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        known = path.stat()
        found.update(
            f"{path}|{known.st_mtime_ns}|{known.st_size}\n".encode(errors="surrogateescape")
        )
    return found.hexdigest()[:16]
