"""The calls that drawing a scene takes, as a learner of OpenGL would write them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import moderngl

from shaderlab.backends.opengl.api import fresh_context, prototypes
from shaderlab.backends.opengl.call_recorder import CallRecorder, Recorded
from shaderlab.backends.opengl.call_words import constant_for, object_numbers, word
from shaderlab.backends.opengl.device import REQUIRED_VERSION, Device
from shaderlab.backends.opengl.drawing import Drawing
from shaderlab.backends.opengl.effective_calls import StateTracker
from shaderlab.backends.opengl.linking import Linker
from shaderlab.frame import PassDraw, TracedCall
from shaderlab.model import Pass

if TYPE_CHECKING:
    from shaderlab.backends.opengl.target import RenderTarget
    from shaderlab.programs.prepare import PreparedDraw

# Parameters of textures whose values are constants.
_WORDED = ("_FILTER", "_MODE", "_FUNC", "WRAP_S", "WRAP_T", "WRAP_R")


class _Placed(Drawing):
    """A drawing that tells a recorder which pass and draw it is at."""

    recorder: CallRecorder

    def _run_pass(self, description: Pass) -> None:
        self.recorder.place = (description.name, None)
        super()._run_pass(description)

    def _draw(self, key: PassDraw, draw: PreparedDraw, target: RenderTarget) -> None:
        self.recorder.place = key
        super()._draw(key, draw, target)
        self.recorder.place = (key[0], None)


def trace(session: Drawing) -> Sequence[TracedCall]:
    """As `Session.trace`: the scene is drawn once more, in a context of its own."""
    with fresh_context(session.device) as raw, ExitStack() as stack:
        recorder = CallRecorder(raw)
        options: Any = {"standalone": True, "context": recorder}  # mistyped in moderngl's stubs
        context = moderngl.create_context(require=REQUIRED_VERSION, **options)
        device = Device(context, session.device.info, session.device.driver)
        linker = Linker(device)
        drawing = _Placed(device, linker, session.scene, session.programs, session.size, stack)
        drawing.recorder = recorder
        with recorder.recording():
            drawing.draw()
    files = _program_files(recorder.calls, session)
    tracker = StateTracker()
    return [_spelt(call, files, tracker) for call in recorder.calls]


def _program_files(calls: Sequence[Recorded], session: Drawing) -> dict[str, str]:
    """The programs that draws use, by their fragment shader's file."""

    def file_of(name: str, index: int) -> str:
        return Path(session.programs[name][index].draw.fragment).name

    used: dict[PassDraw, int] = {}
    for call in calls:
        if call.function == "glUseProgram" and call.arguments[0] and call.place[1] is not None:
            used[call.place[0], call.place[1]] = int(call.arguments[0])
    return {
        f"program {number}": f"program {number} ({file_of(name, index)})"
        for (name, index), number in used.items()
    }


def _spelt(call: Recorded, files: Mapping[str, str], tracker: StateTracker) -> TracedCall:
    names = prototypes()[call.function].argNames
    arguments = {
        name: word(call.function, name, value)
        for name, value in zip(names, call.arguments, strict=False)
    }
    if call.function.startswith("glGen") and len(call.arguments) == 2:
        del arguments[names[1]]
    if arguments.get("pname", "").endswith(_WORDED) and arguments.get("param", "").isdigit():
        arguments["param"] = constant_for(call.function, "param", int(arguments["param"]))
    arguments = {name: files.get(word, word) for name, word in arguments.items()}
    made = call.function.startswith(("glGen", "glCreate"))
    return TracedCall(
        pass_name=call.place[0],
        draw=call.place[1],
        function=call.function,
        arguments=arguments,
        returned=object_numbers(call.returned) if made else "",
        effective=tracker.changes(call.function, arguments),
    )
