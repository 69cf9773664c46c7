"""What an argument of a call is mistaken for: another hint, another mode, a number that is off."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from shaderlab.model.frame import TracedCall

_FILTERS = {
    "GL_NEAREST": ("GL_LINEAR",), "GL_LINEAR": ("GL_NEAREST",),
    "GL_NEAREST_MIPMAP_NEAREST": ("GL_NEAREST_MIPMAP_LINEAR", "GL_NEAREST"),
    "GL_NEAREST_MIPMAP_LINEAR": ("GL_NEAREST_MIPMAP_NEAREST", "GL_NEAREST"),
    "GL_LINEAR_MIPMAP_NEAREST": ("GL_LINEAR_MIPMAP_LINEAR", "GL_LINEAR"),
    "GL_LINEAR_MIPMAP_LINEAR": ("GL_LINEAR_MIPMAP_NEAREST", "GL_LINEAR"),
}  # fmt: skip
_WRAPS = {
    "GL_REPEAT": ("GL_CLAMP_TO_EDGE", "GL_MIRRORED_REPEAT"), "GL_CLAMP_TO_EDGE": ("GL_REPEAT",),
    "GL_MIRRORED_REPEAT": ("GL_REPEAT",), "GL_CLAMP_TO_BORDER": ("GL_CLAMP_TO_EDGE",),
}  # fmt: skip
_PRIMITIVES = {
    "GL_TRIANGLES": ("GL_TRIANGLE_STRIP",), "GL_TRIANGLE_STRIP": ("GL_TRIANGLES",),
    "GL_TRIANGLE_FAN": ("GL_TRIANGLE_STRIP",), "GL_LINES": ("GL_LINE_STRIP",),
    "GL_LINE_STRIP": ("GL_LINES", "GL_LINE_LOOP"), "GL_LINE_LOOP": ("GL_LINE_STRIP",),
    "GL_POINTS": ("GL_LINES",),
}  # fmt: skip
_COMPARISONS = {
    "GL_NEVER": ("GL_ALWAYS",), "GL_ALWAYS": ("GL_NEVER",), "GL_LESS": ("GL_LEQUAL", "GL_GREATER"),
    "GL_LEQUAL": ("GL_LESS",), "GL_GREATER": ("GL_LESS",), "GL_GEQUAL": ("GL_LEQUAL",),
    "GL_EQUAL": ("GL_NOTEQUAL",), "GL_NOTEQUAL": ("GL_EQUAL",),
}  # fmt: skip
_HOW_OFTEN = ("STATIC", "STREAM", "DYNAMIC")
_WHO = ("DRAW", "READ", "COPY")
_USAGES = {
    f"GL_{often}_{who}": (
        f"GL_{_HOW_OFTEN[(i + 1) % 3]}_{who}",
        f"GL_{often}_{_WHO[(k + 1) % 3]}",
    )
    for i, often in enumerate(_HOW_OFTEN)
    for k, who in enumerate(_WHO)
}
# Constants by function and parameter; a function's name may be the beginning of several.
_CONSTANTS: Mapping[tuple[str, str], Mapping[str, tuple[str, ...]]] = {
    ("glBufferData", "usage"): _USAGES,
    ("glDraw", "mode"): _PRIMITIVES,
    ("glDraw", "type"): {
        "GL_UNSIGNED_INT": ("GL_UNSIGNED_SHORT",), "GL_UNSIGNED_SHORT": ("GL_UNSIGNED_BYTE",),
        "GL_UNSIGNED_BYTE": ("GL_UNSIGNED_SHORT",),
    },
    ("glVertexAttribPointer", "type"): {
        "GL_FLOAT": ("GL_INT",), "GL_UNSIGNED_BYTE": ("GL_BYTE",),
    },
    ("glVertexAttribPointer", "normalized"): {"GL_FALSE": ("GL_TRUE",), "GL_TRUE": ("GL_FALSE",)},
    ("glMapBufferRange", "access"): {
        "GL_MAP_WRITE_BIT": ("GL_MAP_READ_BIT",), "GL_MAP_READ_BIT": ("GL_MAP_WRITE_BIT",),
    },
    ("glTexParameteri", "param"): {**_FILTERS, **_WRAPS},
    ("glSamplerParameteri", "param"): {**_FILTERS, **_WRAPS},
    ("glBlitFramebuffer", "filter"): _FILTERS,
    ("glDepthFunc", "func"): _COMPARISONS,
    ("glStencilFunc", "func"): _COMPARISONS,
    ("glCullFace", "mode"): {"GL_BACK": ("GL_FRONT",), "GL_FRONT": ("GL_BACK",)},
    ("glFrontFace", "mode"): {"GL_CCW": ("GL_CW",), "GL_CW": ("GL_CCW",)},
    ("glDepthMask", "flag"): {"GL_TRUE": ("GL_FALSE",), "GL_FALSE": ("GL_TRUE",)},
    ("glBlendEquation", "modeRGB"): {"GL_FUNC_ADD": ("GL_FUNC_SUBTRACT",)},
    ("glBlendFunc", "sfactorRGB"): {"GL_SRC_ALPHA": ("GL_ONE",), "GL_ONE": ("GL_SRC_ALPHA",)},
    ("glBlendFunc", "dfactorRGB"): {"GL_ONE_MINUS_SRC_ALPHA": ("GL_ONE",), "GL_ONE": ("GL_ZERO",)},
    ("glTexImage2D", "internalformat"): {
        "GL_RGBA32F": ("GL_RGBA16F",), "GL_RGBA8": ("GL_SRGB8_ALPHA8",),
        "GL_SRGB8_ALPHA8": ("GL_RGBA8",),
    },
    ("glRenderbufferStorage", "internalformat"): {
        "GL_DEPTH_COMPONENT24": ("GL_DEPTH_COMPONENT16",),
    },
}  # fmt: skip
# Numbers, and by how much they are off.
_NUMBERS: Mapping[tuple[str, str], tuple[int, ...]] = {
    ("glDraw", "count"): (-1,),
    ("glDraw", "first"): (1,),
    ("glDraw", "instancecount"): (-1, 1),
    ("glBufferData", "size"): (-4,),
    ("glBufferSubData", "offset"): (4,),
    ("glBufferSubData", "size"): (-4,),
    ("glMapBufferRange", "length"): (-4,),
    ("glVertexAttribPointer", "size"): (-1,),
    ("glVertexAttribPointer", "stride"): (4,),
    ("glVertexAttribPointer", "pointer"): (-4,),
    ("glVertexAttribDivisor", "divisor"): (1,),
    ("glBindBufferBase", "index"): (1,),
    ("glBindBufferRange", "index"): (1,),
    ("glUniformBlockBinding", "uniformBlockBinding"): (1,),
    ("glViewport", "x"): (1,),
    ("glViewport", "height"): (-1,),
    ("glScissor", "x"): (1,),
    ("glScissor", "height"): (-1,),
    ("glTexImage2DMultisample", "samples"): (-2,),
    ("glRenderbufferStorageMultisample", "samples"): (-2,),
}


def other_arguments(call: TracedCall) -> Iterator[tuple[str, int | str]]:
    """Parameters of a call, each with a number or a constant that is given in place of its own."""
    for (function, parameter), others in _CONSTANTS.items():
        if call.function.startswith(function):
            for word in others.get(call.arguments.get(parameter, ""), ()):
                yield parameter, word
    for (function, parameter), steps in _NUMBERS.items():
        number = call.arguments.get(parameter, "").removeprefix("byte ")
        if call.function.startswith(function) and number.isdigit():
            for step in steps:
                if int(number) + step >= 0:
                    yield parameter, int(number) + step
