"""The browser's own verdict on a program, of the ESSL that SPIRV-Cross makes of it."""

from __future__ import annotations

from collections.abc import Sequence

from shaderlab.backends.webgl.calls import Objects
from shaderlab.backends.webgl.device import Device
from shaderlab.backends.webgl.essl import translated
from shaderlab.backends.webgl.linking import refusal
from shaderlab.compiler.driver_verdict import DRIVER
from shaderlab.compiler.sources import Source
from shaderlab.errors import DriverError, ShaderError, UnsupportedError
from shaderlab.records import Verdict


def driver_verdict(device: Device, sources: Sequence[Source]) -> Verdict:
    """Whether the browser takes a program. A stage alone is only compiled.

    Raises:
        DriverError: the program has no module that could be translated.
        UnsupportedError: ESSL 3.00 can't say it.
    """
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
    with Objects(device.gl) as own:
        refused = refusal(device.gl, own.new("Program"), made.texts)
    if not refused:
        return Verdict(target=DRIVER, ok=True)
    return Verdict(target=DRIVER, ok=False, diagnostics=(sources[0].diagnostic(refused),))
