"""What every kind of expectation is: data, what it reads and needs of a run, and its judgement.

The kinds themselves are in `shaderlab.engine.expectations`, one a file. A kind is a frozen
dataclass that derives from `Expectation`. It names the outputs that it reads and the passes that
draw them, asks for what it needs beyond the pictures (`needs`), and judges the frame of answers.
"""

from __future__ import annotations

import os
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Self

from shaderlab.model.checked import Checked
from shaderlab.model.scene import Pixel

from .frame import Frame, Need as Need, PassDraw, Programs as Programs, TypedNeed as TypedNeed
from .records import Curve, Outcome, Plot, Row

_MOST_CALLERS = 32

if TYPE_CHECKING:
    from shaderlab.model.case import Scene


@dataclass(frozen=True)
class Read:
    """An output that an expectation reads: all of it, what one draw covers of it, or one pixel."""

    pass_name: str
    output: str
    pixel: Pixel | None = None
    draw: int | None = None


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """One expectation judged.

    `pictures` makes arrays: "measured" and "reference" (height, width, components) and "distance"
    (height, width: the distance in half band widths, NaN where nothing was judged). The numbers
    behind them are there too: "exact" (the reference, unrounded), "low", "high" and "outside" in
    the shape of "measured", "covered" (height, width), and "unit", the size of one code of a
    fixed-point format or 0. None where the judged values are not a picture. Some may be functions
    that make them when they are shown: "reference" and "distance" of nothing, the four arrays of
    numbers of the indices of covered pixels; these return (count, components).

    `output` is one that a shader assigns, by its draw and its own name; the report shows the line.
    """

    outcome: Outcome
    pictures: Callable[[], Mapping[str, Any]] | None = None
    curve: Curve | None = None
    plot: Plot | None = None
    output: tuple[PassDraw, str] | None = None


@dataclass(frozen=True, kw_only=True)
class Expectation(Checked, ABC):
    """What must hold of a scene.

    Attributes:
        kind: how records call this kind.
        named: its name if the case gives none, such as "{self.output}"; else its kind.
        once: whether it is judged with a case's first variant alone, since no input changes it.
        name: how outcomes call this one.
    """

    kind: ClassVar[str]
    named: ClassVar[str] = ""
    once: ClassVar[bool] = False

    name: str = field(default_factory=str)  # no class attribute: a kind may take it first

    def __new__(cls, *given: Any, **named: Any) -> Self:
        made = super().__new__(cls)
        object.__setattr__(made, "_callers", tuple(_callers()))
        return made

    def line_in(self, file: str) -> int:
        """The line of a case file at which it was made; 0 if that was elsewhere."""
        wanted = os.path.abspath(file)
        callers: Sequence[tuple[str, int]] = self.__dict__.get("_callers", ())
        return next((line for name, line in callers if os.path.abspath(name) == wanted), 0)

    def __post_init__(self) -> None:
        if not self.name:
            object.__setattr__(self, "name", self.default_name)

    @property
    def default_name(self) -> str:
        """Its name if the case gives none."""
        return (self.named or self.kind).format(self=self)

    def find_reads(self, scene: Scene) -> Iterable[Read]:
        """The outputs that it judges, found by their names alone, whether they exist or not."""
        return ()

    def passes(self, scene: Scene) -> frozenset[str]:
        """The passes whose shaders it judges; none where no shader has a part in it. Raises
        CaseError: it names a pass or a draw that does not exist."""
        return frozenset()

    def judges_vertices(self, scene: Scene, programs: Programs) -> bool:
        """Whether it judges what a vertex or geometry stage gives, and not what is drawn."""
        return False

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        """What it needs beyond the pictures. Raises CaseError: it names what does not exist."""
        return ()

    def raises_gl_errors(self, scene: Scene) -> frozenset[PassDraw]:
        """The draws whose GL errors it judges; those of all others fail the scene."""
        return frozenset()

    @abstractmethod
    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        """Judge what was drawn and answered. Raises CaseError, FormulaError: it asks for what is
        not there."""

    def judge_rows(
        self, rows: Sequence[Row], message: str, judged: int, rows_per_variant: bool = True
    ) -> Judgement:
        """Return a judgement of a table's rows: it fails where there is a message."""
        outcome = Outcome.of_rows(self.name, self.kind, rows, message, judged, rows_per_variant)
        return Judgement(outcome=outcome)


def _callers() -> Iterator[tuple[str, int]]:
    """Files and lines from the one that makes an expectation up to the import of its module."""
    frame = sys._getframe(2)
    for _ in range(_MOST_CALLERS):
        name = frame.f_code.co_filename
        if name.startswith("<frozen importlib"):
            return
        yield name, frame.f_lineno
        if frame.f_back is None:
            return
        frame = frame.f_back
