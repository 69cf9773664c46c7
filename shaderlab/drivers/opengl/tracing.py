"""The calls that drawing a scene takes, as a learner of OpenGL would write them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import moderngl

from shaderlab.model.call_edits import CallEdit
from shaderlab.model.frame import PassDraw, TracedCall

from .api import fresh_context, prototypes
from .call_recorder import CallRecorder, Recorded
from .call_words import constant_for, makes_objects, object_numbers, word
from .device import REQUIRED_VERSION, Device
from .drawing import Drawing
from .effective_calls import StateTracker
from .linking import Linker

# Parameters of textures whose values are constants.
_WORDED = ("_FILTER", "_MODE", "_FUNC", "WRAP_S", "WRAP_T", "WRAP_R")


@contextmanager
def recording_device(device: Device, edit: CallEdit | None = None) -> Iterator[Device]:
    """A device in a context of its own, whose calls are recorded while a scene is drawn on it.

    Args:
        device: gives the driver.
        edit: a call of the scene's drawing that is made otherwise.
    """
    with fresh_context(device) as raw:
        recorder = CallRecorder(raw, edit)
        options: Any = {"standalone": True, "context": recorder}  # mistyped in moderngl's stubs
        context = moderngl.create_context(require=REQUIRED_VERSION, **options)
        made = Device(context, device.info, device.driver, recorder)
        with made.in_use():
            yield made


def trace(session: Drawing) -> Sequence[TracedCall]:
    """As `Session.trace`: what was recorded when the scene was drawn, or else it is drawn once
    more, in a context of its own."""
    recorder = session.device.recorder
    if recorder is None:
        with recording_device(session.device) as device, ExitStack() as stack:
            linker = Linker(device)
            type(session)(linker, session.scene, session.programs, session.size, stack).draw()
            recorder = device.recorder
    assert recorder is not None
    files = _program_files(recorder.calls, session)
    tracker = StateTracker()
    spelt = [(call.place, _spelt(call, files, tracker)) for call in recorder.calls]
    return [call for place, call in spelt if place is not None]


def _program_files(calls: Sequence[Recorded], session: Drawing) -> dict[str, str]:
    """The programs that draws use, by their fragment shader's file."""

    def file_of(name: str, index: int) -> str:
        return Path(session.programs[name][index].draw.shaders[-1]).name

    used: dict[PassDraw, int] = {}
    for call in calls:
        pass_name, draw = call.place or ("", None)
        if call.function == "glUseProgram" and call.arguments[0] and draw is not None:
            used[pass_name, draw] = int(call.arguments[0])
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
    if makes_objects(call.function) and len(call.arguments) == 2:
        del arguments[names[1]]
    if arguments.get("pname", "").endswith(_WORDED) and arguments.get("param", "").isdigit():
        arguments["param"] = constant_for(call.function, "param", int(arguments["param"]))
    arguments = {name: files.get(word, word) for name, word in arguments.items()}
    made = makes_objects(call.function)
    pass_name, draw = call.place or ("", None)
    before = tracker.state_for(call.function)
    return TracedCall(
        pass_name=pass_name,
        draw=draw,
        function=call.function,
        arguments=arguments,
        returned=object_numbers(call.returned) if made else "",
        effective=tracker.changes(call.function, arguments),
        state=before,
    )
