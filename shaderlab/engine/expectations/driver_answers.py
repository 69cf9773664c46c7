"""What the driver says of one draw: layouts, counters, errors, inactive uniforms, and pixels."""

from abc import abstractmethod
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import ClassVar, Generic

import numpy as np

from shaderlab.errors import CaseError, suggest
from shaderlab.model.calls import COUNTERS, GL_ERRORS, error_name
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs, Read
from shaderlab.model.frame import Answer, AttributeReading, BlockReading, Frame, PassDraw
from shaderlab.model.records import Row
from shaderlab.model.state import check_choice

from .base import DrawExpectation, SessionQuery
from .needs import CapturedFragments


@dataclass(frozen=True, kw_only=True)
class DriverAnswer(DrawExpectation, Generic[Answer]):
    """An expectation of what the session answers to one query about a draw."""

    query_name: ClassVar[str]
    query_arguments: ClassVar[tuple[str, ...]] = ()

    def query(self, scene: Scene) -> SessionQuery[Answer]:
        """The query: its name, the draw, and further arguments, which are fields."""
        arguments: list[Hashable] = [getattr(self, name) for name in self.query_arguments]
        return SessionQuery(self.query_name, (self.key(scene), *arguments))

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield self.query(scene)

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        rows, message = self.compare(frame.answer(self.query(scene)))
        return self.judge_rows(rows, message, judged=len(rows))

    @abstractmethod
    def compare(self, answer: Answer) -> tuple[list[Row], str]:
        """Compare the answer with what is expected; return a table, and what is wrong or ""."""


@dataclass(frozen=True)
class AttributeLayout(DriverAnswer[Mapping[str, AttributeReading]]):
    """OpenGL reads each attribute at (offset, stride) or (offset, stride, divisor), in bytes.

    OpenGL is asked for GL_VERTEX_ATTRIB_ARRAY_POINTER, _STRIDE and _DIVISOR; a matrix is read where
    its first column is. Raises CaseError: an entry has neither two nor three numbers."""

    kind = "memory"
    named = "memory layout"
    query_name = "attributes"

    attributes: Mapping[str, Sequence[int]]

    def __post_init__(self) -> None:
        for attribute, entry in self.attributes.items():
            if len(entry) not in (2, 3):
                raise CaseError(
                    f"attribute_layout: {attribute!r} takes (offset, stride) or "
                    f"(offset, stride, divisor), not {entry!r}"
                )

    def compare(self, answer: Mapping[str, AttributeReading]) -> tuple[list[Row], str]:
        rows = []
        for name, entry in self.attributes.items():
            place = (*entry, 0)[:3]
            found = answer.get(name)
            got = None if found is None else (found.offset, found.stride, found.divisor)
            rows.append(
                Row(
                    label=name,
                    expected=_format_layout(*place),
                    measured="not read" if got is None else _format_layout(*got),
                    ok=got == place,
                    note="" if found is None else f"buffer {found.buffer}",
                )
            )
        return rows, _list_wrong("elsewhere than expected", rows)


@dataclass(frozen=True)
class BlockLayout(DriverAnswer[Mapping[str, BlockReading]]):
    """The members of a uniform block lie at these offsets, and it takes `size` bytes.

    Members are named as in `UniformBuffer`. Both the lab's layout and the driver's are judged;
    drivers may say that a block is larger than it need be, but not that it is smaller.
    """

    kind = "memory"
    named = "layout of {self.block}"
    query_name = "blocks"

    block: str
    offsets: Mapping[str, int]
    _: KW_ONLY
    size: int | None = None

    def compare(self, answer: Mapping[str, BlockReading]) -> tuple[list[Row], str]:
        if self.block not in answer:
            raise CaseError(
                f"there is no uniform block {self.block!r}", remedy=suggest(self.block, answer)
            )
        reading = answer[self.block]
        rows = []
        for member, offset in self.offsets.items():
            if member not in reading.placed:
                raise CaseError(
                    f"the block {self.block} has no member {member!r}",
                    remedy=suggest(member, reading.placed),
                )
            ours, driver = reading.placed[member], reading.offsets.get(member)
            rows.append(
                Row(
                    label=f"{self.block}.{member}",
                    expected=f"byte {offset}",
                    measured=f"byte {ours}; driver: {'none' if driver is None else driver}",
                    ok=offset == ours == driver,
                )
            )
        if self.size is not None:
            rows.append(
                Row(
                    label=f"{self.block}, whole",
                    expected=f"{self.size} bytes",
                    measured=f"{reading.placed_size} bytes; driver: {reading.size}",
                    ok=self.size == reading.placed_size <= reading.size,
                )
            )
        return rows, _list_wrong("elsewhere than expected", rows)


@dataclass(frozen=True)
class Query(DriverAnswer[int]):
    """A draw makes the driver count exactly this much, or at least or at most so much.

    The pass is drawn once more with a query around the draw, earlier draws having filled the depth
    and stencil buffers. "samples_passed" are the samples that pass all tests and are not discarded:
    exact on every driver. What pipeline statistics count ("…_invocations" and the like) a driver
    may exceed where it works in blocks, and one without them leaves the case unsupported. Raises
    CaseError: the counter is unknown, or nothing is expected of it."""

    kind = "query"
    query_name = "count"
    query_arguments = ("counter",)

    counter: str
    _: KW_ONLY
    equals: int | None = None
    at_least: int | None = None
    at_most: int | None = None

    def __post_init__(self) -> None:
        check_choice("query", "counter", self.counter, COUNTERS)
        if (self.equals is None) == (self.at_least is None and self.at_most is None):
            raise CaseError(f"query {self.counter!r}: give equals=, or at_least= and at_most=")

    @property
    def default_name(self) -> str:
        return self.counter.replace("_", " ")

    def compare(self, answer: int) -> tuple[list[Row], str]:
        low, high = self.at_least or 0, self.at_most
        if self.equals is not None:
            low = high = int(self.equals)
        if low == high:
            expected = str(low)
        elif high is None:
            expected = f"at least {low}"
        else:
            expected = f"at most {high}" if low == 0 else f"{low} to {high}"
        ok = low <= answer and (high is None or answer <= high)
        words = self.counter.replace("_", " ")
        row = Row(label=words, expected=expected, measured=str(answer), ok=ok)
        return [row], "" if ok else f"{answer} {words}, not {expected}"


@dataclass(frozen=True)
class GlError(DriverAnswer[Sequence[int]]):
    """The draw raises this error ("invalid_operation", …); any other error fails the case."""

    kind = "GL error"
    named = "GL {self.error}"
    query_name = "gl_errors"

    error: str

    def __post_init__(self) -> None:
        check_choice("gl_error", "error", self.error, tuple(GL_ERRORS))

    def raises_gl_errors(self, scene: Scene) -> frozenset[PassDraw]:
        return frozenset({self.key(scene)})

    def compare(self, answer: Sequence[int]) -> tuple[list[Row], str]:
        want = GL_ERRORS[self.error]
        ok = list(answer) == ([want] if want else [])
        measured = ", ".join(error_name(e) for e in answer) or error_name(0)
        row = Row(label="glGetError", expected=error_name(want), measured=measured, ok=ok)
        return [row], "" if ok else f"the draw raises {measured}"


@dataclass(frozen=True, kw_only=True)
class InactiveUniforms(DriverAnswer[Mapping[str, int]]):
    """Of all uniforms that a draw's program declares, exactly these have location −1."""

    kind = "inactive uniforms"
    query_name = "locations"

    uniforms: tuple[str, ...]

    def compare(self, answer: Mapping[str, int]) -> tuple[list[Row], str]:
        for name in self.uniforms:
            if name not in answer:
                raise CaseError(
                    f"inactive_uniforms: the program declares no {name!r}",
                    remedy=suggest(name, answer),
                )
        rows = [
            Row(
                label=name,
                expected="inactive: −1" if name in self.uniforms else "active: 0 or more",
                measured=str(location).replace("-", "−"),
                ok=(location == -1) is (name in self.uniforms),
            )
            for name, location in answer.items()
        ]
        if not rows:
            rows.append(Row(label="uniforms", expected="none", measured="none", ok=True))
        return rows, _list_wrong("not as expected", rows)


def inactive_uniforms(
    *uniforms: str, pass_name: str | None = None, draw: int = -1, name: str = ""
) -> InactiveUniforms:
    """Exactly these of the uniforms that a draw's program declares are inactive: no output depends
    on them, and the driver gives them the location −1. All others have a location."""
    return InactiveUniforms(uniforms=uniforms, pass_name=pass_name, draw=draw, name=name)


@dataclass(frozen=True)
class Coverage(DrawExpectation):
    """Exactly `pixels` pixels show the draw in the end: those that it covers, that pass every test
    and are not discarded, and that no later draw of the pass covers."""

    kind = "coverage"

    pixels: int

    def find_reads(self, scene: Scene) -> Iterable[Read]:
        yield Read(self.key(scene)[0], "coverage")

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield CapturedFragments(self.key(scene))

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        covered = frame.answer(CapturedFragments(self.key(scene))).covered
        count = int(np.count_nonzero(covered))
        ok = count == self.pixels
        row = Row(label="pixels", expected=str(self.pixels), measured=str(count), ok=ok)
        message = "" if ok else f"{count} pixels are covered, not {self.pixels}"
        return self.judge_rows([row], message, judged=covered.size)


def _list_wrong(what: str, rows: Sequence[Row]) -> str:
    wrong = [row.label for row in rows if not row.ok]
    return f"{what}: {', '.join(wrong)}" if wrong else ""


def _format_layout(offset: int, stride: int, divisor: int) -> str:
    each = f", a value every {divisor} instances" if divisor > 1 else ", one an instance"
    return f"offset {offset}, stride {stride}{each if divisor else ''}"


attribute_layout = AttributeLayout
block_layout = BlockLayout
query = Query
gl_error = GlError
coverage = Coverage
