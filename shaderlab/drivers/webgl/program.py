"""Programs of ESSL 3.00, which SPIRV-Cross makes of SPIR-V modules, and fixed-function state."""

import re
import subprocess
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Interface, Variable
from shaderlab.compiler.sources import Source
from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array
from shaderlab.model.phases import phase
from shaderlab.model.state import Blend, State, Stencil

from ..gl_state import state_calls
from ..programs import stages
from ..programs.bind import uniform_blocks
from ..programs.module_texts import (
    apply_coord_layout,
    assign_locations,
    compile_to_modules,
    make_sources,
)
from ..resources import ProgramCache
from .device import Calls, Device, Object, Objects, find_cross_compiler

_STAGES = ("vertex", "fragment")
_MOST_LOCATIONS = 32
_SECONDS = 30


def translate(
    texts: Mapping[str, str], known: Sequence[Source] = (), *, keep_names: bool = False
) -> tuple[dict[str, str], Interface]:
    """Return a program in ESSL and its interface; `texts` are GLSL by stage, some those of `known`.

    What one stage hands to the other goes by its location, unless a vertex stage's outputs are to
    `keep_names`: SPIRV-Cross names members by a block's instance, which stages name as they like.
    Raises ShaderError: it is no GLSL; UnsupportedError: ESSL 3.00 can't say it."""
    for stage in texts:
        if stage not in _STAGES:
            raise UnsupportedError(f"the {stage} stage: WebGL2 has none")
    own = {
        stage: assign_locations(apply_coord_layout(text) if stage == "fragment" else text)
        for stage, text in texts.items()
    }
    with phase("compile"):
        compiled = compile_to_modules(make_sources(own, known), "opengl", "WebGL2")
        assert compiled.interface is not None
        modules = compiled.spirv["opengl"]
        essl = {stage: _essl(stage, modules[stage], keep_names) for stage in own}
        return essl, compiled.interface


def _essl(stage: str, module: bytes, keep_names: bool) -> str:
    command = [find_cross_compiler(), "-", "--es", "--version", "300"]
    if not keep_names:
        direction = "out" if stage == "vertex" else "in"
        for place in range(_MOST_LOCATIONS):
            name = f"{stages.PREFIX}at{place}"
            command += ["--rename-interface-variable", direction, str(place), name]
    done = subprocess.run(command, input=module, capture_output=True, timeout=_SECONDS)
    if done.returncode:
        said = done.stderr.decode("utf-8", "replace").strip().splitlines()
        message = next((line for line in said if line.strip()), "it does not say why")
        raise UnsupportedError(f"the {stage} stage in ESSL 3.00: {message}")
    return done.stdout.decode("utf-8")


NO_BLOCK = 0xFFFFFFFF


class Program:
    """A linked program. Raises UnsupportedError: the browser refuses its ESSL."""

    def __init__(
        self,
        device: Device,
        texts: Mapping[str, str],
        interface: Interface,
        feedback: Sequence[str] = (),
    ) -> None:
        self._objects = Objects(device.gl)
        self.gl = device.gl
        self.interface = interface
        self.handle = self._objects.new("Program")
        refused = find_refusal(self.gl, self.handle, texts, feedback)
        if refused:
            self.release()
            raise UnsupportedError(refused)
        self._find()

    def _find(self) -> None:
        """Ask where uniforms, blocks and outputs are; those without any effect are nowhere."""
        gl, known = self.gl, self.interface
        places = {name: gl.number() for name in known.uniforms}
        blocks = uniform_blocks(known)
        # SPIRV-Cross puts an underscore before words that ESSL reserves.
        questions: list[tuple[Any, ...]] = [
            *(
                ("locate", self.handle, place.number, [name, f"{name}[0]", f"_{name}"])
                for name, place in places.items()
            ),
            *(("getUniformBlockIndex", self.handle, name) for name in blocks),
            *(("written", self.handle, [name, f"_{name}"]) for name in known.outputs),
        ]
        answers = iter(gl.ask_all(questions) if questions else [])
        self.locations = {name: place for name, place in places.items() if next(answers)}
        indices = {name: next(answers) for name in blocks}
        self.blocks = {name: index for name, index in indices.items() if index != NO_BLOCK}
        self._written = {name for name in known.outputs if next(answers)}

    def set(self, name: str, values: Array) -> bool:
        """Set a uniform, which is in use; False if it has no effect."""
        if name not in self.locations:
            return False
        set_uniform(self.gl, self.locations[name], self.interface.uniforms[name], values)
        return True

    def outputs(self, names: Mapping[str, object]) -> dict[int, str]:
        """Return where the program writes those of its outputs that have these names."""
        return {
            variable.location: name
            for name, variable in self.interface.outputs.items()
            if name in names and name in self._written and variable.location is not None
        }

    def release(self) -> None:
        self._objects.close()


class Linker(ProgramCache[Program]):
    """Programs by their stages' text in GLSL."""

    device: Device

    def link(
        self,
        texts: Mapping[str, str],
        known: Sequence[Source] = (),
        *,
        feedback: Sequence[str] = (),
    ) -> Program:
        """Return the program of these stages, which captures the vertex outputs of `feedback`.
        Raises ShaderError, UnsupportedError: as `translate` and `Program`."""

        def linked() -> Program:
            essl, interface = translate(texts, known, keep_names=bool(feedback))
            with phase("link"):
                return Program(self.device, essl, interface, feedback)

        return self.get((tuple(sorted(texts.items())), tuple(feedback)), linked)


def set_uniform(gl: Calls, location: Object, variable: Variable, values: Array) -> None:
    """Set a uniform of the program in use to one value, or an array of them; matrices as rows."""
    kind = variable.type
    if "mat" in kind:
        size = kind.partition("mat")[2]
        columns, _, rows = size.partition("x")
        spelt = columns if rows in ("", columns) else size
        turned = np.ascontiguousarray(np.swapaxes(values, -1, -2), np.float32)
        getattr(gl, f"uniformMatrix{spelt}fv")(location, False, turned)
        return
    letter = {"u": "ui", "i": "i", "b": "i"}.get(kind[0], "f")
    wanted = {"ui": np.uint32, "i": np.int32, "f": np.float32}[letter]
    count = int(kind[-1]) if kind[-1].isdigit() else 1
    getattr(gl, f"uniform{count}{letter}v")(location, np.ascontiguousarray(values, wanted))


def find_refusal(
    gl: Calls, program: Object, texts: Mapping[str, str], feedback: Sequence[str] = ()
) -> str:
    """Link a program of these stages in ESSL, or compile one alone: why it can't be done, or ""."""
    refused = gl.ask("link", program, dict(texts), list(feedback))
    if not refused:
        return ""
    stage, said = refused
    what = f"the {stage} stage in WebGL2" if stage else "linking in WebGL2"
    return f"{what}: {_first_error(said)}"


def _first_error(said: str | None) -> str:
    """Return the first error of a log, without its line, which counts in generated text."""
    lines = [line.strip("\0 ") for line in (said or "").splitlines()]
    errors = [line for line in lines if line.startswith("ERROR")] or [x for x in lines if x]
    return re.sub(r"^ERROR: \d+:\d+: ", "", errors[0]) if errors else "it does not say why"


def check_state(state: State, *, samples: int, encodes: bool) -> None:
    """Raise UnsupportedError for what WebGL2 has not, though OpenGL has; `samples` are those of the
    draw's target, which `encodes` if it has attachments of sRGB."""
    front = state.stencil or Stencil()
    back = state.stencil_back or front
    for lacks, what in (
        (samples > 1 and not state.multisample,
         "multisample=False: WebGL2 covers the samples of a target always"),
        (state.sample_shading is not None, "sample_shading: WebGL2 shades pixels only"),
        (encodes and not state.srgb,
         "srgb=False: WebGL2 encodes whatever is drawn to attachments of sRGB"),
        (state.depth_range[0] > state.depth_range[1],
         "a depth_range from far to near: WebGL2 has none"),
        ((front.reference, front.mask, front.write_mask)
         != (back.reference, back.mask, back.write_mask),
         "stencil_back: in WebGL2 both faces have one reference and one mask"),
        (_mixes_constants(state.blend),
         "a factor of the constant colour with one of the constant alpha: WebGL2 has none"),
    ):  # fmt: skip
        if lacks:
            raise UnsupportedError(what)


def apply_state(gl: Calls, state: State, size: tuple[int, int]) -> None:
    for call in state_calls(state, size, {"rasterizer_discard": False}):
        gl.make(*call)


def _mixes_constants(blend: Blend | None) -> bool:
    factors = [] if blend is None else [blend.source, blend.destination]
    constants = {word.removeprefix("one_minus_") for word in factors}
    return constants == {"constant_color", "constant_alpha"}
