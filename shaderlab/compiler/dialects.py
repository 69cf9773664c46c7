"""Older dialects of GLSL in the words of newer ones, which can become SPIR-V."""

import re
from dataclasses import replace

from .shader_files import OWN, is_embedded, rename_words, strip_comments
from .sources import LineMap, Source

# GLSL 1.30 (§1.1) and GLSL ES 3.00 (§1.1) name what they replace.
CALLS = re.compile(r"\btexture(?:[123]D|Cube)((?:Proj)?(?:Lod|Grad)?)(?:EXT|ARB)?(?=\s*\()")
_STORAGE = re.compile(r"\b(?:attribute|varying)\b")
# No text of a version that has `gl_FragColor` alone; one under `#if` has both.
_DECLARED = re.compile(r"^[ \t]*(?:layout\s*\([^)]*\)\s*)?out\s[^;,(){}]*;", re.M)
_OUTPUT = re.compile(r"\bgl_Frag(?:Color|Data(?=\s*\[\s*(\d+)))")
_VERSION = re.compile(r"^[ \t]*#[ \t]*version\b[^\n]*", re.M)
_START = re.compile(r"^[ \t]*#[ \t]*(?:version|extension)\b[^\n]*$", re.M)
# Colours of one value, where later functions return the value.
_SHADOWS = {
    name: f"#define {name}(map, place) vec4({now}(map, place))"
    for name, now in {
        "shadow1D": "texture", "shadow2D": "texture", "shadow2DProj": "textureProj",
    }.items()
}  # fmt: skip
# Words of later versions, which older texts may give to what is theirs.
_TAKEN = re.compile(
    r"\b(?:float|int|bool|[bi]?vec[234]|mat[234]|sampler\w+)\s+(buffer|centroid|coherent|flat|layout"
    r"|noperspective|patch|precise|readonly|resource|restrict|sampler?|shared|smooth|subroutine"
    r"|texture|writeonly|a?(?:cos|sin|tan)h|bitCount|determinant|find[LM]SB|fma|frexp|inverse|isinf"
    r"|isnan|ldexp|modf|outerProduct|round(?:Even)?|texelFetch|texture(?:Lod|Proj|Size)|transpose"
    r"|trunc)\b(?!\s*\w)"
)


# The fixed-function pipeline's variables, by stage ("" for all) and declaration (GLSL 1.20, §7.3 to
# §7.6; GLSL 4.60, in the compatibility profile). Structures, as those of lights, are left out.
_FIXED = (
    ("vertex", "in vec4", "Vertex|Color|SecondaryColor|MultiTexCoord[0-7]"),
    ("vertex", "in vec3", "Normal"),
    ("vertex", "out vec4", "(?:Front|Back)(?:Secondary)?Color"),
    ("vertex", "out vec4[]", "TexCoord"),
    ("vertex", "out float", "FogFragCoord"),
    ("fragment", "in vec4", "(?:Secondary)?Color"),
    ("fragment", "in vec4[]", "TexCoord"),
    ("fragment", "in float", "FogFragCoord"),
    ("", "uniform mat4", "(?:ModelView|(?:ModelView)?Projection)Matrix(?:Inverse)?(?:Transpose)?"),
    ("", "uniform mat4[]", "TextureMatrix(?:Inverse)?(?:Transpose)?"),
    ("", "uniform mat3", "NormalMatrix"),
)
_TRANSFORM = re.compile(r"\bftransform\s*\(\s*\)")
_COORDINATES = 8  # so many textures have coordinates


def _declare_fixed(text: str, stage: str) -> tuple[list[str], str]:
    """Declarations of what a text uses of the fixed-function pipeline, and the text with names of
    the lab's for that."""
    rows = []
    text = _TRANSFORM.sub("(gl_ModelViewProjectionMatrix * gl_Vertex)", text)
    for where, kind, names in _FIXED if "gl_" in text else ():
        found = re.findall(rf"\bgl_({names})\b(?:\s*\[\s*(\w+))?", text)
        for name in sorted({each[0] for each in found}) if where in ("", stage) else ():
            own = [index for each, index in found if each == name]
            last = max(map(int, own)) if all(map(str.isdecimal, own)) else _COORDINATES
            size = f"[{min(last + 1, _COORDINATES)}]" if kind.endswith("[]") else ""
            if not re.search(rf"\b(?:in|out)\s+\w+\s+gl_{name}\b", text):
                rows.append(f"{kind.removesuffix('[]')} {OWN}gl_{name}{size};")
            text = re.sub(rf"\bgl_{name}\b", f"{OWN}gl_{name}", text)
    return rows, text


def keep_own_names(text: str) -> str:
    """The text with other names for what it declares by words of later versions."""
    return rename_words(text, {word: OWN + word for word in _TAKEN.findall(strip_comments(text))})


def find_own_names(text: str) -> dict[str, str]:
    """What `keep_own_names` renamed in a text that it wrote."""
    return {word: OWN + word for word in re.findall(rf"\b{OWN}(\w+)", text)}


def drop_version(source: Source) -> Source:
    return replace(source, text=_VERSION.sub("", source.text, count=1), stripped=None)


def raise_version(source: Source, head: str = "") -> Source:
    """Return the stage in the oldest version that has all its words and can become SPIR-V for
    OpenGL: GLSL 3.30 for 1.10 to 1.50, ES 3.10 for ES 1.00 and 3.00, the core profile for the
    compatibility profile. The stage itself if it can already. `head` is another `#version` line."""
    version, profile = source.version
    embedded, older_words = is_embedded(version, profile), profile == "compatibility"
    known = (100, 300) if embedded else (110, 120, 130, 140, 150)
    if version not in known and not older_words:
        return source
    head = head or ("#version 310 es" if embedded else f"#version {max(version, 330)}")
    if version in (140, 150, 300) and not older_words:  # no word is replaced
        text = _VERSION.sub(head, keep_own_names(source.text), count=1)
        return replace(source, text=text, stripped=None)
    # What extensions added is part of the newer version.
    text = _START.sub("", keep_own_names(source.text)).replace("gl_FragDepthEXT", "gl_FragDepth")
    last_stage = source.stage == "fragment"
    text = _STORAGE.sub(lambda m: "in" if last_stage or m[0] == "attribute" else "out", text)
    rows = [head, *(define for name, define in _SHADOWS.items() if name in text)]
    if last_stage and not _DECLARED.search(text) and (found := _OUTPUT.findall(text)):
        count = f"[{1 + int(max(found))}]" if any(found) else ""
        name = OWN + ("gl_FragData" if count else "gl_FragColor")
        rows.append(f"layout (location = 0) out mediump vec4 {name}{count};")
        text = _OUTPUT.sub(name, text)
    if not embedded:
        fixed, text = _declare_fixed(text, source.stage)
        rows += fixed
    lines = LineMap.of([(*source.place(1), 1)] * len(rows) + list(source.lines.spans))
    text = "\n".join([*rows, CALLS.sub(r"texture\1", text)])
    return replace(source, text=text, lines=lines, stripped=None)
