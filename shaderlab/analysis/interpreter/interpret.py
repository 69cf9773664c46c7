"""Inputs by name as a program's variables, and its outputs by name.

Names are those of the driver's interface: "light.constant", "lights[0].position", "weights" for
a whole array, "Block.member" for members of a block that has an instance name, "gl_FragCoord".
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, Rules, TriBool
from shaderlab.compiler.reflection import leaves
from shaderlab.compiler.spirv import Decoration, StorageClass, interface_name as shared_name
from shaderlab.errors import FormulaError
from shaderlab.model.frame import Array, Bindings

from .arithmetic import FLOAT32, Arithmetic
from .flow import meet
from .program import INPUTS, Program, Type
from .running import MAX_BLOCKS, Conflict, Run, Trace, Watch
from .values import NUMBERS, Flags, Missing, PathState, Value, broadcast, component, undefined


def memory_of(
    program: Program, each: Mapping[str, Array], bindings: Bindings, arithmetic: Arithmetic
) -> dict[int, Value]:
    """What the program's global variables hold at first, by id.

    What nothing is given for is `Missing`, which only reading makes an error."""
    rules, index = arithmetic.rules, np.ravel(each.get(NUMBERS[3], ()))
    if program.group > 1 and not (rules and rules.ranges):
        whole = np.tile(np.arange(program.group), len(index) // program.group or 1)
        if rules or not np.array_equal(index, whole):
            own = (v for v, (_, s) in program.variables.items() if s == StorageClass.Workgroup)
            names = ", ".join(map(program.name, own)) or "barrier()"
            raise program.not_interpreted(f"{names}, which a workgroup shares", 0)
    reader = _InputReader(each, bindings, arithmetic)
    memory: dict[int, Value] = {}
    for id_, (type_, storage) in program.variables.items():
        if storage in INPUTS:
            memory[id_] = reader.value(type_, interface_name(program, id_))
    return memory


def outputs_of(program: Program, memory: Mapping[int, Value], count: int) -> dict[str, Any]:
    """Each output that was written, by name, with a row for every invocation."""
    found: dict[str, Any] = {}
    for id_, (pointee, storage) in program.module.variables.items():
        if storage != StorageClass.Output or memory.get(id_) is None:
            continue
        for leaf in leaves(program.module, pointee, interface_name(program, id_)):
            value = memory[id_]
            for index in leaf.path:
                value = None if value is None else component(value, index)
            if value is not None and not isinstance(value, Missing):
                found[leaf.name] = broadcast(value, count)
    return found


def buffers_of(program: Program, memory: Mapping[int, Value], count: int) -> dict[str, Any]:
    """What each storage buffer that a program may write to holds, by name, with a row for every
    invocation: that of its own stores."""
    found: dict[str, Any] = {}
    for id_, (pointee, storage) in program.module.variables.items():
        if is_buffer(program, id_) and storage in INPUTS:
            value, type_ = memory[id_], program.types[pointee]
            name = interface_name(program, id_)
            for (member, _), part in zip(type_.members, value, strict=True):
                if not _is_missing(part):
                    found[f"{name}.{member}" if name else member] = broadcast(part, count)
    return found


def is_buffer(program: Program, id_: int) -> bool:
    """Whether a variable is a storage buffer."""
    pointee, storage = program.module.variables[id_]
    kind = program.module.decorated(pointee, Decoration.BufferBlock)
    return storage == StorageClass.StorageBuffer or kind is not None


def _is_missing(value: Value) -> bool:
    if isinstance(value, tuple):
        return not value or any(map(_is_missing, value))
    return isinstance(value, Missing)


def interface_name(program: Program, id_: int) -> str:
    """What a variable's parts are called by: a block's own name, which counts only where it has
    an instance name; else the variable's."""
    name = program.name(id_)
    return shared_name(program.module, id_) if name and id_ in program.module.variables else name


@dataclass(frozen=True, eq=False)
class _InputReader:
    """Finds values by name and turns them into an arithmetic's."""

    _each: Mapping[str, Array]
    _bindings: Bindings
    _arithmetic: Arithmetic

    def value(self, type_: Type, name: str) -> Value:
        """The value of a name, put together of its parts where only those are given."""
        if type_.kind == "sampler":
            return None  # its texture is all that is read
        if type_.kind == "image":
            return self._bindings.textures.get(name, Missing(name))
        if name in self._each:
            return self._leaf(type_, np.asarray(self._each[name]))
        if name in self._bindings.uniforms:
            return self._leaf(type_, np.asarray(self._bindings.uniforms[name])[None])
        if type_.kind == "struct":
            return tuple(
                self.value(part, f"{name}.{member}" if name else member)
                for member, part in type_.members
            )
        if type_.kind == "array":
            assert type_.of is not None
            return tuple(self.value(type_.of, f"{name}[{i}]") for i in self._range(type_, name))
        return Missing(name)

    def _range(self, type_: Type, name: str) -> Iterator[int]:
        """The elements of an array; those that are given, of one whose length is not declared."""
        if type_.count:
            yield from range(type_.count)
            return
        given = [*self._each, *self._bindings.uniforms]
        i = 0
        while any(n == f"{name}[{i}]" or n.startswith(f"{name}[{i}].") for n in given):
            yield i
            i += 1

    def _leaf(self, type_: Type, values: Array) -> Value:
        """An array whose first axis counts the invocations (or is 1), as a value."""
        if type_.kind == "array":
            assert type_.of is not None
            return tuple(self._leaf(type_.of, values[:, i]) for i in range(values.shape[1]))
        if type_.kind != "matrix":
            values = values.reshape(values.shape[0], -1)
        if np.iscomplexobj(values):
            return self._range_of(type_.base, values.real, values.imag)
        if type_.base.kind == "float":
            return self._arithmetic.exact(values)
        if type_.base.kind == "bool":
            return TriBool.of(values != 0)
        unsigned = not type_.base.signed
        return Integer(values, unsigned=unsigned, rules=self._arithmetic.rules)

    def _range_of(self, base: Type, low: Array, high: Array) -> Value:
        rules = self._arithmetic.rules
        if base.kind == "float":
            return Band.between(low, high, rules or Rules())
        if base.kind == "bool":
            return TriBool(low > 0.0, high <= 0.0, rules)
        return Integer(low, high, unsigned=not base.signed, rules=rules)


_NOTHING = Bindings()


@dataclass(frozen=True, kw_only=True, eq=False)
class Interpreted:
    """What interpreting a program gave.

    Attributes:
        outputs: by name, those that were written; a row for every invocation: floats of the
            arithmetic (count, components), `Integer`s, `TriBool`s, tuples of them for arrays. What
            was discarded has rows, too, which mean nothing. Of a compute stage what its buffers
            hold; of images what is stored, and where ("NAME at").
        discarded: which invocations were discarded, (count,); undecided where a band is open.
        undecided: by line of the program's text, the invocations that took both sides of a branch.
        taken: each two blocks, by their labels, of which an invocation came to one after the other;
            0 comes before a function's first.
        blocks: how many blocks were run.
        conflicts: the invocations to which others of their workgroup do what GLSL does not define.
    """

    outputs: Mapping[str, Any]
    discarded: TriBool
    undecided: Mapping[int, Flags]
    taken: Set[tuple[int, int]] = frozenset()
    blocks: int = 0
    conflicts: Mapping[Conflict, Flags]


def interpret(
    program: Program, each: Mapping[str, Array], bindings: Bindings = _NOTHING,
    arithmetic: Arithmetic = FLOAT32, *, count: int | None = None, places: Array | None = None,
    max_blocks: int = MAX_BLOCKS, trace: Trace | None = None, watch: Watch | None = None,
    unwritten: bool = False,
) -> Interpreted:  # fmt: skip
    """Run a stage on many invocations at once.

    Args:
        each: what differs between invocations, by name: varyings or attributes, built-in inputs
            such as "gl_FragCoord", uniforms; (count, components), matrices (count, rows, columns),
            arrays (count, elements, …); a first axis of 1 is for all. In bands a complex number is
            a range, from its real to its imaginary part.
        bindings: uniforms, members of blocks and textures, as a scene's frame has them.
        count: the number of invocations; by default that of the rows of `each`, or 1.
        places: the pixels, by which derivatives and mipmaps find neighbours, (count, 2 or more); by
            default gl_FragCoord.
        trace: is called with each value that a variable or a part of one is given.
        watch: is called after each instruction, and may change its result.
        unwritten: whether outputs hold an undefined value where an invocation writes none.

    Raises NotInterpretedError: the program does what the interpreter does not know, or does not
    end; FormulaError: something that the program reads is not given."""
    count = max(map(len, each.values()), default=1) if count is None else count
    for name, values in each.items():
        if len(values) not in (1, count):
            raise FormulaError(f"{name!r} has {len(values)} rows, others {count}")
    run = Run(
        program,
        arithmetic,
        count,
        places=each.get("gl_FragCoord") if places is None else places,
        max_blocks=max_blocks,
        trace=trace,
        watch=watch,
    )
    # What is no number is a result like any other.
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        return _run(run, memory_of(program, each, bindings, arithmetic), unwritten)


def _run(run: Run, memory: dict[int, Value], unwritten: bool) -> Interpreted:
    program, count = run.program, run.count
    run.given = dict(memory)
    shared = StorageClass.Workgroup
    kinds = [shared, *[StorageClass.Output] * unwritten, *[StorageClass.Private] * run.for_ranges]
    for id_, (type_, storage) in program.variables.items():
        if storage in kinds:
            memory[id_] = undefined(type_, run.arithmetic)
    for id_, constant in program.module.initialisers.items():
        if program.variables[id_][1] in kinds or isinstance(memory.get(id_), Missing | None):
            memory[id_] = run.value(constant)
    run.shared = {v: memory[v] for v, (_, kind) in program.variables.items() if kind == shared}
    end = run.call(program.main, PathState(np.ones(count, np.bool_), memory))
    if end is not None and run.shared:
        meet(run, None, end)
    survivors = np.zeros(count, np.bool_) if end is None else end.mask
    find_outputs = buffers_of if program.stage == "compute" else outputs_of
    outputs = {} if end is None else find_outputs(program, end.memory, count)
    for name, stores in run.texels.items():
        outputs[name] = tuple(broadcast(value, count) for _, _, value in stores)
        outputs[f"{name} at"] = tuple(broadcast(place, count) for _, place, _ in stores)
    return Interpreted(
        outputs=outputs,
        discarded=TriBool(run.killed & ~survivors, ~run.killed),
        undecided=run.undecided,
        taken=run.taken,
        blocks=run.blocks,
        conflicts=run.conflicts,
    )
