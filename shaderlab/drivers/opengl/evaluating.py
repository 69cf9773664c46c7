"""Fragment shaders over a grid: words in by a texture array, words out by attachments."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from functools import lru_cache
from pathlib import Path
from typing import Any

import moderngl
import numpy as np

from shaderlab.compiler.driver_verdict import parse_driver_log
from shaderlab.compiler.interface import Variable
from shaderlab.compiler.sources import Source
from shaderlab.errors import DriverError, ShaderError
from shaderlab.model.frame import Array

from .. import Evaluation, Size
from ..attachments import COVERING
from .bound_textures import BoundTextures
from .device import Device
from .linking import Linker, set_uniforms
from .pyopengl import GL

_CACHED = 4  # grids whose textures are kept; calls come with the same size again and again


class Evaluator:
    """Evaluates on one device; keeps the textures of the last few grids."""

    def __init__(self, device: Device, linker: Linker) -> None:
        self._device = device
        self._linker = linker
        self._input = lru_cache(_CACHED)(self._new_input)
        self._target = lru_cache(_CACHED)(self._new_target)

    def evaluate(self, evaluation: Evaluation, inputs: Array, outputs: Array) -> None:
        context = self._device.context
        context.enable_only(moderngl.NOTHING)
        if len(inputs):
            texture = self._input(evaluation.size, len(inputs), evaluation.lanes)
            texture.write(inputs)
            texture.use(0)
        first = 0
        with ExitStack() as stack:
            for source, words in evaluation.passes:
                program = self._linked(source)
                target = self._target(evaluation.size, words, evaluation.lanes)
                self._set(program, evaluation, bool(len(inputs)), stack)
                target.use()
                for n in range(words):
                    GL.glClearBufferuiv(GL.GL_COLOR, n, np.zeros(4, np.uint32))
                context.vertex_array(program, []).render(vertices=3)
                for n in range(words):
                    target.read_into(
                        outputs[first + n], None, evaluation.lanes, attachment=n, dtype="u4"
                    )
                first += words
        error = context.error
        if error != "GL_NO_ERROR":
            raise DriverError(f"the driver raised {error} while it called a function")

    def _linked(self, source: Source) -> Any:
        try:
            return self._linker.link({"vertex": COVERING, "fragment": source.text})
        except ShaderError as error:
            said = parse_driver_log(error.message.partition("\n")[2], source, ok=False)
            errors = [d for d in said if d.severity == "error"]
            if not errors:
                raise
            raise ShaderError(
                errors[0].message, file=errors[0].file, line=errors[0].line
            ) from error

    def _set(self, program: Any, evaluation: Evaluation, has_input: bool, stack: ExitStack) -> None:
        values: Mapping[str, Array] = evaluation.uniforms
        if has_input and "shaderlab_input" in program:
            program["shaderlab_input"].value = 0
        if len(evaluation.shared) and "shaderlab_shared" in program:
            shared = program["shaderlab_shared"]
            shared.write(evaluation.shared[: shared.array_length].tobytes())
        set_uniforms(program, values)
        if evaluation.textures:
            textures = BoundTextures(Path(evaluation.folder), {}, {}, self._device, stack)
            for unit, (name, (kind, source)) in enumerate(evaluation.textures.items(), start=1):
                variable = Variable(name=name, type=kind)
                textures.texels("the function", variable, source)  # raises where they don't fit
                textures.bind(program, unit, variable, source)

    def _new_input(self, size: Size, layers: int, lanes: int) -> Any:
        return self._device.context.texture_array((*size, layers), lanes, dtype="u4")

    def _new_target(self, size: Size, words: int, lanes: int) -> Any:
        context = self._device.context
        # A new one is made, then the one bound before is bound again: a scene's is gone by now.
        context.detect_framebuffer(0).use()
        return context.framebuffer([context.texture(size, lanes, dtype="u4") for _ in range(words)])
