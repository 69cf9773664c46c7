"""Draws held against their own shaders' bands: whether the driver draws what a shader says.

A formula looks at one draw's output. This looks at every program of a scene, by interpreting its
modules: a driver that miscompiles a shader is caught even where no formula is. A shader that is
wrong in itself is not.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Iterator, Set
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.analysis.interpreter import Bands, Interpreted, Program, interpret
from shaderlab.analysis.interpreter.values import Flags
from shaderlab.bands import Band
from shaderlab.compiler.sources import Source
from shaderlab.drivers.programs.textures import output_format
from shaderlab.engine.evaluation import FEATURES, Evaluation
from shaderlab.engine.expectations.formula import Formula
from shaderlab.engine.expectations.needs import CapturedFragments
from shaderlab.engine.judging.bands import store_band
from shaderlab.engine.worker import Worker
from shaderlab.errors import DeviceLostError, ShaderlabError
from shaderlab.model.expectation import Judgement, Need
from shaderlab.model.frame import PassDraw
from shaderlab.model.phases import phase
from shaderlab.model.records import Explanation, LineCoverage, ModulesRecord, Outcome, Row

from .batches import InputBatch, fragment_batch
from .invocations import Invocations, program_of, sample_fragments, stage_of

if TYPE_CHECKING:
    from shaderlab.workers.worker import Channel

    from .hazards import Claim

PIXELS = 1024
"""Of each draw in a sample."""
_SAMPLE_BLOCKS, _MOST_BLOCKS = 1000, 10_000
_NAME = "each draw is what its shader says"


@dataclass
class _DrawCheck:
    """What checking one draw found: a row for each output, or why the draw was left out; the
    outputs that were judged, and those outside of their bands; how many pixels were judged, over
    all outputs; words about the first pixel that is outside; and the program with what it came
    to, and with what inputs."""

    rows: list[Row] = field(default_factory=list)
    left_out: str = ""
    outputs: list[str] = field(default_factory=list)
    outside: list[str] = field(default_factory=list)
    judged: int = 0
    message: str = ""
    taken: tuple[Program, Set[tuple[int, int]]] | None = None
    drawn: tuple[Program, InputBatch] | None = None


class SelfCheck:
    """The draws of a scene, held against their own shaders while it is on the device.

    Args:
        every: look at all pixels of all draws. Otherwise at some of each program's first draw,
            and of those whose inputs expectations capture, of one in each pass.

    Attributes:
        outside: the outputs, (pass, output), that left their bands.
    """

    def __init__(self, evaluation: Evaluation, every: bool = False) -> None:
        self.outside: set[tuple[str, str]] = set()
        self._evaluation = evaluation
        self._every = every
        self._checks: dict[PassDraw, _DrawCheck] = {}
        needs = evaluation.all_needs()
        self._passes = _passes_captured(needs)
        self._keys = list(_choose_draws(evaluation, needs, every=every))

    def judge_captured(self, needed: Set[Need]) -> None:
        """Judge the draws whose captured inputs are not `needed` any more, and all others of a pass
        of which nothing is: they are captured with those."""
        answers = self._evaluation.answers
        ended = self._passes - _passes_captured(needed)
        for key in self._keys:
            need = CapturedFragments(key)
            if key[0] in ended or (need in answers and need not in needed):
                self._check(key)

    def judgement(self) -> tuple[ModulesRecord, Judgement]:
        """Judge the other draws; whether the driver drew what each fragment shader allows."""
        checks = {key: self._check(key) for key in self._keys}
        self.outside = {(key[0], name) for key, check in checks.items() for name in check.outside}
        judged = sum(check.judged for check in checks.values())
        claims = [(claim.status, str(claim)) for claim in self._prove()]
        outputs = (f"{key[0]}.{name}" for key, check in checks.items() for name in check.outputs)
        left_out = (check.left_out for check in checks.values() if check.left_out)
        record = ModulesRecord(
            judged=judged,
            outputs=tuple(dict.fromkeys(outputs)),
            left_out=tuple(dict.fromkeys(left_out)),
            coverage=_list_lines(checks.values()) if self._every else (),
            proved=tuple(words for status, words in claims if status == "proved"),
            open=tuple(words for status, words in claims if status == "open"),
        )
        rows = [row for check in checks.values() for row in check.rows]
        message = next((check.message for check in checks.values() if check.message), "")
        outcome = Outcome.of_rows(_NAME, "module", rows, message, judged)
        return record, Judgement(outcome=outcome)

    def _prove(self) -> Iterator[Claim]:
        """What is proved of each program for all inputs between those that it was checked with: at
        once, of a case's first variant, or with some effort if `every`."""
        scene = self._evaluation.scene
        first = [variant.name for variant in scene.case.variants][:1] or [scene.variant]
        if not self._every and scene.variant not in first:
            return
        from .audit import prove_between_draws  # other variants need none of it
        from .inputs import inputs_of

        drawn: dict[Program, list[InputBatch]] = {}
        for program, batch in filter(None, (check.drawn for check in self._checks.values())):
            drawn.setdefault(program, []).append(batch)
        for program, batches in drawn.items():
            # A defect of the interpreter changes no verdict here, either.
            unforeseen = ShaderlabError if os.environ.get("SHADERLAB_DEBUG") else Exception
            with suppress(unforeseen), phase("judge", "proving each program"):
                inputs = inputs_of(program)
                proof = prove_between_draws(program, inputs, batches, at_once=not self._every)
                yield from (*proof.claims(), *proof.refuted_claims())

    def _check(self, key: PassDraw) -> _DrawCheck:
        """Check a draw, once."""
        if key in self._checks:
            return self._checks[key]
        check = self._checks[key] = _DrawCheck()
        answers, need = self._evaluation.answers, CapturedFragments(key)
        known = need in answers
        try:
            with phase("judge", "judging each draw by its shader"):
                _check_outputs(self._evaluation, key, check, every=self._every)
        except (DeviceLostError, MemoryError):
            raise
        except ShaderlabError as error:
            _leave_out(check, key, error.message.partition("\n")[0])
        except Exception as error:  # a defect of the interpreter changes no verdict
            if os.environ.get("SHADERLAB_DEBUG"):
                raise
            _leave_out(check, key, f"not interpreted: unforeseen {error!r}")
        finally:
            if not known:  # of many draws, all are more than fits into memory
                answers.pop(need, None)
        return check


def _check_outputs(
    evaluation: Evaluation, key: PassDraw, check: _DrawCheck, *, every: bool
) -> None:
    given, result = _interpret_draw(evaluation, key, every=every)
    if result is None:
        return
    some = sample_fragments(evaluation, key, PIXELS, program=given.program) if every else given
    check.drawn = given.program, InputBatch(some.each, some.bindings, some.count)
    if not shows_what_is_written(evaluation, key):
        given = _redraw_unblended(evaluation, key, given)
    if every:
        check.taken = given.program, result.taken | _take_discarded(evaluation, key, given)
    discarded = result.discarded.all_true.reshape(-1)
    for name, band in result.outputs.items():
        outside = find_outside(given, name, band)
        if outside is None:
            continue
        outside |= discarded
        check.judged += given.count
        check.outputs.append(name)
        measured = f"{outside.sum()} of {given.count} pixels outside"
        check.rows.append(_row(key, name, measured, ok=not outside.any()))
        if outside.any():
            check.outside.append(name)
        if outside.any() and not check.message:
            row = int(outside.argmax())
            check.message = _message(given, key, name, row, band, discarded=bool(discarded[row]))


def _interpret_draw(
    evaluation: Evaluation, key: PassDraw, *, every: bool
) -> tuple[Invocations, Interpreted | None]:
    """A draw's invocations and their bands; None where none is seen."""
    program = program_of(stage_of(evaluation, key, "fragment"))
    given = sample_fragments(evaluation, key, None if every else PIXELS, program=program)
    if not given.count:
        return given, None
    return given, _interpret(program, given, _MOST_BLOCKS if every else _SAMPLE_BLOCKS)


def _interpret(program: Program, given: Invocations | InputBatch, most: int) -> Interpreted:
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        return interpret(
            program, given.each, given.bindings, Bands(), count=given.count, max_blocks=most
        )


def _take_discarded(
    evaluation: Evaluation, key: PassDraw, given: Invocations
) -> Set[tuple[int, int]]:
    """The blocks that fragments came to which a draw may have discarded, as of `Interpreted`."""
    captured = evaluation.answer(CapturedFragments(key))
    if captured.undiscarded is None:
        return set()
    batch = fragment_batch(captured, given.bindings, PIXELS)
    return _interpret(given.program, batch, _MOST_BLOCKS).taken


def shows_what_is_written(evaluation: Evaluation, key: PassDraw) -> bool:
    """Whether attachments hold what a draw's shader wrote, and nothing else."""
    state = evaluation.programs[key[0]][key[1]].draw.state
    target = evaluation.scene.find_pass(key[0]).target
    return not (state.blend or state.srgb or target.samples) and all(state.color_mask)


def _redraw_unblended(evaluation: Evaluation, key: PassDraw, given: Invocations) -> Invocations:
    """Invocations with what they write where the draw is made once more, into floats and without
    blending, masks and samples."""
    assert given.pixels is not None
    draw = evaluation.programs[key[0]][key[1]]
    formats = {name: output_format(one.type) for name, one in draw.interface.outputs.items()}
    images = evaluation.session.redraw_with_text(key, draw.text("fragment") or "", formats)
    at = given.pixels[:, 1], given.pixels[:, 0]
    return replace(given, measured={n: v[at] for n, v in images.items()}, formats=formats)


def find_outside(given: Invocations, name: str, band: Any) -> Flags | None:
    """Where an output that was read back lies outside of its band; None where it can't be told."""
    if name not in given.measured or not isinstance(band, Band) or band.ndim != 2:
        return None
    measured = given.measured[name]
    components = min(measured.shape[-1], band.shape[-1])
    allowed = store_band(band[:, :components], given.formats[name], components)
    found: Flags = np.asarray(~allowed.contains(measured[:, :components]).all(axis=-1))
    return found


def _choose_draws(evaluation: Evaluation, known: Set[Need], *, every: bool) -> Iterator[PassDraw]:
    """The draws to check, where these needs are answered anyway."""
    groups: dict[tuple[Source, ...], dict[str, list[PassDraw]]] = {}
    for name, draws in evaluation.programs.items():
        for i, draw in enumerate(draws):
            if draw.sources[-1].stage in ("fragment", "compute"):
                groups.setdefault(draw.sources, {}).setdefault(name, []).append((name, i))

    def cost(key: PassDraw) -> tuple[bool, bool]:
        return CapturedFragments(key) not in known, not shows_what_is_written(evaluation, key)

    for passes in groups.values():
        if every:
            yield from (key for keys in passes.values() for key in keys)
            continue
        first = sorted((min(keys, key=cost) for keys in passes.values()), key=cost)
        yield first[0]
        yield from (key for key in first[1:] if cost(key) == (False, False))


def _list_lines(checks: Iterable[_DrawCheck]) -> tuple[LineCoverage, ...]:
    from .coverage import cover_lines  # few runs ask

    taken: dict[Program, set[tuple[int, int]]] = {}
    for program, own in filter(None, (check.taken for check in checks)):
        taken.setdefault(program, set()).update(own)
    return tuple(line for each in taken.items() for line in cover_lines(*each))


def _leave_out(check: _DrawCheck, key: PassDraw, why: str) -> None:
    check.left_out = f"draw {key[1]} of pass {key[0]!r}: {why}"
    check.rows.append(_row(key, "", why, ok=True))


def _row(key: PassDraw, name: str, measured: str, *, ok: bool) -> Row:
    label = f"draw {key[1]} of pass {key[0]!r}" + (f", {name}" if name else "")
    return Row(label=label, expected="inside the band of its module", measured=measured, ok=ok)


def _message(
    given: Invocations, key: PassDraw, name: str, row: int, band: Band, *, discarded: bool
) -> str:
    assert given.pixels is not None
    x, y = (int(v) for v in given.pixels[row])
    values = ", ".join(f"{v:.9g}" for v in given.measured[name][row])
    stored = store_band(band[row], given.formats[name], band.shape[-1])
    ends = zip(stored.lo, stored.hi, strict=True)
    allowed = ", ".join(f"{low:.9g} … {high:.9g}" for low, high in ends)
    return (
        f"draw {key[1]} of pass {key[0]!r} is outside its shader's band: {name} is {values} at "
        f"pixel ({x}, {y}), " + ("which the shader discards" if discarded else f"allowed {allowed}")
    )


def _passes_captured(needs: Iterable[Need]) -> set[str]:
    """The passes of which some needs are captured fragments."""
    return {need.key[0] for need in needs if isinstance(need, CapturedFragments)}


class CheckingWorker(Worker):
    """A worker that holds draws against their shaders, and explains formulas that fail."""

    def __init__(self, channel: Channel | None = None) -> None:
        register()
        super().__init__(channel)


def register() -> None:
    """Have the engine hold draws against their shaders, and explain formulas that fail."""
    FEATURES.self_check = SelfCheck
    FEATURES.explain = _explain


def _explain(evaluation: Evaluation, formula: Formula, outcome: Outcome) -> Explanation | None:
    from .explain import locate_failure  # it parses GLSL, which few runs need

    return locate_failure(evaluation, formula, outcome)
