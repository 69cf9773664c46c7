"""A context whose calls of OpenGL are written down: moderngl's, and those made through PyOpenGL.

moderngl takes each function's address from its context, which hands out one that writes the call
down and passes it on. PyOpenGL's functions are replaced while calls are recorded, and put back.
What is written down is what the driver gets: an edit of one call comes before that.
"""

import ctypes
import hashlib
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from types import ModuleType
from typing import Any

import moderngl
import numpy as np

from shaderlab.errors import ShaderlabError
from shaderlab.model.calls import CallEdit, ChangeCall, PostponeCall, RepeatCall
from shaderlab.model.frame import PassDraw, TracedCall

from .calls import constant, constants, fresh_context, prototypes
from .device import GL, GL_1_0, GL_1_2, GL_1_3, REQUIRED_VERSION, Device
from .drawing import Drawing
from .linking import Linker

_NUMBERS: Mapping[str, Any] = {"f": ctypes.c_float, "i": ctypes.c_int, "ui": ctypes.c_uint}
# Queries and waits, which change nothing that is drawn.
_SILENT = ("glGet", "glIs", "glCheck", "glFinish", "glFlush", "glReadPixels", "glReadBuffer")


Place = tuple[str, int | None]
"""A pass, and a draw of it; None for its target."""


@dataclass(frozen=True)
class Recorded:
    """One call: its place as `CallRecorder.place` was then, the C name, the arguments as they were
    passed, and what was returned."""

    place: Place | None
    function: str
    arguments: tuple[Any, ...]
    returned: Any


class CallRecorder:
    """Stands for the context of glcontext that moderngl uses. `calls` is what was recorded, `place`
    the pass and the draw that calls are made for; None for the lab's own reading."""

    def __init__(self, context: Any, edit: CallEdit | None = None) -> None:
        self.calls: list[Recorded] = []
        self.place: Place | None = ("", None)
        self._context = context
        self._edit = edit
        self._counts: Counter[str] = Counter()
        self._postponed: Callable[[], Any] | None = None
        self._repeated: tuple[str, Callable[[], Any], list[int]] | None = None

    @contextmanager
    def recording(self) -> Iterator[None]:
        """Record what is called meanwhile, in place of what was recorded before. Raises
        ShaderlabError: the call of the edit was not made."""
        self.calls.clear()
        self._counts.clear()
        self._postponed = self._repeated = None
        own = {(module, name): getattr(module, name) for module, name in _list_functions()}
        for (module, name), function in own.items():
            setattr(module, name, _wrap(name, function))
        _RECORDING.append(self)
        try:
            yield
        finally:
            _RECORDING.remove(self)
            for (module, name), function in own.items():
                setattr(module, name, function)
        edit = self._edit
        if edit is not None and self._counts[edit.function] <= edit.number:
            raise ShaderlabError(
                f"the drawing has no call {edit.number} of {edit.function}",
                remedy="this is a defect of shaderlab: a drawing takes the same calls each time",
            )

    def load_opengl_function(self, name: str) -> int:
        """Return the address of a function that records its calls; 0 where the driver has none."""
        address = int(self._context.load_opengl_function(name) or 0)
        known = prototypes().get(name)
        if not address or known is None or _is_silent(name):
            return address
        return int(ctypes.cast(_callback(name, address), ctypes.c_void_p).value or 0)

    def __enter__(self) -> Any:
        return self._context.__enter__()

    def __exit__(self, *error: object) -> Any:
        return self._context.__exit__(*error)

    def release(self) -> None:
        self._context.release()

    def make(self, name: str, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        """Make and record a call, or what becomes of it; returns what the caller gets for it."""
        made = partial(self._record, name, function)
        if self.place is None:
            return made(*arguments)
        number, edit = self._counts[name], self._edit
        self._counts[name] += 1
        if edit is not None and (edit.function, edit.number) == (name, number):
            return self._make_edited(edit, made, arguments)
        if self._repeated is not None and name.startswith(("glDrawArrays", "glDrawElements")):
            self._repeat(*self._repeated)
        returned = made(*arguments)
        if isinstance(edit, PostponeCall) and edit.behind == (name, number) and self._postponed:
            self._postponed()
        return returned

    def _record(self, name: str, function: Callable[..., Any], *arguments: Any) -> Any:
        returned = function(*arguments)
        kept, came = arguments, returned
        # A caller in C passes a count and an address, one in Python arrays.
        has_address = len(arguments) == 2 and isinstance(arguments[1], int)
        if has_address and name.startswith(("glGen", "glDrawBuffers")):
            numbers = list((ctypes.c_uint * arguments[0]).from_address(arguments[1]))
            kept, came = (arguments[0], numbers), numbers
        elif name.startswith("glUniform"):
            kept = _copy_values(name, arguments)
        self.calls.append(Recorded(self.place, name, kept, came))
        return returned

    def _make_edited(
        self, edit: CallEdit, made: Callable[..., Any], arguments: tuple[Any, ...]
    ) -> Any:
        known, pass_name = prototypes()[edit.function], (self.place or ("", None))[0]
        if isinstance(edit, ChangeCall):
            place = list(known.argNames).index(edit.parameter)
            new: Any = constant(edit.value) if isinstance(edit.value, str) else edit.value
            if isinstance(arguments[place], ctypes.c_void_p):
                new = ctypes.c_void_p(new)
            elif isinstance(arguments[place], np.ndarray):
                new = np.full_like(arguments[place], new)
            return made(*arguments[:place], new, *arguments[place + 1 :])
        later = partial(made, *_copy_arguments(edit.function, arguments))
        if isinstance(edit, RepeatCall):
            self._repeated = (pass_name, later, _read_bindings())
            return made(*arguments)
        if isinstance(edit, PostponeCall):
            self._postponed = later
        return None if known.restype is None else 0

    def _repeat(self, pass_name: str, made: Callable[[], Any], bindings: list[int]) -> None:
        """Make a call once more, if this is its pass, with what was bound when it was made."""
        if self.place is None or self.place[0] != pass_name:
            return
        before = _read_bindings()
        _use_bindings(bindings)
        made()
        _use_bindings(before)


@cache
def _list_functions() -> Sequence[tuple[ModuleType, str]]:
    return [
        (module, name)
        for module in (GL, GL_1_0, GL_1_2, GL_1_3)
        for name in prototypes()
        if hasattr(module, name) and not _is_silent(name)
    ]


_RECORDING: list[CallRecorder] = []
"""The recorders that are recording; the last one gets the calls."""


@cache
def _callback(name: str, address: int) -> Any:
    """A function that passes calls on to the one at `address`, and has them recorded while a
    recorder is recording. It stays for good: contexts have its address only, and a driver gives
    each context the same functions."""
    known = prototypes()[name]
    arguments = map(_callback_type, known.argtypes or ())
    kind = ctypes.CFUNCTYPE(_callback_type(known.restype), *arguments)
    return kind(_wrap(name, kind(address)))


def _wrap(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    def recorded(*arguments: Any) -> Any:
        if not _RECORDING:
            return function(*arguments)
        return _RECORDING[-1].make(name, function, arguments)

    return recorded


def _is_silent(name: str) -> bool:
    return name.startswith(_SILENT)


def _copy_values(name: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    """Replace the address that a glUniform…v function takes by the values there."""
    found = VECTOR.fullmatch(name)
    if found is None or not isinstance(arguments[-1], int):
        return arguments
    count = count_numbers(name, arguments[1])
    values = (_NUMBERS[found["kind"]] * count).from_address(arguments[-1])
    return (*arguments[:-1], np.array(values))


def _callback_type(kind: Any) -> Any:
    """A C type as callbacks take it: pointers of any kind are addresses."""
    if kind is None:
        return None
    simple = isinstance(kind, type) and issubclass(kind, ctypes._SimpleCData)
    return kind if simple and kind is not ctypes.c_char_p else ctypes.c_void_p


# Parameters whose numbers stand for constants, and those that join bits.
_ENUMS = {
    "target", "mode", "cap", "func", "usage", "type", "format", "internalformat", "internalFormat",
    "pname", "attachment", "face", "sfactor", "dfactor", "sfactorRGB", "dfactorRGB", "sfactorAlpha",
    "dfactorAlpha", "modeRGB", "modeAlpha", "fail", "zfail", "zpass", "sfail", "dpfail", "dppass",
    "renderbuffertarget", "textarget", "filter", "buffer", "texture", "shaderType", "src",
    "primitiveMode",
}  # fmt: skip
_FLAGS = {"flag", "normalized", "transpose", "red", "green", "blue", "alpha"}
_MASKS = {"glClear", "glBlitFramebuffer", "glMapBufferRange"}
# What an object's number is a name of, by the parameter that takes it.
_OBJECTS = {
    "program": "program", "shader": "shader", "array": "vertex array", "framebuffer": "framebuffer",
    "renderbuffer": "renderbuffer", "sampler": "sampler", "buffer": "buffer", "texture": "texture",
    "id": "query",
}  # fmt: skip
_PREFERRED = {
    "mode": ("GL_POINTS", "GL_LINES"), "func": ("GL_NEVER",), "fail": ("GL_ZERO", "GL_KEEP"),
    "attachment": ("GL_COLOR_ATTACHMENT0",), "type": ("GL_UNSIGNED_BYTE",),
}  # fmt: skip
_BITS = {
    "mask": ("GL_COLOR_BUFFER_BIT", "GL_DEPTH_BUFFER_BIT", "GL_STENCIL_BUFFER_BIT"),
    "access": ("GL_MAP_READ_BIT", "GL_MAP_WRITE_BIT"),
}
_LONGEST = 40


def format_argument(function: str, name: str, value: Any) -> str:
    """Format the argument of a function for its parameter `name`."""
    constant = getattr(value, "name", None)
    if isinstance(constant, str):  # PyOpenGL's constants know their own names
        return constant
    if isinstance(value, bool | np.bool_):
        return "GL_TRUE" if value else "GL_FALSE"
    if isinstance(value, int | np.integer):
        return _format_number(function, name, int(value))
    if isinstance(value, ctypes.c_void_p):
        value = value.value
        if value is not None:
            return f"byte {value}" if value < 1 << 31 else "a pointer"
    if value is None:
        return "NULL"
    if name == "bufs":
        return f"[{' '.join(find_constant(function, 'attachment', int(x)) for x in value)}]"
    if isinstance(value, float | np.floating):
        return f"{value:g}"
    if isinstance(value, bytes | bytearray | memoryview):
        return f"{len(value)} bytes"
    if isinstance(value, np.ndarray):
        text = " ".join(str(x) if x.dtype.kind in "iu" else f"{x:g}" for x in value.ravel()[:17])
        return f"[{text}]" if value.size <= 16 else f"{value.size} values"
    text = " ".join(str(value).split())
    return text if len(text) <= _LONGEST else f"{len(text)} characters"


def _format_number(function: str, name: str, value: int) -> str:
    if name in _FLAGS and value in (0, 1):
        return ("GL_FALSE", "GL_TRUE")[value]
    if function in _MASKS and name in _BITS:
        return " | ".join(w for w in _BITS[name] if value & constants()[w]) or str(value)
    if name in ("mask", "ref") and value > 0xFFFF:
        return f"0x{value:X}"
    known = find_constant(function, name, value) if name in _ENUMS else ""
    if known:
        return known
    if name in _OBJECTS:
        return f"{_OBJECTS[name]} {value}" if value else "0"
    return str(value) if abs(value) < 1 << 31 else "a pointer"


def find_constant(function: str, name: str, value: int) -> str:
    """Find the constant that a parameter's number stands for; "" for none."""
    if name in ("buffer", "texture") and function not in ("glClearBufferfv", "glActiveTexture"):
        return ""  # an object's number
    known = _constants_by_number().get(value, ())
    for word in (*_PREFERRED.get(name, ()), "GL_ZERO" if "factor" in name else "GL_NONE"):
        if word in known:
            return word
    plain = [w for w in known if not w.endswith("_BIT")]
    return min(plain or known, key=len, default="")


@cache
def _constants_by_number() -> Mapping[int, Sequence[str]]:
    found: dict[int, list[str]] = {}
    for word, number in constants().items():
        found.setdefault(number, []).append(word)
    return found


def makes_objects(function: str) -> bool:
    """Whether a function makes objects: glGenerateMipmap does not."""
    return function.startswith(("glGen", "glCreate")) and not function.startswith("glGenerate")


# What a call sets apart from others of its function: the parameters that choose the place.
_PLACES: Mapping[str, tuple[str, ...]] = {
    "glBindTexture": ("target",),
    "glBindBuffer": ("target",),
    "glBindFramebuffer": ("target",),
    "glBindRenderbuffer": ("target",),
    "glBindSampler": ("unit",),
    "glPixelStorei": ("pname",),
    "glStencilFuncSeparate": ("face",),
    "glStencilOpSeparate": ("face",),
    "glStencilMaskSeparate": ("face",),
}
_ONE_PLACE = (
    "glActiveTexture", "glBindVertexArray", "glBlendColor", "glBlendEquationSeparate",
    "glBlendFuncSeparate", "glColorMask", "glCullFace", "glDepthFunc", "glDepthMask",
    "glDepthRange", "glDrawBuffers", "glFrontFace", "glMinSampleShading", "glPointSize",
    "glPolygonMode", "glPolygonOffset", "glScissor", "glUseProgram", "glViewport",
)  # fmt: skip
# OpenGL 4.6, chapter 23, tables of state: what a new context has.
_INITIAL: Mapping[tuple[str, ...], tuple[str, ...]] = {
    ("glActiveTexture",): ("GL_TEXTURE0",),
    ("glBindVertexArray",): ("0",),
    ("glBlendColor",): ("0", "0", "0", "0"),
    ("glBlendEquationSeparate",): ("GL_FUNC_ADD", "GL_FUNC_ADD"),
    ("glColorMask",): ("GL_TRUE",) * 4,
    ("glCullFace",): ("GL_BACK",),
    ("glDepthFunc",): ("GL_LESS",),
    ("glDepthMask",): ("GL_TRUE",),
    ("glDepthRange",): ("0", "1"),
    ("glFrontFace",): ("GL_CCW",),
    ("glMinSampleShading",): ("0",),
    ("glPointSize",): ("1",),
    ("glPolygonMode",): ("GL_FRONT_AND_BACK", "GL_FILL"),
    ("glPolygonOffset",): ("0", "0"),
    ("glUseProgram",): ("0",),
    ("cap", "GL_MULTISAMPLE"): ("glEnable",),
    ("cap", "GL_DITHER"): ("glEnable",),
}
# State that counts only while a test is on.
_WHILE = {
    "glBlend": "GL_BLEND", "glStencil": "GL_STENCIL_TEST", "glDepthFunc": "GL_DEPTH_TEST",
    "glCullFace": "GL_CULL_FACE", "glFrontFace": "GL_CULL_FACE", "glScissor": "GL_SCISSOR_TEST",
    "glMinSampleShading": "GL_SAMPLE_SHADING", "glPolygonOffset": "GL_POLYGON_OFFSET_FILL",
    "glPointSize": "GL_PROGRAM_POINT_SIZE",
}  # fmt: skip
# Where the place depends on what is bound: what binds it.
_WITHIN: Mapping[tuple[str, ...], tuple[str, ...]] = {
    ("glBindTexture",): ("glActiveTexture",),
    ("glBindBuffer", "GL_ELEMENT_ARRAY_BUFFER"): ("glBindVertexArray",),
    ("glDrawBuffers",): ("glBindFramebuffer", "GL_DRAW_FRAMEBUFFER"),
}
# Calls that draw find all state; others only what says which object they are about.
_DRAWS = ("glDraw", "glClear", "glBlit")
_NAMES_OBJECTS = ("glBind", "glActiveTexture", "glUseProgram", "glPixelStore")


class StateTracker:
    """Follows a context's state from call to call."""

    def __init__(self) -> None:
        self._state = dict(_INITIAL)

    def changes(self, function: str, arguments: Mapping[str, str]) -> bool:
        """Whether a call changes what the context has, or does something; each call in its turn."""
        if function in ("glEnable", "glDisable"):
            return self._set(("cap", arguments["cap"]), (function,), ("glDisable",))
        if self._is_off(function):
            return False
        if not _only_sets(function):
            self._follow(function, arguments)
            return True
        value = tuple(word for name, word in arguments.items() if name != "target")
        if arguments.get("target") == "GL_FRAMEBUFFER":
            both = [(function, f"GL_{word}_FRAMEBUFFER") for word in ("READ", "DRAW")]
            return any([self._set(key, value, ("0",)) for key in both])
        return self._set(self._place(function, arguments), value, None)

    def state_for(self, function: str) -> str:
        """The state that counts for a call, as a digest; "" for a call that only sets state."""
        if function in ("glEnable", "glDisable") or _only_sets(function):
            return ""
        everything = function.startswith(_DRAWS) and function != "glDrawBuffers"
        found = {
            key: value
            for key, value in self._state.items()
            if not self._is_off(key[0]) and (everything or key[0].startswith(_NAMES_OBJECTS))
        }
        return hashlib.blake2b(repr(sorted(found.items())).encode(), digest_size=8).hexdigest()

    def _is_off(self, function: str) -> bool:
        """Whether a function sets state of a test that is off."""
        tests = _tests_of(function)
        return bool(tests) and any(self._state.get(("cap", t)) != ("glEnable",) for t in tests)

    def _place(self, function: str, arguments: Mapping[str, str]) -> tuple[str, ...]:
        """Return what a call of this function sets."""
        key = (function, *(arguments[name] for name in _PLACES.get(function, ())))
        within = _WITHIN.get(key) or _WITHIN.get(key[:1])
        return key if within is None else (*key, *self._state.get(within, ("0",)))

    def _follow(self, function: str, arguments: Mapping[str, str]) -> None:
        """Follow what a call sets besides what it does."""
        if function in ("glBindBufferBase", "glBindBufferRange"):
            self._state["glBindBuffer", arguments["target"]] = (arguments["buffer"],)
        elif function == "glColorMaski":
            self._state.pop(("glColorMask",), None)
        elif function.startswith("glDelete"):  # what is bound no longer is: nothing is known
            for key in [key for key in self._state if key[0].startswith("glBind")]:
                del self._state[key]

    def _set(
        self, key: tuple[str, ...], value: tuple[str, ...], initial: tuple[str, ...] | None
    ) -> bool:
        before = self._state.get(key, initial)
        self._state[key] = value
        return value != before


@cache
def _tests_of(function: str) -> tuple[str, ...]:
    """The tests without which what a function sets does not count."""
    return tuple(cap for prefix, cap in _WHILE.items() if function.startswith(prefix))


def _only_sets(function: str) -> bool:
    return function in _PLACES or function in _ONE_PLACE


VECTOR = re.compile(
    r"glUniform(?P<matrix>Matrix)?(?P<rows>\d)(?:x(?P<columns>\d))?(?P<kind>f|i|ui)v"
)
"""Functions that take the address of values, four bytes each."""
# Of functions that take the address of bytes: the places of the address and of their number.
_SIZED = {"glBufferData": (2, 1), "glBufferSubData": (3, 2)}
# What a call is about besides its arguments: how to ask for it, and how to set it.
_BINDINGS: Sequence[tuple[str, Callable[[int], None]]] = (
    ("GL_VERTEX_ARRAY_BINDING", lambda n: GL.glBindVertexArray(n)),
    ("GL_ARRAY_BUFFER_BINDING", lambda n: GL.glBindBuffer(GL.GL_ARRAY_BUFFER, n)),
    ("GL_UNIFORM_BUFFER_BINDING", lambda n: GL.glBindBuffer(GL.GL_UNIFORM_BUFFER, n)),
    ("GL_CURRENT_PROGRAM", lambda n: GL.glUseProgram(n)),
)


def _use_bindings(bindings: list[int]) -> None:
    for (_, bind), number in zip(_BINDINGS, bindings, strict=True):
        bind(number)


def _read_bindings() -> list[int]:
    return [int(GL.glGetIntegerv(getattr(GL, name))) for name, _ in _BINDINGS]


class _Address(int):
    """The address of memory that lives as long as this number."""

    memory: Any = None


def _copy_arguments(name: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    """Copy what addresses among the arguments lead to, so that they stay valid after the call."""
    place, size = len(arguments) - 1, 0
    if name in _SIZED:
        place, from_place = _SIZED[name]
        size = arguments[from_place]
    elif VECTOR.fullmatch(name):
        size = 4 * count_numbers(name, arguments[1])
    address = arguments[place] if arguments else None
    if not size or not isinstance(address, int) or not address:
        return arguments
    memory = ctypes.create_string_buffer(ctypes.string_at(address, size), size)
    copied = _Address(ctypes.addressof(memory))
    copied.memory = memory
    return (*arguments[:place], copied, *arguments[place + 1 :])


def count_numbers(name: str, count: int) -> int:
    """How many numbers a glUniform…v function takes for so many elements."""
    found = VECTOR.fullmatch(name)
    assert found is not None
    rows = int(found["rows"])
    return count * rows * int(found["columns"] or (rows if found["matrix"] else 1))


# Parameters of textures whose values are constants.
_WORDED = ("_FILTER", "_MODE", "_FUNC", "WRAP_S", "WRAP_T", "WRAP_R")


@contextmanager
def open_recording_device(device: Device, edit: CallEdit | None = None) -> Iterator[Device]:
    """Open a device whose calls are recorded, one perhaps edited, while a scene is drawn on it."""
    with fresh_context(device) as raw:
        recorder = CallRecorder(raw, edit)
        options: Any = {"standalone": True, "context": recorder}  # mistyped in moderngl's stubs
        context = moderngl.create_context(require=REQUIRED_VERSION, **options)
        made = Device(context, device.info, device.driver, recorder)
        with made.in_use():
            yield made


def trace(session: Drawing) -> Sequence[TracedCall]:
    """As `Session.trace`: what was recorded when the scene was drawn, or else it is drawn once
    more, in a separate context."""
    recorder = session.device.recorder
    if recorder is None:
        with open_recording_device(session.device) as device, ExitStack() as stack:
            linker = Linker(device)
            type(session)(linker, session.scene, session.programs, session.size, stack).draw()
            recorder = device.recorder
    assert recorder is not None
    files = _program_files(recorder.calls, session)
    tracker = StateTracker()
    spelt = [(call.place, _describe_call(call, files, tracker)) for call in recorder.calls]
    return [call for place, call in spelt if place is not None]


def _program_files(calls: Sequence[Recorded], session: Drawing) -> dict[str, str]:
    used: dict[PassDraw, int] = {}
    for call in calls:
        pass_name, draw = call.place or ("", None)
        if call.function == "glUseProgram" and call.arguments[0] and draw is not None:
            used[pass_name, draw] = int(call.arguments[0])
    found = {}
    for (name, index), number in used.items():
        file = Path(session.programs[name][index].draw.shaders[-1]).name
        found[f"program {number}"] = f"program {number} ({file})"
    return found


def _describe_call(call: Recorded, files: Mapping[str, str], tracker: StateTracker) -> TracedCall:
    names = prototypes()[call.function].argNames
    arguments = {
        name: format_argument(call.function, name, value)
        for name, value in zip(names, call.arguments, strict=False)
    }
    if makes_objects(call.function) and len(call.arguments) == 2:
        del arguments[names[1]]
    if arguments.get("pname", "").endswith(_WORDED) and arguments.get("param", "").isdigit():
        arguments["param"] = find_constant(call.function, "param", int(arguments["param"]))
    arguments = {name: files.get(word, word) for name, word in arguments.items()}
    made = makes_objects(call.function)
    pass_name, draw = call.place or ("", None)
    before = tracker.state_for(call.function)
    return TracedCall(
        pass_name=pass_name,
        draw=draw,
        function=call.function,
        arguments=arguments,
        returned=", ".join(str(int(n)) for n in np.ravel(call.returned)) if made else "",
        effective=tracker.changes(call.function, arguments),
        state=before,
    )
