"""What shaders of GLSL ES declare below highp, or leave at such a default."""

from __future__ import annotations

import re

from shaderlab.compiler.sources import Source
from shaderlab.files import display_path

_ES = re.compile(r"\s*#\s*version\s+(?:100|3[012]0\s+es)\b")
_DECLARED = re.compile(r"\b(?:mediump|lowp)\b")
_SAMPLER = re.compile(r"\buniform\s+(sampler2D|samplerCube)\s+(\w+)")


def below_highp(source: Source) -> str:
    """The first thing that a driver may read or compute at 16 bits or fewer, as a sentence that
    begins with its place; "" if there is none, as in all of desktop GLSL.

    What is said nowhere is lowp for a `sampler2D` and a `samplerCube` (GLSL ES 3.00, §4.5.4).
    """
    code = source.code
    if not _ES.match(code):
        return ""
    found, what = _DECLARED.search(code), ""
    if found is not None:
        what = f"{found[0]} is declared"
    else:
        for sampler in _SAMPLER.finditer(code):
            if not re.search(rf"\bprecision\s+highp\s+{sampler[1]}\b", code):
                found, what = sampler, f"{sampler[2]} is lowp, as no precision is declared"
                break
    if found is None:
        return ""
    file, line = source.lines[code.count("\n", 0, found.start())]
    return (
        f"{display_path(file, line)}: {what}, which drivers may take to 16 bits; bands are those "
        "of highp"
    )
