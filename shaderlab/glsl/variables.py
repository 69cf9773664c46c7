"""Inputs, outputs and loose uniforms out of a module, flattened to the names GLSL has for them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from shaderlab.glsl.interface import Interpolation, Variable
from shaderlab.glsl.module import Decoration, Module, Storage
from shaderlab.glsl.types import component_count, is_struct, slots, type_name, unwrap
from shaderlab.glsl.uses import Path, is_used, used_paths


@dataclass(frozen=True)
class Leaf:
    """A part of a variable that GLSL names on its own: its type, and the way to it."""

    name: str
    type: int
    path: Path


def stage_variables(module: Module, storage: int) -> Iterator[Variable]:
    """The inputs or outputs of a stage, flattened, built-ins left out."""
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
            yield _variable(
                module,
                leaf,
                location=location,
                interpolation=_interpolation({**module.decorations.get(id_, {}), **own}),
                used=is_used(paths.get(id_, ()), leaf.path),
            )
            at = None if at is None else _after(location, slots(module, leaf.type))


def leaves(module: Module, type_: int, name: str, path: Path = ()) -> Iterator[Leaf]:
    """The parts of a variable that have names of their own, in declaration order."""
    lengths, element = unwrap(module, type_)
    if is_struct(module, type_):
        if lengths:
            for index in range(max(lengths[0], 1)):
                inner = module.types[type_].words[0]
                yield from leaves(module, inner, f"{name}[{index}]", (*path, index))
        else:
            for index, member in enumerate(module.types[element].words):
                own = module.member_names.get((element, index), f"_{index}")
                full = f"{name}.{own}" if name else own
                yield from leaves(module, member, full, (*path, index))
    elif len(lengths) > 1:
        for index in range(max(lengths[0], 1)):
            inner = module.types[type_].words[0]
            yield from leaves(module, inner, f"{name}[{index}]", (*path, index))
    else:
        yield Leaf(name, type_, path)


def _after(location: int | None, count: int) -> int | None:
    """The location that follows `count` locations from this one."""
    return None if location is None else location + count


def own_variables(module: Module, storage: int) -> Iterator[int]:
    """The variables of a storage class that are the author's own."""
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
    *,
    location: int | None,
    interpolation: Interpolation = "smooth",
    used: bool,
) -> Variable:
    lengths, element = unwrap(module, leaf.type)
    return Variable(
        name=leaf.name,
        type=type_name(module, element),
        location=location,
        array=lengths[0] if lengths else None,
        interpolation=interpolation,
        components=component_count(module, element),
        used=used,
    )


def _interpolation(decorations: Mapping[int, tuple[int, ...]]) -> Interpolation:
    if Decoration.FLAT in decorations:
        return "flat"
    return "noperspective" if Decoration.NO_PERSPECTIVE in decorations else "smooth"


def uniform_variables(module: Module) -> Iterator[Variable]:
    """The uniforms outside blocks, flattened, atomic counters among them."""
    paths = used_paths(module)
    for storage in (Storage.UNIFORM_CONSTANT, Storage.ATOMIC_COUNTER):
        for id_ in own_variables(module, storage):
            pointee, _ = module.variables[id_]
            at = module.number(id_, Decoration.LOCATION)
            for leaf in leaves(module, pointee, module.names.get(id_, "")):
                used = is_used(paths.get(id_, ()), leaf.path)
                variable = _variable(module, leaf, location=at, used=used)
                if storage == Storage.ATOMIC_COUNTER:
                    variable = replace(variable, type="atomic_uint", location=None)
                yield variable
                at = _after(at, max(unwrap(module, leaf.type)[0] or (1,)))
