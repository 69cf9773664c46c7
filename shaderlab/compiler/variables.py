"""A module's inputs, outputs and uniforms outside blocks, flattened to GLSL's names for them."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from shaderlab.compiler.interface import Interpolation, Variable
from shaderlab.compiler.module import Decoration, Instruction, Module, Op, Storage
from shaderlab.compiler.types import component_count, image_format, slots, type_name, unwrap

Path = tuple[int, ...]
"""Indices from a variable to a part of it; `ANY` if computed at run time."""

ANY = -1


@dataclass(frozen=True)
class Leaf:
    """A part of a variable that has a GLSL name: its type, and the path to it."""

    name: str
    type: int
    path: Path


def stage_variables(module: Module, storage: int) -> Iterator[Variable]:
    """A stage's inputs or outputs, flattened, without built-ins."""
    paths = used_paths(module)
    for id_ in own_variables(module, storage):
        pointee, _ = module.variables[id_]
        lengths, element = unwrap(module, pointee)
        is_block = module.decorated(element, Decoration.BLOCK) is not None
        name = module.names.get(id_, "")
        if is_block:
            name = module.names.get(element, "") if name else ""
        at = module.number(id_, Decoration.LOCATION)
        for leaf in leaves(module, pointee, name):
            member = leaf.path[len(lengths)] if is_block else None
            own = {} if member is None else module.member(element, member)
            location = own[Decoration.LOCATION][0] if Decoration.LOCATION in own else at
            decorations = {**module.decorations.get(id_, {}), **own}
            yield _variable(module, leaf, location, paths.get(id_, ()), decorations)
            if at is not None and location is not None:
                at = location + slots(module, leaf.type)


def leaves(module: Module, type_: int, name: str, path: Path = ()) -> Iterator[Leaf]:
    """The parts of a variable that have names, in declaration order."""
    lengths, element = unwrap(module, type_)
    is_struct = module.types[element].op == Op.TYPE_STRUCT
    if len(lengths) > 1 or (lengths and is_struct):
        inner = module.types[type_].words[0]
        for index in range(max(lengths[0], 1)):
            yield from leaves(module, inner, f"{name}[{index}]", (*path, index))
    elif is_struct:
        for index, member in enumerate(module.types[element].words):
            own = module.member_names.get((element, index), f"_{index}")
            full = f"{name}.{own}" if name else own
            yield from leaves(module, member, full, (*path, index))
    else:
        yield Leaf(name, type_, path)


def own_variables(module: Module, storage: int) -> Iterator[int]:
    """The ids of a storage class's variables, without built-ins."""
    for id_, (pointee, its) in module.variables.items():
        if its != storage or module.decorated(id_, Decoration.BUILT_IN) is not None:
            continue
        element = unwrap(module, pointee)[1]
        if Decoration.BUILT_IN in module.member(element, 0):
            continue  # gl_PerVertex
        if not module.names.get(id_, "").startswith("gl_"):
            yield id_


def _variable(
    module: Module,
    leaf: Leaf,
    location: int | None,
    paths: Iterable[Path],
    decorations: Mapping[int, tuple[int, ...]],
) -> Variable:
    lengths, element = unwrap(module, leaf.type)
    interpolation: Interpolation = "smooth"
    if Decoration.FLAT in decorations:
        interpolation = "flat"
    elif Decoration.NO_PERSPECTIVE in decorations:
        interpolation = "noperspective"
    return Variable(
        name=leaf.name,
        type=type_name(module, element),
        location=location,
        array=lengths[0] if lengths else None,
        interpolation=interpolation,
        components=component_count(module, element),
        used=is_used(paths, leaf.path),
        patch=Decoration.PATCH in decorations,
    )


def uniform_variables(module: Module) -> Iterator[Variable]:
    """The uniforms outside blocks, flattened; includes atomic counters."""
    paths = used_paths(module)
    for storage in (Storage.UNIFORM_CONSTANT, Storage.ATOMIC_COUNTER):
        for id_ in own_variables(module, storage):
            pointee, _ = module.variables[id_]
            at = module.number(id_, Decoration.LOCATION)
            for leaf in leaves(module, pointee, module.names.get(id_, "")):
                variable = _variable(module, leaf, at, paths.get(id_, ()), {})
                if "image" in variable.type:
                    fixed = module.decorated(id_, Decoration.NON_WRITABLE) is not None
                    word = image_format(module, leaf.type)
                    variable = replace(variable, format=word, readonly=fixed)
                if storage == Storage.ATOMIC_COUNTER:
                    variable = replace(variable, type="atomic_uint", location=None)
                yield variable
                if at is not None:
                    at += max(unwrap(module, leaf.type)[0] or (1,))


@functools.lru_cache(maxsize=8)  # called once for each storage class
def used_paths(module: Module) -> Mapping[int, set[Path]]:
    """The paths by which a module's functions refer to each variable."""
    paths: dict[int, set[Path]] = {}
    chains: dict[int, tuple[int, Path]] = {}
    for instruction in module.body:
        if instruction.op in (Op.ACCESS_CHAIN, Op.IN_BOUNDS_ACCESS_CHAIN):
            _, result, base, *indices = instruction.words
            variable, start = chains.get(base, (base, ()))
            steps = tuple(module.constants.get(index, ANY) for index in indices)
            chains[result] = (variable, (*start, *steps))
            continue
        for pointer in _pointers(instruction):
            variable, path = chains.get(pointer, (pointer, ()))
            if variable in module.variables:
                paths.setdefault(variable, set()).add(path)
    return paths


def is_used(paths: Iterable[Path], part: Path) -> bool:
    """Whether one of the paths leads to the part, into it, or to something that contains it."""
    return any(all(a in (ANY, b) for a, b in zip(path, part, strict=False)) for path in paths)


def _pointers(instruction: Instruction) -> tuple[int, ...]:
    """The operands that an instruction may read or write memory through."""
    op, words = instruction.op, instruction.words
    if op in (Op.LOAD, Op.TEXEL_POINTER, Op.COPY, Op.ARRAY_LENGTH):
        return words[2:3]
    if op in (Op.STORE, Op.ATOMIC_STORE):
        return words[:1]
    if op == Op.COPY_MEMORY:
        return words[:2]
    if op == Op.FUNCTION_CALL:
        return words[3:]
    if op == Op.EXTENDED:
        return words[4:]
    if Op.ATOMIC_FIRST <= op <= Op.ATOMIC_LAST:
        return words[2:3]
    return ()
