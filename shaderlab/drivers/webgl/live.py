"""Records the calls that draw a scene's picture, for a page to play them with other uniforms.

No browser takes part: constants stand there by their names, and what only a device can say is left
to the page. Shaders are the author's text with another head.
"""

from __future__ import annotations

import functools
import json
import re
import struct
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np

from shaderlab.compiler.glslang import link
from shaderlab.compiler.reflection import Interface
from shaderlab.compiler.sources import Shaders
from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, Bindings, Texels
from shaderlab.model.pictures.files import deflate
from shaderlab.model.scene import Pass
from shaderlab.model.textures import TextureSource

from .. import Drawn, Session
from ..programs.module_texts import apply_coord_layout, write_point_texts
from ..programs.prepare import PreparedDraw
from ..programs.textures import format_of
from ..resources import DeviceTexels
from .device import ARRAYS, Calls, Device, Objects
from .program import Linker, Program
from .session import WebGLSession
from .target import RenderTarget
from .textures import NO_LEVELS, READ, BoundTextures, encode_texels

_HEAD = "#version 300 es\n" + " ".join(
    f"precision highp {kind};"
    for kind in ("float", "int", "sampler2D", "samplerCube", "sampler2DArray", "sampler2DShadow",
                 "samplerCubeShadow", "sampler2DArrayShadow", "isampler2D", "usampler2D")
)  # fmt: skip
_BODY = "\n//\n"
"""The end of the head: the author's second line follows."""
_NOT_ESSL = re.compile(r"^[ \t]*#version[^\n]*\n|^[ \t]*#extension[^\n]*$", re.MULTILINE)
_ERROR = re.compile(r"^ERROR: (?:\d+:\d+: )?(.*)", re.MULTILINE)
_REDEFINED = re.compile(r"'(\w+)' : redefinition")
_NO_FILES = Shaders(())


def record_calls(
    session: Session, drawn: Drawn, only: set[str], picture: tuple[str, str], side: int
) -> tuple[bytes, str]:
    """Return the calls that draw one output of a scene, (pass, output), which takes `only` some
    passes, packed for the page; or why there are none. `session` is another one, which has `drawn`
    the scene; targets that do not say have `side` × `side` pixels."""
    filtered = {"OES_texture_float_linear"}  # the page knows whether there is
    device = Device(Recorder(), {"max_texture_size": "4096"}, filtered, None)
    made = LiveSession(Linker(device), session.scene, session.programs, (side, side), ExitStack())
    try:
        made.take(drawn)
        passes = [each for each in session.scene.passes if each.name in only]
        for number, description in enumerate(passes):
            made.begin(description, {each.name for each in passes[:number]}, passes[number:])
            made.run_pass(description)
        shown = made.show(*picture, drawn.images[picture].values.shape[2])
    except UnsupportedError as error:
        return b"", error.message
    return made.gl.pack(shown), ""


class Constant(str):
    """A constant of WebGL2 by its name, to which numbers may be added."""

    __slots__ = ()

    def __add__(self, more: object) -> Constant:
        return Constant(f"{self}+{more}")


class Recorder(Calls):
    """Calls that a page will play. Nothing is released, as it is drawn again and again; equal data
    stand there once, but for what the page may change."""

    def __init__(self) -> None:
        self._calls = []
        self._data = bytearray()
        self._last = 0
        self._known: dict[bytes, int] = {}
        self._changing = False
        self.about = {"subpixel": 8}

    def __getattr__(self, name: str) -> Any:
        return Constant(f"={name}") if name.isupper() else functools.partial(self.add, name, 0)

    def ask_all(self, questions: Sequence[tuple[Any, ...]]) -> list[Any]:
        return [self._answer(*question) for question in questions]

    def ask_later(self, then: Callable[[Any], object], name: str, *given: Any) -> None:
        """Ask nothing: the page looks for errors itself."""

    def pack(self, about: Mapping[str, Any]) -> bytes:
        """Return the calls and their data: the length of a text in JSON, the text, and the data:
        the first byte of all words of four, the second of all, and so on."""
        text = json.dumps({**about, "calls": self._calls}, separators=(",", ":")).encode()
        # High bytes of floats are much alike: a third of the bytes, and of the time, is saved.
        planes = np.frombuffer(self._data, np.uint8).reshape(-1, 4).T.tobytes()
        return deflate(struct.pack("<Q", len(text)) + text + planes)

    def _store(self, values: bytes) -> int:
        at = len(self._data)
        if not self._changing and self._known.setdefault(values, at) != at:
            return self._known[values]
        self._data += values + bytes(-len(values) % 8)
        return at

    def _answer(self, name: str, *given: Any) -> Any:
        if name == "getUniformBlockIndex":
            return self.new(name, *given)
        if name in ("link", "locate"):
            self.add(name, 0, *given)
        return {"samples": [2, 4, 8, 16], "locate": True, "written": True}.get(name)

    def add(self, name: str, where: int, *given: Any) -> None:
        self._changing = name.startswith("uniform")
        if name != "release":
            super().add(name, where, *given)


class LiveTarget(RenderTarget):
    """A target whose samples lie where the page's device has them."""

    def sample_positions(self) -> Array:
        return np.zeros((self.samples, 2), np.float32)

    def resolve(self) -> None:
        super().resolve()
        self.bind({})  # once more it begins without colours: none may be attached in two places


class LiveTextures(BoundTextures):
    """Textures with the contents that a driver has read of them already."""

    known: dict[int, Texels]

    def upload(self, source: TextureSource) -> DeviceTexels:
        known = self.known[id(source)]
        if known.kind not in ("2D", "Cube", "2DArray"):
            raise UnsupportedError(f"sampler{known.kind}")
        word, levels = known.format, [known.values, *known.smaller]
        makes = getattr(source, "mipmaps", None) is True and word not in NO_LEVELS
        if known.kind == "2D":
            levels = [level[None] for level in levels]
        layers, height, width = levels[0].shape[:3]
        texture = self._new(known.kind, word, (width, height), len(levels), layers)
        for number, level in enumerate(levels[:1] if makes else levels):
            for layer, values in enumerate(level):
                self._write(texture, number, layer, encode_texels(word, values))
        if makes:
            self._generate(texture)
        return DeviceTexels(source, texture, word, known.values)

    def _smaller(self, texture: Any) -> tuple[Array, ...]:
        return ()


class LiveSession(WebGLSession):
    """A session that draws for a page what another one has drawn."""

    target_class = LiveTarget
    gl: Recorder
    _textures: LiveTextures

    def take(self, drawn: Drawn) -> None:
        """Take what another session drew: sizes of images, uniforms and contents of textures."""
        self.gl = self.device.gl  # type: ignore[assignment]
        self._files: dict[int, dict[str, str]] = {}
        self.images, self._drawn = dict(drawn.images), drawn
        own = Objects(self.gl)
        self._textures = LiveTextures(self.folder, self.images, self.targets, self.device, own)
        self._textures.known = {
            id(source): bindings.textures[name]
            for (pass_name, index), bindings in drawn.bindings.items()
            for name, source in self.programs[pass_name][index].draw.textures.items()
        }

    def begin(self, description: Pass, before: set[str], rest: Sequence[Pass]) -> None:
        """Tell the page of a pass: what it reads, and whether it is drawn with the one before, as
        is where the `rest` goes on in a target of those `before`."""
        read = {output.pass_name for draw in description.draws for output in draw.outputs_read()}
        joined = any(each.onto in before for each in rest)
        self.gl.add("pass", 0, description.name, sorted(read), joined)

    def bind(self, draw: PreparedDraw) -> Bindings:
        for name, source in draw.draw.textures.items():  # making one unbinds another
            self._textures.find(source, self._textures.kind(source, draw.interface.uniforms[name]))
        known = self._drawn.bindings.items()
        return next(bound for (name, n), bound in known if self.programs[name][n] is draw)

    def _read(self, description: object, target: object) -> None:
        """Read nothing."""

    def program_of(self, draw: PreparedDraw) -> Program:
        texts = write_point_texts(draw.draw, draw.texts)
        essl = write_essl(texts, draw.interface)
        make = functools.partial(Program, self.device, essl, draw.interface)
        made = self.linker.get(tuple(essl.items()), make)
        self._files[made.handle.number] = {each.stage: each.name for each in draw.authored}
        return made

    def show(self, pass_name: str, name: str, components: int) -> dict[str, Any]:
        """Read an output for the page; returns what that needs to know. Raises UnsupportedError: it
        is none of colours."""
        gl, target = self.gl, self.targets[pass_name]
        if name not in target.colors:
            raise UnsupportedError(f"a picture of {name}")
        gl.add("pass", 0, "", [pass_name], False)
        attached = gl.TEXTURE_2D, target.textures[name], 0
        gl.bindFramebuffer(gl.FRAMEBUFFER, gl.new("createFramebuffer"))
        gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, *attached)
        read = format_of(target.colors[name]).numpy
        read = read if read in READ else np.float32
        how = (f"={word}" for word in READ[read])
        gl.add("pixels", -1, *target.size, *how, ARRAYS[np.dtype(read)], components)
        kind = "code" if read is np.uint8 else np.dtype(read).kind
        shown = {"size": target.size, "components": components, "kind": kind}
        return {"show": shown, "files": self._files}


def write_essl(texts: Mapping[str, str], interface: Interface) -> dict[str, str]:
    """Return a program's stages as ESSL 3.00: the author's text with another head, attributes and
    outputs at the locations that `interface` has. Raises UnsupportedError: it is none."""
    done = {"vertex": texts["vertex"], "fragment": apply_coord_layout(texts["fragment"])}
    for stage in texts.keys() - done.keys():
        raise UnsupportedError(f"the {stage} stage: WebGL2 has none")
    declared = (("vertex", "in", interface.attributes), ("fragment", "out", interface.outputs))
    for stage, word, variables in declared:
        for name, variable in variables.items():
            place = re.compile(
                rf"^([ \t]*)((?:flat )?{word} \w+ {re.escape(name)}\b)", re.MULTILINE
            )
            located = rf"\1layout(location = {variable.location}) \2"
            done[stage] = place.sub(located, done[stage], count=1)
    return dict(zip(done, _translate(*done.values()), strict=True))


@functools.lru_cache(256)
def _translate(*texts: str, own: frozenset[str] = frozenset()) -> Sequence[str]:
    """Return a vertex and a fragment stage with heads in which `own` names, which ESSL has for
    functions, are others."""
    head = _HEAD + "".join(f"\n#define {name} _{name}" for name in sorted(own)) + _BODY
    done = [head + _NOT_ESSL.sub("", text) for text in texts]
    stages = zip(done, ("vertex", "fragment"), strict=True)
    linked = link([_NO_FILES.from_text(text, to, f"<{to}>") for text, to in stages], "glsl")
    said = "\n".join((*linked.stage_logs.values(), linked.log))
    more = own.union(_REDEFINED.findall(said))
    if linked.ok or more != own:
        return done if linked.ok else _translate(*texts, own=more)
    errors = _ERROR.findall(said) or ["it does not say why"]
    raise UnsupportedError(f"in ESSL 3.00: {errors[0]}")
