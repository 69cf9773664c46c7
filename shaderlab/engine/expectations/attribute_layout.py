"""attribute_layout: where OpenGL reads each attribute of a mesh."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass

from shaderlab.errors import CaseError
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs
from shaderlab.model.frame import Frame
from shaderlab.model.records import Row

from .base import Asked, OfDraw, judge_rows


@dataclass(frozen=True)
class AttributeLayout(OfDraw):
    """OpenGL reads each attribute at (offset, stride) or (offset, stride, divisor), in bytes.

    It is asked for GL_VERTEX_ATTRIB_ARRAY_POINTER, _STRIDE and _DIVISOR; a matrix is read where
    its first column is.

    Raises:
        CaseError: an entry has neither two nor three numbers.
    """

    kind = "memory"

    attributes: Mapping[str, Sequence[int]]
    _: KW_ONLY
    name: str = "memory layout"

    def __post_init__(self) -> None:
        for attribute, entry in self.attributes.items():
            if len(entry) not in (2, 3):
                raise CaseError(
                    f"attribute_layout: {attribute!r} takes (offset, stride) or "
                    f"(offset, stride, divisor), not {entry!r}"
                )

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield Asked("attributes", (self.key(scene),))

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        readings = frame.answers[Asked("attributes", (self.key(scene),))]
        rows = []
        for name, entry in self.attributes.items():
            place = (*entry, 0)[:3]
            found = readings.get(name)
            got = None if found is None else (found.offset, found.stride, found.divisor)
            rows.append(
                Row(
                    label=name,
                    expected=_spelt(*place),
                    measured="not read" if got is None else _spelt(*got),
                    ok=got == place,
                    note="" if found is None else f"buffer {found.buffer}",
                )
            )
        return memory_table(self.name, rows)


def memory_table(name: str, rows: Sequence[Row]) -> Judgement:
    """A judgement of where things lie; it fails where one lies elsewhere."""
    wrong = [row.label for row in rows if not row.ok]
    message = f"elsewhere than expected: {', '.join(wrong)}" if wrong else ""
    return judge_rows(name, "memory", rows, message, judged=len(rows))


def _spelt(offset: int, stride: int, divisor: int) -> str:
    each = f", a value every {divisor} instances" if divisor > 1 else ", one an instance"
    return f"offset {offset}, stride {stride}{each if divisor else ''}"


attribute_layout = AttributeLayout
