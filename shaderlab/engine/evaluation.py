"""One scene evaluated: drawn once, then asked for what expectations need, each thing once."""

import functools
from collections.abc import Callable, Iterable, Iterator, Set
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, Protocol

from shaderlab.drivers import Backend, Session
from shaderlab.drivers.programs.prepare import Preparer
from shaderlab.errors import CaseError, DriverError
from shaderlab.model.calls import error_name
from shaderlab.model.expectation import Expectation, Judgement, Need
from shaderlab.model.frame import Frame
from shaderlab.model.phases import phase
from shaderlab.model.records import Explanation, ModulesRecord, Outcome

from .expectations.base import Context
from .expectations.discards import DiscardCheck
from .expectations.formula import Formula
from .expectations.needs import CapturedFragments


class Evaluation:
    """A scene on a device: its frame, and the judgement of its expectations, all or some.

    Nothing is captured or probed before an expectation asks for it. What was drawn and answered
    stays readable when the session is closed.

    Args:
        session: the scene on the device; it is drawn now.
        preparer: what compiled the scene's programs.
        like: an evaluation of the same scene with the shaders' own texts: its answers are taken
            where they must be the same.

    Raises ShaderError, UnsupportedError, CaseError: the scene can't be drawn."""

    def __init__(
        self,
        session: Session,
        backend: Backend,
        preparer: Preparer,
        like: "Evaluation | None" = None,
    ) -> None:
        self.session = session
        self.scene = session.scene
        self.programs = session.programs
        self.answers: dict[Need, Any] = {}
        self._like = like
        self._vendor = backend.info["vendor"]
        self._needs: dict[int, tuple[Expectation, tuple[Need, ...]]] = {}
        with phase("draw"):
            self.drawn = session.draw()
        self._context = Context(session, self.drawn.bindings, preparer, backend.driver_verdict)

    @functools.cached_property
    def frame(self) -> Frame:
        """What was drawn, and what was answered so far."""
        return Frame(
            images=self.drawn.images,
            order=tuple(p.name for p in self.scene.passes),
            bindings=self.drawn.bindings,
            sample_positions=self.drawn.sample_positions,
            subpixel_step=self.session.subpixel_step,
            vendor=self._vendor,
            answers=self.answers,
        )

    @functools.cached_property
    def _discard_check(self) -> DiscardCheck:
        # A part of a scene may lack the expectation that has the rule.
        whole = self.scene if self._like is None else self._like.scene
        return DiscardCheck(self.scene, self.programs, whole)

    def gather(self, expectation: Expectation) -> None:
        """Ask for all that an expectation itself needs. Raises ShaderlabError: it names what is not
        there, or there is no answer."""
        with phase("draw"):
            for need in self._own_needs(expectation):
                self.answer(need)

    def _own_needs(self, expectation: Expectation) -> tuple[Need, ...]:
        """All that an expectation itself asks for, found once."""
        if id(expectation) not in self._needs:  # kept with it, or its id might be another's
            found = tuple(expectation.needs(self.scene, self.programs))
            self._needs[id(expectation)] = expectation, found
        return self._needs[id(expectation)][1]

    def iter_with_release(
        self, before_release: Callable[[Set[Need]], None] | None = None
    ) -> Iterator[tuple[int, Expectation]]:
        """Iterate over the scene's expectations with their numbers; each is to be gathered and
        judged before the next one. What none after it needs is released then: captures are as large
        as pictures. Before that, `before_release` is called with what is still needed."""
        expect = self.scene.expect
        for index, expectation in enumerate(expect):
            yield index, expectation
            needed = {need for later in expect[index + 1 :] for need in self._own_needs(later)}
            if before_release is not None:
                before_release(needed)
            self.forget([need for need in self.answers if need not in needed])

    def all_needs(self) -> set[Need]:
        """All that the scene's expectations need and was not judged yet."""
        asked = self._own_needs, self._discard_check.needed
        return {need for each in self.scene.expect for needs in asked for need in needs(each)}

    def answer(self, need: Need) -> Any:
        """Return a need's answer, asked for once. Raises ShaderlabError if there is none."""
        if need not in self.answers:
            self.answers[need] = self._answer(need)
        return self.answers[need]

    def judge(self, expectation: Expectation) -> Judgement:
        """Judge one of the scene's expectations; see `Expectation.judge` for what it raises."""
        self.gather(expectation)
        with phase("judge", f"judging {expectation.name!r}"):
            given: Any = expectation.judge(self.scene, self.frame)
            if not isinstance(given, Judgement):
                made = f"{type(expectation).__name__}.judge() gives {given!r:.60}, no Judgement"
                raise CaseError(made, remedy="return self.judge_rows(…)")
            judgement = given
            if judgement.outcome.status == "pass":
                fault = self._discard_check.fault(expectation, self.frame, self._lend)
                if fault := fault or self._find_misplaced(expectation):
                    failed = replace(judgement.outcome, status="fail", message=fault)
                    judgement = replace(judgement, outcome=failed)
            return judgement

    @contextmanager
    def _lend(self, need: Need) -> Iterator[None]:
        """Answer a need that only the block has, perhaps: a capture is as large as a picture."""
        kept = need in self.answers or any(need in self._own_needs(e) for e in self.scene.expect)
        try:
            self.answer(need)
            yield
        finally:
            if not kept:
                self.forget([need])

    def _find_misplaced(self, expectation: Expectation) -> str:
        """Where an expectation's fragments are not where the driver says, or ""."""
        captured = (
            need for need in self._own_needs(expectation) if isinstance(need, CapturedFragments)
        )
        found = (need.misplaced(self.answers[need], self.programs) for need in captured)
        return next(filter(None, found), "")

    def forget(self, needs: Iterable[Need]) -> None:
        """Give back what was captured and probed for these needs."""
        for need in needs:
            self.answers.pop(need, None)

    def require_no_other_errors(self) -> None:
        """Raise DriverError for a GL error that no expectation is about."""
        expected = {key for e in self.scene.expect for key in e.raises_gl_errors(self.scene)}
        for key, errors in self.drawn.gl_errors.items():
            if key not in expected:
                names = ", ".join(error_name(code) for code in errors)
                raise DriverError(f"draw {key[1]} of pass {key[0]!r} raises {names}")

    def _answer(self, need: Need) -> Any:
        like = self._like
        if like and need in like.answers and need.has_same_answer(self.programs, like.programs):
            return like.answers[need]
        return need.answer(self._context)


class SceneCheck(Protocol):
    """A check of a whole scene, besides its expectations. `outside` are the outputs, (pass, output)
    each, that failed it; complete after `judgement`."""

    outside: set[tuple[str, str]]

    def judge_captured(self, needed: Set[Need]) -> None:
        """Judge what was captured and is not `needed` any more: it is about to be released."""

    def judgement(self) -> tuple[ModulesRecord, Judgement]:
        """Judge the rest, while the scene is on the device, and return what was found."""


@dataclass
class Features:
    """What packages above the engine add to the run of each scene; they register it here.

    `self_check` makes a check of a scene: of all its pixels if the flag is set, else of a sample.
    `explain` says where a formula that fails goes wrong, None where it has no answer; it raises
    ShaderlabError.
    """

    self_check: "Callable[[Evaluation, bool], SceneCheck] | None" = None
    explain: "Callable[[Evaluation, Formula, Outcome], Explanation | None] | None" = None


FEATURES = Features()
