"""What compiling gave, as bytes that anybody may read: JSON, then the modules, deflated.

Unpacking builds plain data and nothing else; bytes that are not such a package are a ValueError.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from shaderlab.glsl.interface import Block, Interface, Member, SpecConstant, Variable
from shaderlab.records import Diagnostic, Verdict

_LENGTH = 8
_LARGEST = 64 << 20  # bytes, of what a small package may grow to
_VARIABLES = ("attributes", "varyings", "vertex_outputs", "outputs", "uniforms")


@dataclass(frozen=True)
class Package:
    """The parts of a `Compiled` that are data; its `interface` too, where that is known."""

    verdicts: tuple[Verdict, ...]
    spirv: Mapping[str, Mapping[str, bytes]]
    logs: Mapping[str, str]
    interface: Interface | None = None


def packed(package: Package) -> bytes:
    """The package as bytes."""
    modules = [
        (target, stage, module)
        for target, stages in package.spirv.items()
        for stage, module in stages.items()
    ]
    told = {
        "verdicts": [_verdict_told(verdict) for verdict in package.verdicts],
        "modules": [(target, stage, len(module)) for target, stage, module in modules],
        "logs": dict(package.logs),
        "interface": _interface_told(package.interface),
    }
    head = json.dumps(told, separators=(",", ":")).encode("ascii")
    parts = [len(head).to_bytes(_LENGTH, "little"), head, *(module for _, _, module in modules)]
    return zlib.compress(b"".join(parts), 1)


def unpacked(data: bytes) -> Package:
    """The package again.

    Raises:
        ValueError: the bytes are none.
    """
    try:
        return _unpacked(_inflated(data))
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError) as error:
        raise ValueError(f"no compiled program: {error}") from error


def _inflated(data: bytes) -> bytes:
    inflating = zlib.decompressobj()
    try:
        whole = inflating.decompress(data, _LARGEST)
    except zlib.error as error:
        raise ValueError(f"no compiled program: {error}") from error
    if not inflating.eof:
        raise ValueError("no compiled program: cut short, or too large")
    return whole


def _unpacked(whole: bytes) -> Package:
    end = _LENGTH + int.from_bytes(whole[:_LENGTH], "little")
    told = json.loads(whole[_LENGTH:end])
    return Package(
        verdicts=tuple(map(_verdict, told["verdicts"])),
        spirv=_modules(told["modules"], whole[end:]),
        logs=told["logs"],
        interface=_interface(told["interface"]),
    )


def _modules(told: Iterable[Sequence[Any]], data: bytes) -> dict[str, dict[str, bytes]]:
    found: dict[str, dict[str, bytes]] = {}
    at = 0
    for target, stage, length in told:
        found.setdefault(target, {})[stage] = data[at : at + length]
        at += length
    if at != len(data):
        raise ValueError(f"no compiled program: {len(data)} bytes of modules, not {at}")
    return found


def _verdict_told(verdict: Verdict) -> Mapping[str, Any]:
    return {**vars(verdict), "diagnostics": [vars(said) for said in verdict.diagnostics]}


def _verdict(told: Mapping[str, Any]) -> Verdict:
    said = tuple(Diagnostic(**one) for one in told["diagnostics"])
    return Verdict(**{**told, "diagnostics": said})


def _interface_told(interface: Interface | None) -> Mapping[str, Any] | None:
    if interface is None:
        return None
    blocks = [
        {**vars(block), "members": [vars(member) for member in block.members.values()]}
        for block in interface.blocks.values()
    ]
    return {
        **{kind: [vars(v) for v in getattr(interface, kind).values()] for kind in _VARIABLES},
        "blocks": blocks,
        "constants": [vars(constant) for constant in interface.constants.values()],
        "local_size": interface.local_size,
    }


def _interface(told: Mapping[str, Any] | None) -> Interface | None:
    if told is None:
        return None
    size = told["local_size"]
    return Interface(
        **{kind: _named(Variable(**one) for one in told[kind]) for kind in _VARIABLES},
        blocks=_named(map(_block, told["blocks"])),
        constants=_named(SpecConstant(**one) for one in told["constants"]),
        local_size=None if size is None else (size[0], size[1], size[2]),
    )


def _block(told: Mapping[str, Any]) -> Block:
    members = _named(Member(**one) for one in told["members"])
    return Block(**{**told, "members": members})


def _named(things: Iterable[Any]) -> dict[str, Any]:
    return {thing.name: thing for thing in things}
