"""What the pages of a report share: style, scripts, and the policies that allow nothing else.

A page's policy names the hashes of the scripts that stand in it. One of the site's loads what lies
beside it, and a browser lets only that one ('strict-dynamic').
"""

from __future__ import annotations

import base64
import hashlib
from functools import cache
from importlib.resources import files

# In this order; each is one file of the package's style folder.
_STYLES = (
    "base", "front", "way", "overview", "case", "check", "inspector", "chart", "passes", "compare",
    "code", "print",
)  # fmt: skip
_SCRIPTS = (
    "numbers", "values", "paint", "view", "marks", "histogram", "readout", "pointer", "inspector",
    "curves", "blink", "filter", "folds", "way",
)  # fmt: skip
_NOTHING_ELSE = "default-src 'none'; base-uri 'none'; form-action 'none'"


FOLDER = "page"
"""The folder of what the pages of a site share: style.css, script.js and search.js."""


@cache
def style() -> str:
    """All style sheets as one."""
    return _together("style", _STYLES, "css")


@cache
def script() -> str:
    """All scripts as one, with names of its own."""
    return '"use strict";\n{\n' + _together("script", _SCRIPTS, "js") + "\n}\n"


def single_policy() -> str:
    """The content security policy of a page that is one file."""
    return (
        f"{_NOTHING_ELSE}; img-src data:; style-src '{_hash(style())}'; "
        f"script-src '{_hash(script())}'"
    )


def plain_policy() -> str:
    """The content security policy of a page of text in one file, without scripts."""
    return f"{_NOTHING_ELSE}; style-src '{_hash(style())}'"


def _together(folder: str, names: tuple[str, ...], suffix: str) -> str:
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
