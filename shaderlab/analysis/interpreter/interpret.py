"""The front door: a program and its inputs in, its outputs out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.bands import Truth
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array, Bindings

from .arithmetic import Arithmetic
from .binding import buffers_of, memory_of, outputs_of, undefined_outputs
from .memory import Flags, World
from .program import BARRIER, Program
from .running import BLOCKS, TURNS, Run, Watch
from .stored import Trace
from .values import Missing, Value

_NOTHING = Bindings()


@dataclass(frozen=True, kw_only=True, eq=False)
class Interpreted:
    """What interpreting a program gave.

    Attributes:
        outputs: by name, those that were written; a row for every invocation: floats of the
            arithmetic (count, components), `Integer`s, `Truth`s, tuples of them for arrays. What
            was discarded has rows, too, which mean nothing. Of a geometry stage tuples with what
            each vertex was emitted with, and "EmitVertex()", how many those are; of a compute stage
            what its buffers hold.
        discarded: which invocations were discarded, (count,); undecided where a band is open.
        undecided: by line of the program's text, the invocations that took both sides of a branch.
    """

    outputs: Mapping[str, Any]
    discarded: Truth
    undecided: Mapping[int, Flags]


def interpret(
    program: Program,
    each: Mapping[str, Array],
    bindings: Bindings = _NOTHING,
    arithmetic: Arithmetic | None = None,
    *,
    count: int | None = None,
    places: Array | None = None,
    lanes: int = 1,
    turns: int = TURNS,
    blocks: int = BLOCKS,
    trace: Trace | None = None,
    flow: Trace | None = None,
    watch: Watch | None = None,
    unwritten: bool = False,
) -> Interpreted:
    """Run a stage on many invocations at once.

    Args:
        program: the stage, of `load` or `read`.
        each: what differs between invocations, by name: varyings or attributes, and built-in
            inputs such as "gl_FragCoord" and "gl_VertexID"; (count, components), matrices (count,
            rows, columns), arrays (count, elements, …). A uniform may be given here, too.
            Derivatives, and textures with mipmaps, find a pixel's neighbours by gl_FragCoord.
        bindings: uniforms, members of blocks and textures, as a scene's frame has them.
        arithmetic: `FLOAT32` by default.
        count: the number of invocations; by default that of the rows of `each`, or 1.
        places: where each invocation's pixel is, (count, 2 or more); by default its gl_FragCoord.
        lanes: how many invocations after each other are one workgroup, which share variables.
        turns: how often a loop may turn each time that it is entered.
        blocks: how many blocks may be run in all.
        trace: is called with each value that a variable, or a part of one, is given.
        flow: is called with each argument of a function, and with what each branch is taken by.
        watch: is called after each instruction, and may change its result.
        unwritten: whether outputs hold an undefined value where an invocation writes none.

    Raises:
        NotInterpretedError: the program does what the interpreter does not know, or does not end.
        FormulaError: something that the program reads is not given.
    """
    if arithmetic is None:
        from .numbers import FLOAT32

        arithmetic = FLOAT32
    if count is None:
        count = max((len(values) for values in each.values()), default=1)
    for name, values in each.items():
        if len(values) not in (1, count):
            raise FormulaError(f"{name!r} has {len(values)} rows, others {count}")
    if lanes != program.lanes:
        raise program.not_interpreted("what a workgroup shares", program.line_of(BARRIER))
    places = each.get("gl_FragCoord") if places is None else places
    run = Run(
        program, arithmetic, count,
        places=places, lanes=lanes, turns=turns, blocks=blocks,
        trace=trace, flow=flow, watch=watch,
    )  # fmt: skip
    with np.errstate(all="ignore"):  # what is no number is a result like any other
        memory = memory_of(program, each, bindings, arithmetic)
        if unwritten:
            memory |= undefined_outputs(program, arithmetic)
        for id_, constant in program.module.initialisers.items():
            if isinstance(memory.get(id_), Missing | None):
                memory[id_] = run.value(constant)
        end = run.call(program.main, World(np.ones(count, np.bool_), memory))
    survivors = np.zeros(count, np.bool_) if end is None else end.mask
    return Interpreted(
        outputs={} if end is None else _outputs(run, end.memory),
        discarded=Truth(run.killed & ~survivors, ~run.killed),
        undecided=run.undecided,
    )


def _outputs(run: Run, memory: Mapping[int, Value]) -> Mapping[str, Any]:
    program, count = run.program, run.count
    if program.stage == "compute":
        return buffers_of(program, memory, count)
    if program.stage != "geometry":
        return outputs_of(program, memory, count)
    vertices = [outputs_of(program, held, count) for held in run.emission.memories(run)]
    names = dict.fromkeys(name for vertex in vertices for name in vertex)
    found = {name: tuple(vertex[name] for vertex in vertices) for name in names}
    return found | run.emission.counts(run.arithmetic.rules)
