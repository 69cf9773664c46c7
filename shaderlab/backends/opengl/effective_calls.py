"""Which calls change something: the lab sets all state for each draw, a program of one's own only
what it needs."""

from __future__ import annotations

from collections.abc import Mapping

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


class StateTracker:
    """Follows a context's state from call to call."""

    def __init__(self) -> None:
        self._state = dict(_INITIAL)

    def changes(self, function: str, arguments: Mapping[str, str]) -> bool:
        """Whether a call changes what the context has, or does something; each call in its turn."""
        if function in ("glEnable", "glDisable"):
            return self._set(("cap", arguments["cap"]), (function,), ("glDisable",))
        for prefix, cap in _WHILE.items():
            if function.startswith(prefix) and self._state.get(("cap", cap)) != ("glEnable",):
                return False
        places = _PLACES.get(function)
        if places is None and function not in _ONE_PLACE:
            return True
        key = (function, *(arguments[name] for name in places or ()))
        return self._set(key, tuple(arguments.values()), None)

    def _set(
        self, key: tuple[str, ...], value: tuple[str, ...], initial: tuple[str, ...] | None
    ) -> bool:
        before = self._state.get(key, initial)
        self._state[key] = value
        return value != before
