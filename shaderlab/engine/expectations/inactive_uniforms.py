"""inactive_uniforms: which of its declared uniforms a program does not use."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from shaderlab.errors import CaseError, nearest
from shaderlab.model.case import Scene
from shaderlab.model.checked import checked_arguments
from shaderlab.model.expectation import Judgement, Need, Programs
from shaderlab.model.frame import Frame
from shaderlab.model.records import Row

from .base import Asked, OfDraw, judge_rows


@dataclass(frozen=True, kw_only=True)
class InactiveUniforms(OfDraw):
    """Of all uniforms that a draw's program declares, exactly these have location −1."""

    kind = "inactive uniforms"

    uniforms: tuple[str, ...]

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield Asked("locations", (self.key(scene),))

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        locations: Mapping[str, int] = frame.answers[Asked("locations", (self.key(scene),))]
        for name in self.uniforms:
            if name not in locations:
                raise CaseError(
                    f"inactive_uniforms: the program declares no {name!r}",
                    remedy=nearest(name, locations),
                )
        rows = [
            Row(
                label=name,
                expected="inactive: −1" if name in self.uniforms else "active: 0 or more",
                measured=str(location).replace("-", "−"),
                ok=(location == -1) is (name in self.uniforms),
            )
            for name, location in locations.items()
        ]
        wrong = [row.label for row in rows if not row.ok]
        message = f"not as expected: {', '.join(wrong)}" if wrong else ""
        return judge_rows(self.name, self.kind, rows, message, judged=len(rows) or 1)


@checked_arguments
def inactive_uniforms(
    *uniforms: str, pass_name: str | None = None, draw: int = -1, name: str = ""
) -> InactiveUniforms:
    """Exactly these of the uniforms that a draw's program declares are inactive: no output depends
    on them, and the driver gives them the location −1. All others have a location."""
    return InactiveUniforms(
        uniforms=uniforms, pass_name=pass_name, draw=draw, name=name or "inactive uniforms"
    )
