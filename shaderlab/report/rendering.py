"""What the pages of a report share: templates, style, scripts, and policies against all else.

A page's policy names the hashes of the scripts that stand in it. One of the site's loads what lies
beside it, and a browser lets only that one ('strict-dynamic').
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Iterator
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, FileSystemBytecodeCache, PackageLoader, StrictUndefined

from shaderlab.model import pictures
from shaderlab.report import sources, text
from shaderlab.report.charts import is_outside
from shaderlab.report.grouping import STATUS_WORDS, STATUSES
from shaderlab.report.pictures import in_base64

FOLDER = "page"
"""The folder of what the pages of a site share: style.css, script.js and search.js."""
# In this order; each is one file of the package's style and script folders.
_STYLES = ("page", "case", "code", "print")
_SCRIPTS = ("values", "painting", "inspector", "page")
_NOTHING_ELSE = "default-src 'none'; base-uri 'none'; form-action 'none'"
_FILTERS = (
    text.count, text.day, text.duration, text.figure, text.plural, text.share, text.short,
    sources.code_spans, sources.collect_words, sources.list_programs, sources.render_formula,
    sources.render_lesson, in_base64,
)  # fmt: skip


def render(template: str, **values: Any) -> Iterator[str]:
    return environment().get_template(template).generate(boot=BOOT, **values)


@cache
def environment() -> Environment:
    """Return the environment of the templates, each of which is compiled when it is first used."""
    made = Environment(
        bytecode_cache=_bytecode_cache(),
        loader=PackageLoader(__package__, "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_finalize,
        auto_reload=False,  # a stat of each template at each of its uses
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters.update({function.__name__: function for function in _FILTERS})
    made.globals.update(
        statuses=STATUSES,
        words=STATUS_WORDS,
        colours={
            "low": _css(pictures.BAND_LOW),
            "middle": _css(pictures.BAND_MIDDLE),
            "high": _css(pictures.BAND_HIGH),
            "outside": [_css(colour) for colour in pictures.OUTSIDE],
            "check": _css(pictures.CHECK),
            "uncovered": _css(pictures.UNCOVERED),
        },
        script_colours=_script_colours,
        is_outside=is_outside,
        zip=zip,
    )
    # An attribute is one, and an error where there is none: Jinja would look for an item, too.
    made.getattr = getattr  # type: ignore[method-assign, assignment]
    return made


def _bytecode_cache() -> FileSystemBytecodeCache | None:
    """Keep compiled templates in the user's own folder below the system's for temporary files:
    compiling them all takes 0.3 s. None where there can be no such folder."""
    try:
        return FileSystemBytecodeCache(pattern="shaderlab-%s")
    except (OSError, RuntimeError):
        return None


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
        "magnitudes": pictures.MAGNITUDES,
        "check": pictures.CHECK,
        "uncovered": pictures.UNCOVERED,
        "broken": pictures.NOT_FINITE,
    }
    return json.dumps(named, separators=(",", ":"))


@cache
def style() -> str:
    shades = (pictures.VIRIDIS[6 * round(255 / 7 * n) :][:6] for n in range(8))
    rules = (f".shade-{n} {{ --series: #{shade}; }}\n" for n, shade in enumerate(shades))
    return _join("style", _STYLES, "css") + "".join(rules)


@cache
def script() -> str:
    return '"use strict";\n{\n' + _join("script", _SCRIPTS, "js") + "\n}\n"


@cache
def live_script() -> str:
    """Return the script that a page loads when a live picture is asked for."""
    player = files("shaderlab").joinpath("drivers/webgl/player.js").read_text(encoding="utf-8")
    return f'"use strict";\n{{\n{player}{_join("script", ("live",), "js")}}}\n'


def single_policy() -> str:
    """Return the content security policy of a page that is one file."""
    return (
        f"{_NOTHING_ELSE}; img-src data:; style-src '{_hash(style())}'; "
        f"script-src '{_hash(script())}'"
    )


def _join(folder: str, names: tuple[str, ...], suffix: str) -> str:
    root = files(__package__).joinpath(folder)
    parts = [root.joinpath(f"{name}.{suffix}").read_text(encoding="utf-8") for name in names]
    # Browsers hash what stands between the tags after line ends are normalised.
    return "\n".join(parts).replace("\r\n", "\n")


def _hash(source: str) -> str:
    digest = hashlib.sha256(source.encode("utf-8")).digest()
    return "sha256-" + base64.b64encode(digest).decode("ascii")


BOOT = (
    'addEventListener("DOMContentLoaded", () => {'
    'const script = document.createElement("script");'
    "script.src = `${document.documentElement.dataset.root}page/script.js`;"
    "document.head.append(script);"
    "});"
)
"""The script in each page of a site, which loads the shared one."""
# Pages on disk are of the scheme file:, which 'self' does not stand for in every browser.
SITE_POLICY = (
    f"{_NOTHING_ELSE}; img-src 'self' file: data:; style-src 'self' file:; "
    f"script-src '{_hash(BOOT)}' 'strict-dynamic'"
)
