"""Shader files: their text, their stage, and where they are: by name inside the shader folders, or
below paths that a user names."""

import codecs
import contextlib
import functools
import itertools
import os
import posixpath
import re
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from shaderlab.errors import ShaderError, UsageError, suggest
from shaderlab.files import open_regular

STAGES = ("vertex", "tess_control", "tess_evaluation", "geometry", "fragment", "compute")

EXTENSIONS: Mapping[str, str] = {
    ".vert": "vertex", ".vs": "vertex", ".tesc": "tess_control", ".tcs": "tess_control",
    ".tese": "tess_evaluation", ".tes": "tess_evaluation", ".geom": "geometry", ".gs": "geometry",
    ".frag": "fragment", ".fs": "fragment", ".comp": "compute", ".cs": "compute",
    ".vsh": "vertex", ".gsh": "geometry", ".fsh": "fragment", ".csh": "compute",
}  # fmt: skip
_PRAGMA = re.compile(r"^[ \t]*#[ \t]*pragma[ \t]+shader_stage[ \t]*\([ \t]*(\w*)[ \t]*\)", re.M)
# Words that one stage alone has, or the vertex stage and one of those before it here.
_TELLING = {
    "geometry": re.compile(r"\bEmitVertex\b"),
    "tess_control": re.compile(r"\bgl_InvocationID\b"),
    "tess_evaluation": re.compile(r"\bgl_TessCoord\b"),
    "vertex": re.compile(r"\bgl_(?:Position|Vertex\w*|Normal|MultiTexCoord0)\b|\battribute\b"),
    "fragment": re.compile(r"\bgl_Frag(?:Color|Data|Coord|Depth)\b|\bdiscard\s*;"),
    "compute": re.compile(r"\bgl_GlobalInvocationID\b|\blocal_size_x\b"),
}
_PRAGMA_NAMES = {"tesscontrol": "tess_control", "tesseval": "tess_evaluation", "pixel": "fragment"}
SECTION = re.compile(
    r"^[ \t]*#(?:[ \t]*(?:pragma[ \t]+stage|type|shader)[ \t]+|\[)(\w+)\]?[ \t]*$", re.M
)
"""Where a stage begins in a file of several, as RetroArch, Hazel and Godot write it."""
_SETTINGS = ("modes", "specializations", "versions")  # sections of Godot's that are no stages

# A quoted include path may hold "//"; everything else that looks like a comment is one. Without
# groups the search skips to the next quote or slash, which is several times as fast.
_COMMENT = re.compile(r'"[^"\n]*"|//(?:\\\n|[^\n])*|/\*.*?(?:\*/|\Z)', re.DOTALL)
_INCLUDED = re.compile(r'^[ \t]*#[ \t]*include[ \t]*["<]([^">\n]+)', re.M)
_VERSION = re.compile(r"#[ \t]*version[ \t]+(\d+)[ \t]*(\w*)")
MAX_BYTES = 4 << 20
"""The largest file accepted as a shader."""


def read_shader(path: str | Path) -> str:
    """Return the file's text with "\\n" line ends and no byte order mark. Raises ShaderError: no
    such file, no regular file, unreadable, too large, empty, or not UTF-8."""
    try:
        with open(open_regular(path), "rb") as file:
            # Read by its size, since a buffer of the limit would be allocated for every file.
            size = os.fstat(file.fileno()).st_size
            data = file.read() if size <= MAX_BYTES else file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise ShaderError("no such shader file", file=path) from None
    except OSError as error:
        if os.path.isdir(path):
            raise ShaderError(
                "is a directory, not a shader", file=path, remedy="name a file in it"
            ) from None
        reason = error.strerror or str(error)
        raise ShaderError(f"can't read the shader: {reason}", file=path) from error
    refuse_other_languages(path)
    if len(data) > MAX_BYTES:
        raise ShaderError(
            f"is larger than {MAX_BYTES >> 20} MiB, which no shader is",
            file=path,
            remedy="see whether this is a shader at all",
        )
    text = decode(data, path)
    if str(path).endswith(SCRIPT):
        parts = text.split("`")
        parts[::2] = ("\n" * outside.count("\n") for outside in parts[::2])
        text = "".join(parts)
    refuse_other_languages(path, text)
    return normalise(text, path)


SCRIPT = ".glsl.js"
"""What files are called that hold GLSL in a script's template strings, as those of three.js."""
_LANGUAGES = {
    ".hlsl": "HLSL", ".hlsli": "HLSL", ".fx": "HLSL", ".usf": "HLSL", ".cg": "Cg", ".wgsl": "WGSL",
    ".metal": "the Metal Shading Language", ".slang": "Slang", ".spvasm": "SPIR-V assembly",
    ".gdshader": "Godot's language", ".shader": "Unity's ShaderLab", ".cginc": "HLSL",
    ".fxh": "HLSL", ".ush": "HLSL", ".sc": "bgfx's dialect",
    **dict.fromkeys((".mesh", ".task"), "of a mesh stage"),
    **dict.fromkeys((".rgen", ".rint", ".rahit", ".rchit", ".rmiss"), "of a ray-tracing stage"),
}  # fmt: skip
_AS_MODULE = "audit, diff and explain take it as SPIR-V of its own compiler"
_REWRITE = "write what is its own in plain GLSL"
# What no GLSL holds outside of comments: a word, where it stands, the language, and what to do.
_FOREIGN = (
    ("shader_type", r"^[ \t]*shader_type[ \t]+\w+[ \t]*;", "Godot's language", _REWRITE),
    ("PROGRAM", r"^[ \t]*(?:CG|HLSL|GLSL)PROGRAM\b", "Unity's ShaderLab", _AS_MODULE),
    ("$input", r"^\$input[ \t]", "bgfx's dialect", _AS_MODULE),
    ("metal;", r"\busing namespace metal;", "the Metal Shading Language", _AS_MODULE),
    ("@", r"^[ \t]*@(?:vertex|fragment|compute)\b", "WGSL", f"call it .wgsl: {_AS_MODULE}"),
    ("SV_", r":[ \t]*SV_[A-Z]", "HLSL", f"call it .hlsl: {_AS_MODULE}"),
    ("cbuffer", r"^[ \t]*cbuffer[ \t]+\w+\s*[:{]", "HLSL", f"call it .hlsl: {_AS_MODULE}"),
    ("Image ", r"\bvec4 effect[ \t]*\([^)]*\bImage ", "LÖVE's dialect", _REWRITE),
    ('"INPUTS"', r"\A\s*/\*\s*\{", "of the Interactive Shader Format", _REWRITE),
)


def refuse_other_languages(path: str | Path, text: str = "") -> None:
    """Raise ShaderError for a file whose name, or whose text, says that it is not written in GLSL;
    one with a `#version` is."""
    suffix = os.path.splitext(path)[1].lower()
    if suffix == ".spv":
        raise ShaderError("is a SPIR-V module, which audit, diff and explain read", file=path)
    language, remedy = None if holds_glsl(path) else _LANGUAGES.get(suffix), _AS_MODULE
    for word, place, foreign, what_to_do in _FOREIGN:
        if word in text and not language:
            code = text if place.startswith(r"\A") else strip_comments(text)
            if re.search(place, code, re.MULTILINE) and not version_of(code):
                language, remedy = foreign, what_to_do
    if language:
        said = f"is {language}; the lab reads GLSL and SPIR-V"
        raise ShaderError(said, file=path, remedy=remedy)


def holds_glsl(path: str | Path) -> bool:
    """Whether a file's name says Slang and its text GLSL, as RetroArch's: it has a `#version`."""
    if not str(path).endswith(".slang"):
        return False
    try:
        with open(open_regular(path), "rb") as file:
            data = file.read(MAX_BYTES)
    except OSError:
        return False
    return re.search(rb"^(?:\xef\xbb\xbf)?[ \t]*#[ \t]*version[ \t]", data, re.M) is not None


def decode(data: bytes, path: str | Path) -> str:
    """UTF-8 bytes as text, without a byte order mark. Raises ShaderError: the bytes are not UTF-8;
    the message names the first bad byte's offset."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        offset = error.start
        wide = data[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
        raise ShaderError(
            f"is not UTF-8: byte {offset} is 0x{data[offset]:02x}"
            + (" (it looks like UTF-16)" if wide else ""),
            file=path,
            line=None if wide else data.count(b"\n", 0, offset) + 1,
            remedy="save the file as UTF-8",
        ) from None


def normalise(text: str, path: str | Path) -> str:
    """Text with "\\n" line ends. Raises ShaderError: the text is empty or holds a NUL character, at
    which compilers stop reading."""
    text = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    if not text.strip():
        raise ShaderError("the shader is empty", file=path)
    nul = text.find("\0")
    if nul >= 0:
        raise ShaderError(
            "holds a NUL character, at which compilers stop reading",
            file=path,
            line=text.count("\n", 0, nul) + 1,
            remedy="delete it",
        )
    return text


def strip_comments(text: str) -> str:
    """Return the text with its comments blanked out; all other characters stay in place."""
    if "//" not in text and "/*" not in text:
        return text
    return _COMMENT.sub(_blank, text)


def _blank(match: re.Match[str]) -> str:
    comment = match.group()
    if comment[0] == '"':
        return comment
    return "\n".join(" " * len(row) for row in comment.split("\n"))


def version_of(code: str) -> tuple[int, str] | None:
    """Return the `#version` of comment-free text as (330, "core"), or None if it has none."""
    for match in _VERSION.finditer(code):
        if not code[code.rfind("\n", 0, match.start()) + 1 : match.start()].strip():
            return int(match.group(1)), match.group(2)
    return None


def stage_of(name: str, text: str, path: str | None = None) -> str:
    """Return the stage that a file's extension or its `#pragma shader_stage(…)` names. Raises
    ShaderError: there is neither, or the pragma names no stage."""
    stem, suffix = posixpath.splitext(name)
    if suffix == ".glsl":
        suffix = posixpath.splitext(stem)[1]
    if suffix in EXTENSIONS:
        return EXTENSIONS[suffix]
    if sections := find_sections([text]):
        return "fragment" if "fragment" in sections else sections[0]
    code = strip_comments(text)
    pragma = _PRAGMA.search(code)
    if pragma is None and _is_shadertoy(code):
        return "fragment"
    telling = [stage for stage, word in _TELLING.items() if word.search(code)]
    between = telling and telling[0] not in ("vertex", "fragment", "compute")
    if pragma is None and (between or len(telling) == 1):
        return telling[0]
    if pragma is None and not telling and MAIN.search(code) and _STAGE_VARIABLE.search(code):
        return "fragment"  # all others write gl_Position
    if pragma is None:
        raise ShaderError(
            "can't tell the shader's stage from its name",
            file=path or name,
            remedy=f"name it with {' '.join(EXTENSIONS)}, or add #pragma shader_stage(fragment)",
        )
    word = pragma.group(1)
    stage = _PRAGMA_NAMES.get(word, word)
    if stage not in STAGES:
        line = text.count("\n", 0, pragma.start()) + 1
        said, remedy = f"#pragma shader_stage({word}) names no stage", suggest(word, STAGES)
        raise ShaderError(said, file=path or name, line=line, remedy=remedy)
    return stage


def section_of(row: str) -> str:
    """Return the stage that begins at a row of comment-free text, in a file of several; else ""."""
    found = SECTION.fullmatch(row)
    return _PRAGMA_NAMES.get(found[1], found[1]) if found else ""


def find_sections(texts: Iterable[str]) -> list[str]:
    """Return the stages that begin in these texts, each once."""
    marked = (strip_comments(text) for text in texts if SECTION.search(text))
    found = (section_of(each[0]) for code in marked for each in SECTION.finditer(code))
    return [stage for stage in dict.fromkeys(found) if stage not in _SETTINGS]


_MAIN_IMAGE, MAIN = (re.compile(rf"\bvoid\s+{name}\s*\(") for name in ("mainImage", "main"))
_DESKTOP = re.compile(
    r"\bgl_(?!Position\b|PointSize\b|DepthRange\b|Max)|\bftransform\b|\btexture[13]D|\bmat\dx"
)
_PRECISION = re.compile(r"\bprecision\s+(?:low|medium|high)p\s+\w+\s*;")
SHADERTOY_INPUTS: Mapping[str, tuple[str, tuple[int, ...]]] = {
    "iResolution": ("vec3", ()), "iTime": ("float", ()), "iTimeDelta": ("float", ()),
    "iFrameRate": ("float", ()), "iFrame": ("int", ()), "iChannelTime": ("float", (4,)),
    "iChannelResolution": ("vec3", (4,)), "iMouse": ("vec4", ()), "iDate": ("vec4", ()),
    "iSampleRate": ("float", ()), **{f"iChannel{n}": ("sampler2D", ()) for n in range(4)},
}  # fmt: skip
"""Type and array size of each uniform that shadertoy.com declares ("How To", Shader Inputs)."""
_VIEWER_INPUTS = (
    "int frame; float time delta cameraNearClip cameraFarClip cameraDistance lightIntensity;"
    "vec2 resolution mouse; vec3 camera light lightColor SH; vec4 date; mat3 normalMatrix;"
    "mat4 modelMatrix viewMatrix inverseViewMatrix projectionMatrix inverseProjectionMatrix "
    "modelViewProjectionMatrix lightMatrix; samplerCube cubeMap; sampler2D scene sceneDepth "
    "lightShadowMap tex0 tex1 tex2 tex3 tex4 tex5 tex6 tex7 tex8 tex9 buffer0 buffer1 buffer2 "
    "buffer3 doubleBuffer0 doubleBuffer1 doubleBuffer2 doubleBuffer3"
)
_THREE_UNIFORMS = {
    "modelMatrix": "mat4", "modelViewMatrix": "mat4", "projectionMatrix": "mat4",
    "viewMatrix": "mat4", "normalMatrix": "mat3", "cameraPosition": "vec3",
}  # fmt: skip
HOST_INPUTS: Mapping[str, tuple[str, tuple[int, ...]]] = {
    f"u_{word}": (kind, (9,) if word == "SH" else ())
    for kind, *words in map(str.split, _VIEWER_INPUTS.split(";"))
    for word in words
} | {**SHADERTOY_INPUTS, **{name: (kind, ()) for name, kind in _THREE_UNIFORMS.items()}}
"""Those, three.js's, and the ones of glslViewer (its wiki, "GlslViewer UNIFORMS", and "Native
Uniforms" of glsl-pipeline), three of which The Book of Shaders has."""

_FIXED = re.compile(r"\bgl_(?:Vertex|Normal|Color|ModelView|TexCoord|MultiTex)|\bftransform\b")
_THREE_ATTRIBUTES = {"position": "vec3", "normal": "vec3", "uv": "vec2"}
# An input or output that stands by itself, and is no parameter.
_STAGE_VARIABLE = re.compile(
    r"^[ \t]*(?:layout\s*\([^)]*\)\s*)?(?:flat\s+)?(?:in|out)\s[^;(){}]*;", re.M
)


def frame_text(code: str, stage: str) -> tuple[Sequence[str], Sequence[str]]:
    """Return the rows to put before and after a shader without `#version`. A Shadertoy image gets
    its inputs and a `main`, a shader of three.js what that declares. Text that states default
    precisions is of WebGL, and so is a vertex stage of attributes, which needs none: GLSL ES 1.00,
    which has no other version, or 3.00 where inputs and outputs are `in` and `out`. With those, all
    else is GLSL 3.30, without them 1.10, as the specification has it."""
    if stage == "fragment" and _is_shadertoy(code):
        inputs = [
            f"uniform {kind} {name}{''.join(map('[{}]'.format, sizes))};"
            for name, (kind, sizes) in SHADERTOY_INPUTS.items()
            if _is_undeclared(name, code)
        ]
        output = "layout (location = 0) out vec4 shadertoy_color;"
        main = "void main() { mainImage(shadertoy_color, gl_FragCoord.xy); }"
        return ["#version 330 core", *inputs], [output, main]
    modern = MAIN.search(code) is not None and _STAGE_VARIABLE.search(code) is not None
    rows = _declare_as_three(code, stage, "in" if modern else "attribute")
    plain = stage == "vertex" and "attribute" in code and not _DESKTOP.search(code)
    embedded = rows or plain or _PRECISION.search(code)
    if modern:
        return ["#version 300 es" if embedded else "#version 330 core", *rows], []
    return ["#version 100", *rows] if embedded else [], []


def _declare_as_three(code: str, stage: str, attribute: str) -> list[str]:
    """What three.js puts before a shader that uses, undeclared, what it declares in those of a
    ShaderMaterial (its manual, "WebGLProgram": Built-in uniforms and attributes)."""
    uniforms = [name for name in _THREE_UNIFORMS if _is_undeclared(name, code)]
    stages = ("vertex", "fragment")
    if not uniforms or stage not in stages or not MAIN.search(code) or _FIXED.search(code):
        return []
    rows = [f"uniform {_THREE_UNIFORMS[name]} {name};" for name in uniforms]
    for name, kind in _THREE_ATTRIBUTES.items():
        if stage == "vertex" and _is_undeclared(name, code):
            rows.append(f"{attribute} {kind} {name};")
    return ["precision highp float;", *rows]


def _is_undeclared(name: str, code: str) -> bool:
    """Whether a name is used, and no macro, uniform, attribute, input, vector or matrix has it."""
    declared = (
        rf"#[ \t]*define[ \t]+{name}\b|(?:vec|mat)\d\s+{name}\b"
        rf"|\b(?:uniform|attribute|in|varying)\s[^;(){{}}]*\b{name}\b"
    )
    return bool(re.search(rf"\b{name}\b", code)) and not re.search(declared, code)


def _is_shadertoy(code: str) -> bool:
    return _MAIN_IMAGE.search(code) is not None and MAIN.search(code) is None


def is_embedded(version: int, profile: str) -> bool:
    """Whether a `#version` is one of GLSL ES."""
    return profile == "es" or version == 100


_SHADER_SUFFIXES = frozenset(
    {*EXTENSIONS, ".glsl", ".inc", ".h", ".spv", ".spvasm", ".hlsl", ".slang", ".wgsl"}
)
_NO_SHADERS = frozenset({"__pycache__", "node_modules", "site-packages"})
MOST_FILES = 20_000
"""How many files below a shader folder are searched for names like a misspelt one."""
_LEADS_OUT = "leads out of the shader folders"
OUTSIDE_REMEDY = "name a file inside a shader folder, or add its folder: --include DIR"


@dataclass(frozen=True)
class File:
    """A shader file: its name inside the roots, where it is on disk, and its text."""

    name: str
    path: str
    text: str


class OutsideError(ValueError):
    """A name that leads out of the shader roots; the message says how."""


class Roots:
    """Shader `folders` in search order, with other texts or files for some names."""

    def __init__(
        self,
        folders: Sequence[Path],
        overrides: Mapping[str, str | Path],
        renames: Mapping[str, str] | None = None,
    ) -> None:
        self.folders = tuple(Path(folder) for folder in folders)
        self._renames = dict(renames or {})
        self._overrides = dict(overrides)

    def shader(self, name: str) -> File:
        """Read a shader. Raises ShaderError: it is in no root, leads out, or can't be read."""
        try:
            file = self.find(normalise_name(name))
        except OutsideError as error:
            raise ShaderError(f"shader {name!r}: {error}", remedy=OUTSIDE_REMEDY) from None
        if file is None:
            where = ", ".join(str(folder) for folder in self.folders) or "no folder"
            raise ShaderError(
                f"no shader {name!r} in {where}", file=name, remedy=self.suggest(name)
            )
        return file

    def has(self, name: str) -> bool:
        try:
            return self.find(normalise_name(name)) is not None
        except (OutsideError, ShaderError):
            return False

    def find(self, name: str) -> File | None:
        """Find the file of a normalised name; None if it is in no root.

        A name that climbs, such as "../shaders/a.glsl", is looked for beside each root, and found
        where that is in a root again; the file then has its name inside that one. Raises
        OutsideError: the name or a symbolic link leads out of the roots; ShaderError: the file
        can't be read."""
        if name in self._overrides:
            return self._read_override(name, name)
        for path, known in self._places(name):
            if os.path.lexists(path):
                real = os.path.realpath(path)
                if not real.startswith(self._real_folders):
                    raise OutsideError(
                        f"a symbolic link leads out of the shader folders, to {real}"
                    )
                if self._overrides and real in self._overridden_files:
                    return self._read_override(self._overridden_files[real], known)
                return File(known, path, read_shader(path))
        return None

    def suggest(self, name: str) -> str:
        """Return a remedy for a misspelt name: like ones of shaders that are not too deep in the
        roots, of which one may be somebody's home folder."""
        return suggest(name, self.names(MOST_FILES))

    def names(self, most: int | None = None) -> tuple[str, ...]:
        """Return all overridden names and all shader files below the roots, each by its shortest
        name, as `load` and `#include` take them; those of the first root first. At most `most`
        files of any kind are looked at below a root, the least deep first."""
        found: dict[str, str] = {}
        for folder in self.folders:
            for file in map(Path, itertools.islice(_walk(str(folder)), most)):
                if is_shader(file.name) and file.is_file():
                    path, name = _resolve_folder(str(file)), file.relative_to(folder).as_posix()
                    found[path] = min(found.get(path, name), name, key=len)
        return tuple(dict.fromkeys([*self._overrides, *found.values()]))

    def _read_override(self, key: str, name: str) -> File:
        new = self._overrides[key]
        if isinstance(new, Path):
            return File(name, str(new), rename_words(read_shader(new), self._renames))
        return File(name, name, normalise(new, name))

    @functools.cached_property
    def _overridden_files(self) -> dict[str, str]:
        """The overridden names by the files that they stand for: one file has several names where
        one root is inside another."""
        found: dict[str, str] = {}
        for key in self._overrides:
            path = next((path for path, _ in self._places(key) if os.path.lexists(path)), None)
            if path is not None:
                found.setdefault(os.path.realpath(path), key)
        return found

    def _places(self, name: str) -> list[tuple[str, str]]:
        """Return where a normalised name may be, in search order: paths, and names inside roots."""
        if not name.startswith("../"):
            return [(str(folder / name), name) for folder in self.folders]
        roots = [os.path.join(os.path.abspath(folder), "") for folder in self.folders]
        places = []
        for folder in self.folders:
            path = os.path.normpath(folder / name)
            root = next((root for root in roots if os.path.abspath(path).startswith(root)), None)
            if root is not None:
                places.append((path, os.path.abspath(path)[len(root) :]))
        if not places:
            raise OutsideError(_LEADS_OUT)
        return places

    @functools.cached_property
    def _real_folders(self) -> tuple[str, ...]:
        """The folders without symbolic links, each with a separator at its end."""
        return tuple(os.path.join(os.path.realpath(folder), "") for folder in self.folders)


def _resolve_folder(path: str) -> str:
    """Return a file's path without symbolic links in its folder."""
    parent, name = os.path.split(path)
    return os.path.join(os.path.realpath(parent), name)


OWN = "shaderlab_own_"
"""What an author's name begins with where a later version took it."""


def rename_words(text: str, renames: Mapping[str, str]) -> str:
    """Change some of the names in a shader's text.

    >>> rename_words("in vec3 vNormal; // vNormals", {"vNormal": "Normal"})
    'in vec3 Normal; // vNormals'
    """
    if not renames:
        return text
    words = "|".join(map(re.escape, renames))
    return re.sub(rf"\b(?:{words})\b", lambda match: renames[match.group()], text)


def normalise_name(name: str, folder: str = "") -> str:
    """`name`, seen from `folder` (itself a name inside the roots), normalised. Raises OutsideError:
    it is absolute, has backslashes or a drive, or names a folder."""
    if "\\" in name:
        raise OutsideError("has a backslash; write / between folders")
    if name.startswith("/") or re.match(r"[A-Za-z]:", name):
        raise OutsideError("is an absolute path; only files inside the shader folders are read")
    joined = posixpath.normpath(posixpath.join(folder, name)) if name else "."
    if joined in (".", ".."):
        raise OutsideError(_LEADS_OUT if name else "is empty; name a shader file")
    return joined


def is_shader(name: str) -> bool:
    """Return whether a file's name is a shader's, or an included one's."""
    return os.path.splitext(name)[1] in _SHADER_SUFFIXES


@dataclass(frozen=True)
class ShaderFile:
    """A shader file to compile: its path as the user would write it, its root, its name in it."""

    path: str
    root: str
    name: str


def find_shaders(
    paths: Sequence[str | Path], roots: Sequence[Path] = (), *, stage: str | None = None
) -> list[ShaderFile]:
    """Find the shaders at the paths, each once, sorted by path: files, and of folders those whose
    extension or `#pragma shader_stage` names a stage, and .glsl files without one that none of all
    these includes. A file in one of the `roots` includes from there, any other from the folder in
    `paths`, or its own. `stage` is every file's; by default each names its own. Raises UsageError:
    a path does not exist, or a folder holds no shader."""
    real_roots = [(os.path.join(os.path.realpath(root), ""), str(root)) for root in roots]
    found: dict[str, ShaderFile] = {}
    for path in map(Path, paths):
        if not path.exists():
            raise UsageError("there is no such file or folder", file=path)
        if not path.is_dir():
            files, folder = [str(path)], str(path.parent)
        else:
            folder = str(path)
            files = list(_walk(folder) if stage else _find_units(folder))
            if not files:
                raise UsageError(
                    "there is no shader in this folder",
                    file=path,
                    remedy=f"shaders are named {' '.join(EXTENSIONS)}, libraries .glsl",
                )
        for file in files:
            key = os.path.abspath(file) if len(paths) > 1 else file
            found.setdefault(key, _locate(file, folder, real_roots))
    return sorted(found.values(), key=lambda shader: shader.path)


def find_other_languages(folder: str | Path) -> list[str]:
    """The files below a folder that `find_shaders` leaves out since their names say another
    language."""
    other = (f for f in _walk(str(folder)) if os.path.splitext(f)[1].lower() in _LANGUAGES)
    return [file for file in other if not holds_glsl(file)]


def _locate(file: str, folder: str, roots: Sequence[tuple[str, str]]) -> ShaderFile:
    real = _resolve_folder(file)
    for real_root, root in roots:
        if real.startswith(real_root):
            return ShaderFile(file, root, real[len(real_root) :])
    start = os.path.join(folder, "")
    name = file[len(start) :] if file.startswith(start) else os.path.relpath(file, folder)
    return ShaderFile(file, folder, name)


def _walk(folder: str) -> Iterator[str]:
    """Yield the files below a folder, those of a folder before those of the folders in it."""
    waiting = deque([folder])
    while waiting:
        where = waiting.popleft()
        _, folders, files = next(os.walk(where), ("", [], []))
        for name in sorted(files):
            yield os.path.join(where, name)
        for name in sorted(folders):
            inner = os.path.join(where, name)
            if not (name.startswith(".") or name in _NO_SHADERS or os.path.islink(inner)):
                waiting.append(inner)


def _find_units(folder: str) -> Iterator[str]:
    """Yield the files below a folder that are compiled by themselves: those with a stage, and
    libraries of functions that none of the files includes."""
    own = (*EXTENSIONS, ".glsl")
    files = [f for f in _walk(folder) if os.path.splitext(f)[1] in own or holds_glsl(f)]
    if not any(map(is_library, files)):
        yield from files
        return
    included = set()
    for file in files:
        with contextlib.suppress(ShaderError):  # who compiles it says what is wrong
            names = _INCLUDED.findall(strip_comments(read_shader(file)))
            included |= set(map(posixpath.basename, names))
    for file in files:
        if not (os.path.basename(file) in included and is_library(file)):
            yield file


def is_library(file: str | Path) -> bool:
    """Return whether a file has functions for others: there is no `main`, and neither a pragma nor
    its name says a stage; or only its name does, and it includes nothing and has no `#version`."""
    stem, suffix = os.path.splitext(file)
    if suffix == ".glsl":
        suffix = os.path.splitext(stem)[1]
    if suffix == ".spv":
        return False
    try:
        code = strip_comments(read_shader(file))
    except ShaderError:
        return False
    words = [_PRAGMA, MAIN, _MAIN_IMAGE, *[_INCLUDED, _VERSION] * (suffix in EXTENSIONS)]
    return not any(word.search(code) for word in words)
