"""Programs linked in the browser, and their uniforms."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Variable
from shaderlab.compiler.sources import Source
from shaderlab.errors import UnsupportedError
from shaderlab.model.activity import doing
from shaderlab.model.frame import Array

from ..programs.blocks import uniform_blocks
from ..resources import ProgramCache
from .device import Calls, Device, Object, Objects
from .essl import Translated, translated

NO_BLOCK = 0xFFFFFFFF


class Program:
    """A linked program.

    Raises:
        UnsupportedError: the browser refuses its ESSL, which glslang took as GLSL.
    """

    def __init__(self, device: Device, source: Translated, feedback: Sequence[str] = ()) -> None:
        self._objects = Objects(device.gl)
        self.gl = device.gl
        self.interface = source.interface
        self.handle = self._objects.new("Program")
        refused = refusal(self.gl, self.handle, source.texts, feedback)
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
        """Where the program writes those of its outputs that have these names."""
        return {
            variable.location: name
            for name, variable in self.interface.outputs.items()
            if name in names and name in self._written and variable.location is not None
        }

    def release(self) -> None:
        """Delete it."""
        self._objects.release()


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
        """The program of these stages.

        Args:
            texts: by stage.
            known: sources, some of whose texts these may be.
            feedback: the vertex outputs to be captured by transform feedback.

        Raises:
            ShaderError: it is no GLSL.
            UnsupportedError: WebGL2 has no such program.
        """

        def linked() -> Program:
            source = translated(texts, known, keep_names=bool(feedback))
            with doing("link"):
                return Program(self.device, source, feedback)

        return self.get((tuple(sorted(texts.items())), tuple(feedback)), linked)


def set_uniform(gl: Calls, location: Object, variable: Variable, values: Array) -> None:
    """Set a uniform of the program in use.

    Args:
        gl: the device's calls.
        location: where it is.
        variable: what it is.
        values: one value or an array of them, matrices as rows of columns.
    """
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


def refusal(
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
    """The first error of a log, without its line, which is one of a text that nobody wrote."""
    lines = [line.strip("\0 ") for line in (said or "").splitlines()]
    errors = [line for line in lines if line.startswith("ERROR")] or [x for x in lines if x]
    return re.sub(r"^ERROR: \d+:\d+: ", "", errors[0]) if errors else "it does not say why"
