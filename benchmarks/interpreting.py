"""Every program of the catalogue, interpreted: against the driver, and against the hand-written
references.

`python -m benchmarks.interpreting` draws each case, interprets each fragment and vertex program
in bands (and with `--numbers` in float32 and float64, too), at 4096 invocations at most, and prints

- how many programs are interpreted, and why the others are not;
- how many of the driver's values lie outside of the band that the program itself gives, and with
  `--adversary` how many of those of a device that errs in every instruction as much as it may;
- for each formula of a fragment's output the median ratio of that band's width to the width of the
  band of its reference, the values without a width left out; and the ratio of what both cost.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from benchmarks.adversary_device import Device
from benchmarks.erring_arithmetic import Erring, outside
from benchmarks.shipped import load_cases
from shaderlab.analysis.interpreter import FLOAT32, FLOAT64, Bands, Interpreted, interpret
from shaderlab.analysis.invocations import (
    Invocations,
    program_of,
    sample_fragments,
    stage_of,
)
from shaderlab.analysis.self_check import shows_what_is_written
from shaderlab.bands import Band, Integer, Rules
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.formula import Formula
from shaderlab.engine.expectations.needs import CapturedVertices, subject_of
from shaderlab.engine.judging.bands import store_band
from shaderlab.engine.judging.references import evaluate, match_parameters
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import DriverError, NotInterpretedError, ShaderlabError
from shaderlab.model.case import Scene
from shaderlab.model.frame import PassDraw
from shaderlab.model.options import RunOptions

MOST = 4096


@dataclass
class Survey:
    """What was found of one program, on the inputs of one draw."""

    case: str
    variant: str
    draw: str
    file: str
    stage: str
    status: str = "interpreted"
    invocations: int = 0
    seconds: float = 0.0
    by_numbers: float = 0.0
    adversary: list[int] = field(default_factory=lambda: [0, 0])  # values, and those outside
    values: int = 0
    outside: dict[str, int] = field(default_factory=dict)
    vacuous: dict[str, float] = field(default_factory=dict)
    undecided: int = 0
    formulas: list[dict[str, Any]] = field(default_factory=list)


def main(words: list[str] | None = None) -> int:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("cases", nargs="*", help="ids of cases; all by default")
    options.add_argument("--numbers", action="store_true", help="float32 and float64 as well")
    options.add_argument(
        "--adversary",
        type=int,
        default=0,
        metavar="N",
        help="N runs of each program on a device that errs as much as it may",
    )
    options.add_argument("--driver", help="llvmpipe by default")
    options.add_argument("--json", help="write what was found of each program to this file")
    given = options.parse_args(words)
    warnings.simplefilter("ignore")
    found = list(surveys(given))
    if given.json:
        with open(given.json, "w") as file:
            json.dump([asdict(survey) for survey in found], file, indent=1)
    return summary(found)


def surveys(given: argparse.Namespace) -> Iterator[Survey]:
    """Each program of the cases once, and once more for each formula that reads it anew."""
    with SceneRunner(RunOptions(size=64, driver=given.driver)) as lab:
        for case in load_cases().values():
            if given.cases and case.id not in given.cases:
                continue
            seen: set[Any] = set()
            for scene in case.scenes():
                try:
                    with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
                        yield from of_scene(evaluation, seen, given)
                except ShaderlabError as error:
                    print(f"{case.id} {scene.variant}: not drawn: {error.message}", file=sys.stderr)


def sample_vertices(evaluation: Evaluation, key: PassDraw, most: int | None = None) -> Invocations:
    """The vertices of a draw without a geometry stage, the first `most` of them.

    Raises:
        ShaderError, NotInterpretedError: the vertex stage can't be interpreted.
        DriverError, CaseError: its inputs can't be captured.
    """
    source = stage_of(evaluation, key, "vertex")
    captured = evaluation.answer(CapturedVertices(key))
    return Invocations(
        program=program_of(source),
        each={name: values[:most] for name, values in captured.inputs.items()},
        bindings=evaluation.drawn.bindings[key],
        measured={name: values[:most] for name, values in captured.outputs.items()},
        formats=dict.fromkeys(captured.outputs, "rgba32f"),
    )


def of_scene(
    evaluation: Evaluation, seen: set[Any], options: argparse.Namespace
) -> Iterator[Survey]:
    """The programs and formulas of a scene that were not seen in another one."""
    scene = evaluation.scene
    for key in evaluation.drawn.bindings:
        draw = evaluation.programs[key[0]][key[1]]
        for stage, gather in (("fragment", sample_fragments), ("vertex", sample_vertices)):
            source = next((s for s in draw.authored if s.stage == stage), None)
            if source is None or (stage == "vertex" and draw.draw.geometry is not None):
                continue
            formulas = formulas_of(scene, key) if stage == "fragment" else []
            new = {(source.text, f.name) for f in formulas} | {(source.text, stage)}
            if new <= seen:
                continue
            survey = Survey(scene.case.id, scene.variant, f"{key[0]}.{key[1]}", source.name, stage)
            try:
                invocations = gather(evaluation, key, MOST)
                survey.invocations = invocations.count
                if not invocations.count:
                    continue
                of_program(survey, evaluation, key, invocations, formulas, options)
            except NotInterpretedError as error:
                survey.status = error.message
            except DriverError as error:
                survey.status = f"not captured: {error.message}"
            except ShaderlabError as error:
                survey.status = f"error: {error.message}"
            except Exception as error:
                survey.status = f"error: {type(error).__name__}: {error} " + " < ".join(
                    f"{f.name}:{f.lineno}"
                    for f in traceback.extract_tb(error.__traceback__)[-5:][::-1]
                )
            seen |= new
            yield survey


def formulas_of(scene: Scene, key: PassDraw) -> list[Formula]:
    """The formulas that judge a draw's pixels."""
    return [e for e in scene.expect if isinstance(e, Formula) and e.key(scene) == key]


def of_program(
    survey: Survey,
    evaluation: Evaluation,
    key: PassDraw,
    given: Invocations,
    formulas: list[Formula],
    options: argparse.Namespace,
) -> None:
    """Interpret a program, and hold it against the driver and its formulas."""
    started = time.process_time()
    result = interpret(given.program, given.each, given.bindings, Bands(), count=given.count)
    survey.seconds = time.process_time() - started
    survey.undecided = sum(int(flags.sum()) for flags in result.undecided.values())
    for seed in range(options.adversary):
        erring(survey, given, result, seed)
    if options.numbers:
        started = time.process_time()
        for arithmetic in (FLOAT32, FLOAT64):
            interpret(given.program, given.each, given.bindings, arithmetic, count=given.count)
        survey.by_numbers = time.process_time() - started
    kept = result.discarded.all_false
    if survey.stage == "vertex" or shows_what_is_written(evaluation, key):
        for name, band in result.outputs.items():
            if name in given.measured and isinstance(band, Band | Integer):
                compare(survey, name, band, given, kept)
    for formula in formulas:
        name = formula.own_name(evaluation.scene)
        if isinstance(result.outputs.get(name), Band):
            survey.formulas.append(widths(evaluation, formula, given, result.outputs[name], survey))


def erring(survey: Survey, given: Invocations, result: Interpreted, seed: int) -> None:
    """Hold a run on the adversary against the band, where neither may have discarded."""
    arithmetic = Erring(device=Device(seed, "either"))
    theirs = interpret(
        given.program, given.each, given.bindings, arithmetic,
        count=given.count, watch=arithmetic.keep_folded,
    )  # fmt: skip
    kept = result.discarded.all_false & theirs.discarded.all_false
    for name, band in result.outputs.items():
        if isinstance(band, Band) and band.ndim == 2:
            survey.adversary[0] += int(kept.sum()) * band.shape[-1]
            found = outside(band[kept], theirs.outputs[name][kept])
            survey.adversary[1] += found
            if found:
                print(f"adversary: {found} outside: {survey.case} {survey.file} {name} {seed}")


def compare(survey: Survey, name: str, band: Any, given: Invocations, kept: Any) -> None:
    """Count the driver's values outside of the program's own band."""
    measured = given.measured[name]
    components = min(band.shape[-1], measured.shape[-1])
    allowed = store_band(band[..., :components], given.formats[name], components)
    inside = allowed.contains(measured[..., :components])[kept]
    survey.values += inside.size
    outside = int((~inside).sum())
    if outside:
        survey.outside[name] = outside
    vacuous = np.broadcast_to(allowed.vacuous, (given.count, components))[kept]
    if vacuous.any():
        survey.vacuous[name] = float(vacuous.mean())


def widths(
    evaluation: Evaluation, formula: Formula, given: Invocations, band: Band, survey: Survey
) -> dict[str, Any]:
    """The ratio of the widths of the program's band and of the formula's."""
    evaluation.gather(formula)
    subject = subject_of(formula, formula.given, evaluation.scene, evaluation.frame)
    rules = formula.rules or Rules()
    if rules != band.rules:
        again = interpret(
            given.program, given.each, given.bindings, Bands(rules), count=given.count
        )
        band = again.outputs[formula.own_name(evaluation.scene)]
    assert subject.covered is not None and given.pixels is not None
    number = np.cumsum(subject.covered.ravel()).reshape(subject.covered.shape) - 1
    rows = number[given.pixels[:, 1], given.pixels[:, 0]]
    part = subject.inputs.part(rows)
    parameters = match_parameters(formula.reference, subject.inputs)
    started = time.process_time()
    by_hand = evaluate(formula.reference, part, rules=rules, decimal=False, parameters=parameters)
    seconds = time.process_time() - started
    by_hand = Band.exact(0.0, rules).lift(by_hand)
    components = min(subject.measured.shape[-1], band.shape[-1])
    shape = (given.count, components)
    own = np.broadcast_to((band.hi - band.lo)[..., :components], shape)
    other = by_hand.hi - by_hand.lo
    other = np.broadcast_to(other[..., :components] if other.ndim else other, shape)
    with np.errstate(all="ignore"):
        usable = np.isfinite(own) & np.isfinite(other) & (other > 0.0)
        ratio = own[usable] / other[usable]
    return {
        "name": formula.name,
        "median": float(np.median(ratio)) if ratio.size else None,
        "worst": float(ratio.max()) if ratio.size else None,
        "exact_by_hand_only": int(((other == 0.0) & (own > 0.0)).sum()),
        "open_alone": int((~np.isfinite(own) & np.isfinite(other)).sum()),
        "seconds": seconds,
    }


def summary(found: list[Survey]) -> int:
    """Print the figures; 1 if the driver leaves a band."""
    done = [survey for survey in found if survey.status == "interpreted"]
    names = {(s.case, s.file) for s in found}
    missed = names - {(s.case, s.file) for s in done}
    print(f"{len(names) - len(missed)} of {len(names)} programs are interpreted")
    for why, count in Counter(s.status for s in found if s.status != "interpreted").most_common():
        cases = sorted({s.case for s in found if s.status == why})
        print(f"  {count} {why} ({', '.join(cases[:4])})")
    values, outside = sum(s.values for s in done), sum(sum(s.outside.values()) for s in done)
    print(f"{outside} of {values:,} values of the driver lie outside of the program's band")
    erred = [sum(s.adversary[i] for s in done) for i in (0, 1)]
    if erred[0]:
        print(f"{erred[1]} of {erred[0]:,} values of the adversary lie outside")
    for s in done:
        if s.outside:
            print(f"  {s.case} {s.variant} {s.draw} {s.file}: {s.outside}")
    for s in done:
        if any(share > 0.01 for share in s.vacuous.values()):
            print(f"  anything is allowed: {s.case} {s.variant} {s.draw} {s.file}: {s.vacuous}")
    formulas = [(s, f) for s in done for f in s.formulas]
    medians = np.array([f["median"] for _, f in formulas if f["median"] is not None])
    if medians.size:
        print(
            f"widths of {medians.size} formulas' outputs, of by hand: median "
            f"{np.median(medians):.3f}, {np.mean(medians <= 1.1):.1%} at most 1.1, "
            f"largest {medians.max():.2f}"
        )
        for s, f in sorted(formulas, key=lambda pair: -(pair[1]["median"] or 0.0)):
            if (f["median"] or 0.0) > 1.1:
                print(f"  {f['median']:.2f} {s.case} {s.variant} {s.draw} {f['name']}")
        for s, f in formulas:
            if f["open_alone"]:
                print(f"  no end: {f['open_alone']} {s.case} {s.variant} {s.draw} {f['name']}")
    by_hand = sum(f["seconds"] for _, f in formulas)
    compared = sum(s.seconds for s in done if s.formulas)
    if by_hand:
        print(
            f"cost: {sum(s.seconds for s in done):.1f} s in all; where formulas are, "
            f"{compared:.1f} s against their {by_hand:.1f} s: {compared / by_hand:.2f}"
        )
    return 1 if outside else 0


if __name__ == "__main__":
    sys.exit(main())
