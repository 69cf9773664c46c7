"""Mistakes in the calls of OpenGL that drawing a scene makes: one dropped, another argument given,
one repeated for each draw, two in the other order; and whether other calls came to the same."""

import re
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from shaderlab.engine.expectations.gl_call import CallTrace, GlCalls
from shaderlab.engine.run import SceneRunner
from shaderlab.model.calls import CallEdit, ChangeCall, DropCall, PostponeCall, RepeatCall
from shaderlab.model.case import Case, Scene
from shaderlab.model.frame import TracedCall
from shaderlab.mutation.mutants import Effect, Mutant, MutantResult, sample_alike, select_scenes

MOST_ALIKE = 2
"""Of calls that differ in the numbers of their objects alone, so many are tried."""

# What makes objects and programs and takes them down: without it there is nothing to draw.
_MAKING = (
    "glGenBuffers", "glGenFramebuffers", "glGenRenderbuffers", "glGenSamplers", "glGenTextures",
    "glGenVertexArrays", "glCreate", "glDelete", "glShaderSource", "glCompileShader",
    "glAttachShader", "glLinkProgram", "glBindAttribLocation", "glBindFragDataLocation",
)  # fmt: skip
_USED_AT_ONCE = ("glMapBuffer", "glFenceSync")  # the caller goes on with what it gets
_KEPT = (
    "glGenVertexArrays", "glGenBuffers", "glBufferData", "glBufferSubData", "glVertexAttribPointer",
)  # fmt: skip
# Of the functions that get an address, those whose contents can be kept till later.
_KEEPABLE = ("glBufferData", "glBufferSubData", "glUniform")

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
    f"GL_{often}_{who}": (f"GL_{_HOW_OFTEN[(i + 1) % 3]}_{who}", f"GL_{often}_{_WHO[(k + 1) % 3]}")
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


@dataclass(frozen=True, kw_only=True)
class CallMutant(Mutant):
    """One call of a variant's drawing that is made otherwise."""

    variant: str
    edit: CallEdit

    def effect(self, scene: Scene) -> Effect | None:
        if scene.variant != self.variant:
            return None
        passes = frozenset(p.name for p in scene.passes)
        return Effect(scene, passes, passes, edit=self.edit)


def mutate_calls(
    lab: SceneRunner, case: Case, seed: int = 0, variants: Collection[str] = ()
) -> list[CallMutant]:
    """Return the mutants of a case's calls, or of those of some of its variants.

    Where many differ in the numbers of their objects alone, as in a pass for each of many textures,
    a few stand for all. Raises UnsupportedError: the backend records no calls."""
    alike: dict[tuple[str, ...], list[CallMutant]] = {}
    for scene in select_scenes(case, variants):
        programs = lab.prepare_for_opengl(scene)
        with lab.edited_evaluation(scene, programs, None) as evaluation:
            trace: Sequence[TracedCall] = evaluation.answer(CallTrace())
        for call, kind, after, edit in _edits(trace):
            place = call.pass_name if call.draw is None else f"{call.pass_name}[{call.draw}]"
            mutant = CallMutant(
                file=case.file,
                line=0,
                operator=kind,
                before=f"{place} {call}",
                after=after,
                variant=scene.variant,
                edit=edit,
            )
            key = (kind, *map(_without_numbers, (str(call), after)))
            alike.setdefault(key, []).append(mutant)
    return [m for same in sample_alike(alike, MOST_ALIKE, seed) for m in same]


def _edits(trace: Sequence[TracedCall]) -> Iterator[tuple[TracedCall, str, str, CallEdit]]:
    """Each call that can be made otherwise: the mistake's name, what is there instead, the edit."""
    counts: Counter[str] = Counter()
    effective = []
    for call in trace:
        if call.effective:
            effective.append((call, counts[call.function]))
        counts[call.function] += 1
    later = _draws_left(effective)
    for (call, number), draws in zip(effective, later, strict=True):
        name = call.function
        if name.startswith(_KEPT) and draws > 1:
            edit: CallEdit = RepeatCall(function=name, number=number)
            yield call, "call repeated", "again for each later draw of the pass", edit
        if name.startswith(_MAKING):
            continue
        for parameter, value in vary_arguments(call):
            edit = ChangeCall(function=name, number=number, parameter=parameter, value=value)
            yield call, "argument", f"{parameter} = {value}", edit
        if not name.startswith(_USED_AT_ONCE):
            yield call, "call dropped", "nothing", DropCall(function=name, number=number)
    for (call, number), (following, place) in pairwise(effective):
        if call.pass_name == following.pass_name and _can_wait(call) and _can_wait(following):
            behind = (following.function, place)
            edit = PostponeCall(function=call.function, number=number, behind=behind)
            yield call, "calls reordered", f"behind {following}", edit


def vary_arguments(call: TracedCall) -> Iterator[tuple[str, int | str]]:
    """Yield parameters of a call, each with a number or a constant to pass instead of its own."""
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
    if call.function.startswith("glClearBuffer"):
        cleared = set(call.arguments["value"].strip("[]").split())
        yield from (("value", number) for number in (0, 1) if cleared != {str(number)})


def _draws_left(calls: Sequence[tuple[TracedCall, int]]) -> list[int]:
    """For each call, how many draw calls of its pass are still to come."""
    left = Counter(c.pass_name for c, _ in calls if _is_draw(c))
    found = []
    for call, _ in calls:
        left[call.pass_name] -= _is_draw(call)
        found.append(left[call.pass_name])
    return found


def _is_draw(call: TracedCall) -> bool:
    return call.function.startswith(("glDrawArrays", "glDrawElements"))


def _can_wait(call: TracedCall) -> bool:
    pointed = "a pointer" in call.arguments.values() and not call.function.startswith(_KEEPABLE)
    return not call.function.startswith((*_MAKING, *_USED_AT_ONCE)) and not pointed


def _without_numbers(words: str) -> str:
    return re.sub(
        r"(texture|buffer|framebuffer|renderbuffer|array|program|sampler) \d+", r"\1", words
    )


def judge_unseen_call(
    scene: Scene, mutant: Sequence[TracedCall], original: Sequence[TracedCall]
) -> MutantResult:
    """Return what came of a mutant that draws the same pixels, by the calls that were made.

    It is equivalent where each call that does something finds the very state that it found
    before. It has survived where other calls are made of a function that the scene has a
    `gl_calls` for, and all pass.
    """
    if _actions(mutant) == _actions(original):
        return MutantResult("equivalent", "all that is drawn or written finds the same state")
    for expectation in scene.expect:
        if isinstance(expectation, GlCalls) and (
            _count_calls(expectation, mutant) != _count_calls(expectation, original)
        ):
            by = f"in the calls of {scene.variant}: {expectation.function}"
            return MutantResult("survived", by)
    return MutantResult("no difference", "the same pixels, and no gl_calls is about these calls")


def _actions(trace: Sequence[TracedCall]) -> list[tuple[str, str, str]]:
    """Calls that do more than set state, with the state that they find."""
    return [(c.pass_name, str(c), c.state) for c in trace if c.state]


def _count_calls(expectation: GlCalls, trace: Sequence[TracedCall]) -> Counter[str]:
    """The calls that an expectation looks at, whatever their order."""
    return Counter(
        str(call)
        for call in trace
        if call.function == expectation.function and expectation.pass_name in (None, call.pass_name)
    )
