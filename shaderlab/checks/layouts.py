"""Judging where attributes and block members lie."""

from __future__ import annotations

from collections.abc import Mapping

from shaderlab.checks.judgement import Judgement
from shaderlab.errors import CaseError, nearest
from shaderlab.frame import AttributeReading, BlockReading
from shaderlab.model import AttributeLayout, BlockLayout
from shaderlab.records import Outcome, Row


def judge_attributes(
    expectation: AttributeLayout, readings: Mapping[str, AttributeReading]
) -> Judgement:
    """Compare where OpenGL reads each attribute with where it should."""
    rows = []
    for name, (offset, stride, divisor) in expectation.attributes.items():
        found = readings.get(name)
        got = None if found is None else (found.offset, found.stride, found.divisor)
        rows.append(
            Row(
                label=name,
                expected=_place(offset, stride, divisor),
                measured="not read" if got is None else _place(*got),
                ok=got == (offset, stride, divisor),
                note="" if found is None else f"buffer {found.buffer}",
            )
        )
    return _table(expectation.name, "memory", rows)


def judge_block(expectation: BlockLayout, readings: Mapping[str, BlockReading]) -> Judgement:
    """Compare a block's offsets with the driver's and the lab's.

    Raises:
        CaseError: there is no such block, or it has no such member.
    """
    if expectation.block not in readings:
        raise CaseError(
            f"there is no uniform block {expectation.block!r}",
            remedy=nearest(expectation.block, readings),
        )
    reading = readings[expectation.block]
    rows = []
    for member, offset in expectation.offsets.items():
        if member not in reading.placed:
            raise CaseError(
                f"the block {expectation.block} has no member {member!r}",
                remedy=nearest(member, reading.placed),
            )
        ours, driver = reading.placed[member], reading.offsets.get(member)
        rows.append(
            Row(
                label=f"{expectation.block}.{member}",
                expected=f"byte {offset}",
                measured=f"byte {ours}; driver: {'none' if driver is None else driver}",
                ok=offset == ours == driver,
            )
        )
    if expectation.size is not None:
        rows.append(
            Row(
                label=f"{expectation.block}, whole",
                expected=f"{expectation.size} bytes",
                measured=f"{reading.placed_size} bytes; driver: {reading.size}",
                ok=expectation.size == reading.placed_size <= reading.size,
            )
        )
    return _table(expectation.name, "memory", rows)


def _place(offset: int, stride: int, divisor: int) -> str:
    each = f", a value every {divisor} instances" if divisor > 1 else ", one an instance"
    return f"offset {offset}, stride {stride}{each if divisor else ''}"


def _table(name: str, kind: str, rows: list[Row]) -> Judgement:
    wrong = [row.label for row in rows if not row.ok]
    return Judgement(
        outcome=Outcome(
            name=name,
            kind=kind,
            status="fail" if wrong else "pass",
            message=f"elsewhere than expected: {', '.join(wrong)}" if wrong else "",
            judged=len(rows),
            outside=len(wrong),
            rows=tuple(rows),
        )
    )
