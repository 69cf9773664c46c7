"""Linking programs on the driver, once each; their outputs and uniforms."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import moderngl
import numpy as np

from shaderlab.errors import ShaderError
from shaderlab.model.activity import doing
from shaderlab.model.frame import Array

from ..program_cache import ProgramCache
from .device import Device
from .pyopengl import GL


class Linker(ProgramCache[Any]):
    """Linked programs by their stages' text; a driver that `takes_spirv` gets the modules of it."""

    device: Device

    def drop(self, program: Any) -> None:
        """moderngl releases it when nothing refers to it any more."""

    def link(self, stages: Mapping[str, str], *, feedback: Sequence[str] = ()) -> Any:
        """A `moderngl.Program` of these stages (text by "vertex", "tess_control", …), a
        `moderngl.ComputeShader` of "compute", or a `SpirvProgram`, which can do what the lab needs
        of them.

        `feedback` are the vertex outputs to be captured by transform feedback.

        Raises:
            ShaderError: the driver refuses the program.
        """

        def linked() -> Any:
            try:
                with doing("link"):
                    return self._new(stages, feedback)
            except moderngl.Error as error:
                message = f"the driver refuses the program: {str(error).strip()}"
                raise ShaderError(message) from error

        return self.get((tuple(sorted(stages.items())), tuple(feedback)), linked)

    def _new(self, stages: Mapping[str, str], feedback: Sequence[str]) -> Any:
        if self.device.takes_spirv:
            from .spirv_program import link_modules

            return link_modules(self.device, stages, feedback)
        if "compute" in stages:
            return self.device.context.compute_shader(stages["compute"])
        return self.device.context.program(
            vertex_shader=stages["vertex"],
            fragment_shader=stages.get("fragment"),
            tess_control_shader=stages.get("tess_control"),
            tess_evaluation_shader=stages.get("tess_evaluation"),
            geometry_shader=stages.get("geometry"),
            varyings=tuple(feedback),
        )


def has_names(program: Any) -> bool:
    """Whether the driver knows a program's variables by their names: not those of a module."""
    return isinstance(program, moderngl.Program | moderngl.ComputeShader)


def uniform_location(program: Any, name: str) -> int:
    """Where a linked program has a uniform; −1 for none."""
    if not has_names(program):
        return int(program.location(name))
    return int(GL.glGetUniformLocation(program.glo, name.encode()))


def output_locations(program: Any, names: Iterable[str]) -> dict[str, int]:
    """Where the linked program writes each of its fragment outputs; −1 for one it has not."""
    if not has_names(program):
        return {name: program.output(name) for name in names}
    return {name: int(GL.glGetFragDataLocation(program.glo, name.encode())) for name in names}


def set_uniforms(program: Any, values: Mapping[str, Array]) -> list[str]:
    """Upload uniforms; matrices are transposed into GLSL's columns-first order.

    Returns the names that the driver does not know: declared, but with no effect on any output.
    They are set as well, at the location −1, which OpenGL ignores. Members of uniform blocks are no
    uniforms to be set; leave them out.
    """
    inactive = []
    for name, array in values.items():
        member = program.get(name, None)
        if member is None:
            inactive.append(name)
            _set_nowhere(program, array)
            continue
        matrix = member.dimension in (4, 6, 8, 9, 12, 16) and array.ndim >= 2
        data = np.ascontiguousarray(np.swapaxes(array, -1, -2) if matrix else array)
        count = getattr(member, "array_length", 1)
        member.write(data.reshape(-1)[: count * member.dimension].tobytes())
    return inactive


def _set_nowhere(program: Any, array: Array) -> None:
    """Set a uniform that has no location, by the function for its type."""
    GL.glUseProgram(program.glo)
    kind, own = {"f": ("f", np.float32), "u": ("ui", np.uint32)}.get(
        array.dtype.kind, ("i", np.int32)
    )
    array = np.ascontiguousarray(array, own)
    if array.ndim >= 2 and kind == "f":
        rows, columns = array.shape[-2:]
        if 2 <= rows <= 4 and 2 <= columns <= 4:
            size = str(rows) if rows == columns else f"{columns}x{rows}"
            getattr(GL, f"glUniformMatrix{size}fv")(-1, 1, False, np.swapaxes(array, -1, -2).copy())
            return
    components = array.shape[-1] if array.ndim and array.shape[-1] <= 4 else 1
    getattr(GL, f"glUniform{components}{kind}v")(-1, array.size // components, array)
