"""Saying in GLSL's terms what SPIRV-Tools says about a module."""

from __future__ import annotations

import re

from shaderlab.glsl.sources import Source
from shaderlab.records import Diagnostic

_OPAQUE_IN_STRUCT = "must not contain an opaque type"


def explain(message: str, source: Source) -> Diagnostic:
    """The validator's message as a diagnostic, at the declaration it is about if that is known."""
    text = " ".join(message.split())
    file, line, token = source.path, None, ""
    named = re.search(r"%(\w+) = OpTypeStruct", text)
    if _OPAQUE_IN_STRUCT in text and named:
        token = named.group(1)
        at = re.search(rf"\bstruct\s+{re.escape(token)}\b", source.code)
        if at:
            file, line = source.place(source.text.count("\n", 0, at.start()) + 1)
        text = (
            f"'{token}' : Vulkan has no samplers inside structs; declare the sampler as a uniform "
            f"of its own [{text}]"
        )
    return Diagnostic(
        file=file, line=line, severity="error", message=f"invalid SPIR-V: {text}", token=token
    )
