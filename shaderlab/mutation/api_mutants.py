"""Mistakes in the calls of OpenGL that drawing a scene takes: one dropped, another argument given,
one made again for each draw, two in the other order."""

from __future__ import annotations

import random
import re
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from shaderlab.engine.expectations.gl_calls import Traced
from shaderlab.engine.lab import Lab
from shaderlab.model.calls import CallEdit, Changed, Dropped, PutOff, Repeated
from shaderlab.model.case import Case, Scene
from shaderlab.model.frame import TracedCall
from shaderlab.mutation.call_arguments import other_arguments
from shaderlab.mutation.mutants import Effect, Mutant
from shaderlab.mutation.subjects import scenes_of

MOST_ALIKE = 2  # of calls that differ in the numbers of their objects alone, so many are tried

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


@dataclass(frozen=True, kw_only=True)
class ApiMutant(Mutant):
    """One call of a variant's drawing that is made otherwise."""

    variant: str
    edit: CallEdit

    def effect(self, scene: Scene) -> Effect | None:
        if scene.variant != self.variant:
            return None
        passes = frozenset(p.name for p in scene.passes)
        return Effect(scene, passes, passes, edit=self.edit)


def api_mutants(
    lab: Lab, case: Case, seed: int = 0, variants: Collection[str] = ()
) -> list[ApiMutant]:
    """The mutants of a case's calls, or of those of some of its variants. Where many differ in the
    numbers of their objects alone, as in a pass for each of many textures, a few stand for all.

    Raises:
        UnsupportedError: the backend records no calls.
    """
    alike: dict[tuple[str, ...], list[ApiMutant]] = {}
    for scene in scenes_of(case, variants):
        programs = lab.prepare_for_opengl(scene)
        with lab.edited_evaluation(scene, programs, None) as evaluation:
            trace: Sequence[TracedCall] = evaluation.answer(Traced())
        for call, kind, after, edit in _edits(trace):
            place = call.pass_name if call.draw is None else f"{call.pass_name}[{call.draw}]"
            mutant = ApiMutant(
                file=case.file,
                line=0,
                operator=kind,
                before=f"{place} {call}",
                after=after,
                variant=scene.variant,
                edit=edit,
            )
            key = (kind, *map(_unnumbered, (str(call), after)))
            alike.setdefault(key, []).append(mutant)
    chosen: list[ApiMutant] = []
    for key, same in alike.items():
        chosen += random.Random(f"{seed}{key}").sample(same, min(MOST_ALIKE, len(same)))
    return chosen


def _edits(trace: Sequence[TracedCall]) -> Iterator[tuple[TracedCall, str, str, CallEdit]]:
    """Each call that can be made otherwise: the mistake's name, what is there instead, the edit."""
    numbers = _numbers(trace)
    effective = [(c, n) for c, n in zip(trace, numbers, strict=True) if c.effective]
    later = _draws_left(effective)
    for (call, number), draws in zip(effective, later, strict=True):
        name = call.function
        if name.startswith(_KEPT) and draws > 1:
            edit: CallEdit = Repeated(function=name, number=number)
            yield call, "call repeated", "again for each later draw of the pass", edit
        if name.startswith(_MAKING):
            continue
        for parameter, value in other_arguments(call):
            edit = Changed(function=name, number=number, parameter=parameter, value=value)
            yield call, "argument", f"{parameter} = {value}", edit
        if not name.startswith(_USED_AT_ONCE):
            yield call, "call dropped", "nothing", Dropped(function=name, number=number)
    for (call, number), (following, place) in pairwise(effective):
        if call.pass_name == following.pass_name and _can_wait(call) and _can_wait(following):
            behind = (following.function, place)
            edit = PutOff(function=call.function, number=number, behind=behind)
            yield call, "calls reordered", f"behind {following}", edit


def _numbers(trace: Sequence[TracedCall]) -> list[int]:
    """Which one of its function each call is."""
    counts: Counter[str] = Counter()
    found = []
    for call in trace:
        found.append(counts[call.function])
        counts[call.function] += 1
    return found


def _draws_left(calls: Sequence[tuple[TracedCall, int]]) -> list[int]:
    """For each call, how many draw calls of its pass are still to come."""
    left = Counter(c.pass_name for c, _ in calls if _draws(c))
    found = []
    for call, _ in calls:
        left[call.pass_name] -= _draws(call)
        found.append(left[call.pass_name])
    return found


def _draws(call: TracedCall) -> bool:
    return call.function.startswith(("glDrawArrays", "glDrawElements"))


def _can_wait(call: TracedCall) -> bool:
    """Whether a call can change places with another one."""
    pointed = "a pointer" in call.arguments.values() and not call.function.startswith(_KEEPABLE)
    return not call.function.startswith((*_MAKING, *_USED_AT_ONCE)) and not pointed


def _unnumbered(words: str) -> str:
    """A call without the numbers of its objects."""
    return re.sub(
        r"(texture|buffer|framebuffer|renderbuffer|array|program|sampler) \d+", r"\1", words
    )
