"""GLSL that differs between targets: words for Vulkan that plain GLSL lacks, versions too old for
SPIR-V."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from shaderlab.compiler.diagnostics import VERSION
from shaderlab.compiler.engines import Engine
from shaderlab.compiler.sources import Source
from shaderlab.compiler.verdicts import Result, to_spirv
from shaderlab.model.records import Diagnostic

_LOOSE = re.compile(
    r"(?P<uniform>(?:\blayout\s*\([^)]*\)\s*)?\buniform)(?=\s+(?:(?:low|medium|high)p\s+)?(?P<type>\w+)"
    r"\s+\w+\s*(?:\[[^\]]*\]\s*)*[=,;])"
)
_OPAQUE = re.compile(r"[iu]?(?:sampler|image|texture|subpassInput)|atomic_uint")
_IDS = {"gl_VertexID": "gl_VertexIndex", "gl_InstanceID": "gl_InstanceIndex"}


def in_dialect(sources: Sequence[Source], target: str, plain: Result, engine: Engine) -> Result:
    """What a SPIR-V target says of stages that plain GLSL refuses: it may know more words.

    Args:
        sources: the stages.
        target: one with SPIR-V.
        plain: what plain GLSL says; it is the answer if the target refuses the same lines.
        engine: the compiler.
    """
    if plain.deadly:
        return plain
    if target == "vulkan":
        # Relaxed rules crash on some mistakes that Vulkan's own rules report.
        own = to_spirv([_by_own_rules(source) for source in sources], "vulkan-strict", engine)
        own = to_spirv(sources, target, engine) if own.ok else own
    else:
        own = to_spirv(sources, target, engine)
    return plain if _lines(own) == _lines(plain) else own


def _lines(result: Result) -> set[tuple[str | None, int | None]]:
    errors: list[Diagnostic] = [d for d in result.diagnostics if d.severity == "error"]
    return {(d.file, d.line) for d in errors}


def _by_own_rules(source: Source) -> Source:
    """The stage without what only relaxed rules allow: plain globals for uniforms outside blocks,
    Vulkan's names of the indices. No line moves."""

    def blank(match: re.Match[str]) -> str:
        if _OPAQUE.match(match["type"]):
            return match.group()
        return re.sub(r"\S", " ", match["uniform"])

    code = _LOOSE.sub(blank, source.code)
    for old, new in _IDS.items():
        code = re.sub(rf"\b{old}\b", new, code)
    return source if code == source.code else replace(source, text=code, stripped=code)


def with_interface(source: Source) -> Source:
    """The stage in the oldest version that has all its words and can become SPIR-V for OpenGL, from
    which its interface is read: GLSL 3.30 for 1.40 and 1.50, ES 3.10 for ES 3.00."""
    version, profile = source.version
    if (version, profile) == (300, "es"):
        newer = "310 es"
    elif version in (140, 150) and profile in ("", "core"):
        newer = "330"
    else:
        return source
    text = re.sub(f"({VERSION}[ \\t]+)[^\\n]*", rf"\g<1>{newer}", source.text, count=1, flags=re.M)
    return replace(source, text=text, stripped=None)
