"""Which calls change something: the lab sets all state for each draw, a program of one's own only
what it needs."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cache

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
        """All state that a call finds which counts for it, as a digest; "" for a call that only
        sets state."""
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
        tests = _tests(function)
        return bool(tests) and any(self._state.get(("cap", t)) != ("glEnable",) for t in tests)

    def _place(self, function: str, arguments: Mapping[str, str]) -> tuple[str, ...]:
        """What a call of this function sets."""
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
def _tests(function: str) -> tuple[str, ...]:
    """The tests without which what a function sets does not count."""
    return tuple(cap for prefix, cap in _WHILE.items() if function.startswith(prefix))


def _only_sets(function: str) -> bool:
    """Whether the call sets state and does nothing else."""
    return function in _PLACES or function in _ONE_PLACE
