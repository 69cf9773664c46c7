"""Numbers and names as people read them, and strings made fit for a page."""

from __future__ import annotations

import math
import re
from datetime import datetime

from shaderlab.model.records import significant

# C0 and C1 controls (but tab and line ends), lone surrogates, and XML's two non-characters.
_UNPRINTABLE = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")
# Characters that reorder or hide what is around them, so that code reads as it does not run.
_HIDING = re.compile(r"[\u200b\u200e\u200f\u202a-\u202e\u2060-\u2069\ufeff]")


def clean(text: object) -> str:
    """`text` without what XML and HTML can't hold, and with hidden characters made visible.

    >>> clean("a\\x1bb\\u202ec")
    'a\ufffdb[U+202E]c'
    """
    if type(text) is str and text.isprintable():
        return text  # as most texts are; what has to be replaced is not printable
    shown = _UNPRINTABLE.sub("\ufffd", str(text).replace("\r\n", "\n").replace("\r", "\n"))
    return _HIDING.sub(lambda match: f"[U+{ord(match.group()):04X}]", shown)


def figure(value: float) -> str:
    """A float in at most nine digits, enough to tell any two 32-bit floats apart."""
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    return significant(value).replace("-", "−")


def short(value: float) -> str:
    """A float in three digits, for distances and shares.

    >>> short(0.41234), short(1234.5), short(0.0)
    ('0.412', '1230', '0')
    """
    if not math.isfinite(value):
        return figure(value)
    size = abs(value)
    if value and (size < 1e-3 or size >= 1e6):
        return f"{value:.2e}".replace("-", "−")
    if size >= 100:
        return f"{float(f'{value:.3g}'):.0f}".replace("-", "−")
    return f"{value:.3g}".replace("-", "−")


def count(number: int) -> str:
    """An integer with thin spaces between thousands.

    >>> count(1234567)
    '1\u202f234\u202f567'
    """
    return f"{number:,}".replace(",", "\u202f")


def plural(number: int, one: str, many: str = "") -> str:
    """A number with its noun.

    >>> plural(1, "case"), plural(2, "case"), plural(2, "query", "queries")
    ('1 case', '2 cases', '2 queries')
    """
    return f"{count(number)} {one if number == 1 else many or one + 's'}"


def duration(seconds: float) -> str:
    """Seconds in the unit that reads best.

    >>> duration(0.0042), duration(3.14159), duration(125)
    ('4.2 ms', '3.1 s', '2 min 5 s')
    """
    if not math.isfinite(seconds):
        return figure(seconds)
    if seconds < 1:
        return f"{short(round(seconds * 1000, 1))} ms"
    if seconds < 60:
        return f"{seconds:.1f} s"
    return f"{int(seconds // 60)} min {int(seconds % 60)} s"


def share(fraction: float) -> str:
    """A share of 0…1 in percent; never 0 % or 100 % unless it is exactly that.

    >>> share(0.0), share(0.00001), share(0.5), share(0.99999)
    ('0 %', '<0.1 %', '50 %', '>99.9 %')
    """
    if not math.isfinite(fraction):
        return figure(fraction)
    if 0 < fraction < 0.001:
        return "<0.1 %"
    if 0.999 < fraction < 1:
        return ">99.9 %"
    return f"{fraction * 100:.3g} %"


def day(started: str) -> str:
    """An ISO date and time as "21 November 2026, 10:33 UTC"; anything else as it is."""
    try:
        moment = datetime.fromisoformat(started)
    except ValueError:
        return started
    zone = f" {moment.tzname()}" if moment.tzinfo else ""
    return f"{moment.day} {moment:%B %Y, %H:%M}{zone}"


def slug(name: str) -> str:
    """`name` as part of an anchor: letters, digits and hyphens.

    >>> slug("d = 50 (notes)")
    'd-50-notes'
    """
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-") or "x"


class Anchors:
    """Hands out anchors, never one twice; `next_short` is the number of the next short one."""

    def __init__(self) -> None:
        self._taken: set[str] = set()
        self.next_short = 1

    def short(self) -> str:
        """A short anchor, for listings that repeat it in each line."""
        self.next_short += 1
        return self.new(f"s{self.next_short - 1}")

    def new(self, *parts: str) -> str:
        """An anchor that begins with the slugs of `parts`."""
        wanted = "-".join(slug(part) for part in parts)
        anchor, number = wanted, 2
        while anchor in self._taken:
            anchor, number = f"{wanted}-{number}", number + 1
        self._taken.add(anchor)
        return anchor
