"""WebGL2 behind the protocol of `shaderlab.drivers`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from typing import ClassVar

from shaderlab.compiler.diagnostics import DRIVER
from shaderlab.compiler.sources import Source
from shaderlab.errors import DriverError, ShaderError, UnsupportedError
from shaderlab.model.frame import PassDraw
from shaderlab.model.records import Verdict

from ..passes import DeviceBackend
from ..programs.module_texts import as_drawn
from ..protocol import Answers
from . import drawing, queries
from .device import Device, Objects
from .drawing import Drawing
from .essl import translated
from .linking import Linker, refusal


class WebGLSession(Drawing):
    """One scene in a browser."""

    vertex_outputs = drawing.vertex_outputs

    def _count(self, key: PassDraw, counter: str) -> int:
        raise UnsupportedError(f"counting {counter}: WebGL2 only says whether there was any")

    def _locations(self, key: PassDraw) -> Mapping[str, int]:
        """Number the uniforms: WebGL2 only says whether there is one."""
        draw = self.programs[key[0]][key[1]]
        program = self.linker.link(as_drawn(draw.draw, draw.texts), draw.sources)
        active = list(program.locations)
        return {
            name: active.index(name) if name in active else -1 for name in draw.interface.uniforms
        }

    def _errors(self, key: PassDraw) -> Sequence[int]:
        return self._gl_errors.get(key, ())

    answers: ClassVar[Answers] = {
        **Drawing.answers,
        "count": _count,
        "time": queries.timed,
        "attributes": queries.attributes,
        "blocks": queries.block_readings,
        "locations": _locations,
        "gl_errors": _errors,
    }


class WebGLBackend(DeviceBackend):
    """Draws scenes in one browser; keeps programs from one to the next."""

    linker_class = Linker
    session_class = WebGLSession
    device: Device

    def in_use(self) -> AbstractContextManager[object]:
        self.device.gl.start_afresh()
        return super().in_use()

    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        """Of the ESSL that SPIRV-Cross makes of a program. A stage alone is only compiled."""
        texts = {source.stage: source.text for source in sources}
        try:
            made = translated(texts, sources)
        except UnsupportedError:
            raise
        except ShaderError as error:
            raise DriverError(
                "WebGL2 gets ESSL made of a module, and of this program there is none",
                file=error.file, line=error.line,
            ) from error  # fmt: skip
        with Objects(self.device.gl) as own:
            refused = refusal(self.device.gl, own.new("Program"), made.texts)
        said = (sources[0].diagnostic(refused),) if refused else ()
        return Verdict(target=DRIVER, ok=not refused, diagnostics=said)

    def close(self) -> None:
        self.device.close()
