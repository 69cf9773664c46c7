"""Falsified outputs: what a driver may get wrong before anything notices.

`python -m benchmarks.falsified [CASE…] [--pattern NAME] [--found FILE]` has the driver draw every
output of every fragment shader of the shipped cases wrongly, one at a time, while formulas and
modules keep to the shader's own text:

- constant: .37 everywhere; scaled: everything times 1.002;
- sparse, single: one pixel in 16 or in 256 is wrong by .25; nan: one in 256 is NaN.

The pixels are those of a lattice that the draw shows most of. It prints what goes unnoticed and the
sums: noticed by an expectation, or only by the module of the shader. What changes no pixel that any
pass draws (1.002 times 0, or by less than the attachment stores) counts by itself, and so does what
no expectation reads where the module can't be interpreted. The exit status is 1 where anything else
goes unnoticed. `--found` keeps a line of JSON for each case; cases that it has are not drawn again.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.shipped import load_cases
from shaderlab.analysis.self_check import SelfCheck
from shaderlab.drivers.programs.prepare import PreparedDraw, Programs
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.needs import CapturedFragments
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import ShaderlabError
from shaderlab.model.case import Case, Scene
from shaderlab.model.expectation import Expectation
from shaderlab.model.frame import Image

STEPS = {"constant": 1, "scaled": 1, "sparse": 4, "single": 16, "nan": 16}
"""How far apart falsified pixels are, in either direction."""
WRONG = {
    "constant": ("{kind}(0.37)", "{kind}(3)"),
    "scaled": ("{output} * 1.002", "{output} + {kind}(1)"),
    "sparse": ("{output} + {kind}(0.25)", "{output} + {kind}(1)"),
    "single": ("{output} + {kind}(0.25)", "{output} + {kind}(1)"),
    "nan": ("{kind}(uintBitsToFloat(0x7fc00000u))", "{output} + {kind}(1)"),
}
"""What they get, of floats and of integers."""
Fates = list[tuple[str, str, str]]
"""The names of outputs, how each is falsified, and what notices it."""
Drawn = tuple[Programs, dict[tuple[str, str], Image], dict[tuple[str, int], np.ndarray]]


def falsify(text: str, output: str, kind: str, pattern: str, at: tuple[int, int]) -> str:
    """A fragment shader's text in which some pixels of an output are wrong."""
    step = STEPS[pattern]
    wrong = WRONG[pattern][kind.startswith(("i", "u"))].format(kind=kind, output=output)
    text = re.sub(r"^(#version\s+)3[03]0", r"\g<1>400", text, flags=re.M)  # uintBitsToFloat
    own = re.sub(r"\bvoid\s+main\s*\(", "void shownMain(", text)
    return (
        f"{own}\nvoid main() {{\n  shownMain();\n  ivec2 at = ivec2(gl_FragCoord.xy) % {step};\n"
        f"  if (at == ivec2({at[0]}, {at[1]})) {output} = {wrong};\n}}\n"
    )


def shaders_of(programs: Programs) -> dict[tuple[str, str], list[tuple[str, int]]]:
    """The draws of each output of each fragment shader: by its text and the output's name."""
    found: dict[tuple[str, str], list[tuple[str, int]]] = {}
    for name, draws in programs.items():
        for i, draw in enumerate(draws):
            if not draw.draw.compute:
                for output in draw.interface.outputs:
                    found.setdefault((draw.text("fragment"), output), []).append((name, i))
    return found


def lattice(covered: list[np.ndarray], step: int) -> tuple[int, int] | None:
    """Where a lattice of this step shows the most pixels; None where nothing is drawn."""
    counts = np.zeros((step, step), np.int64)
    for one in covered:
        y, x = np.nonzero(one)
        np.add.at(counts, (y % step, x % step), 1)
    y, x = np.unravel_index(counts.argmax(), counts.shape)
    return (int(x), int(y)) if counts.max() else None


def draw_scene(lab: SceneRunner, scene: Scene) -> Drawn:
    """A scene's programs, its pictures, and what each draw covers."""
    programs = lab.prepare_for_opengl(scene)
    covered = {}
    with lab.evaluation(scene, programs) as evaluation:
        for draws in shaders_of(programs).values():
            for key in draws:
                if key not in covered:
                    try:
                        fragments = evaluation.answer(CapturedFragments(key))
                    except ShaderlabError:
                        continue
                    covered[key] = fragments.covered
                    del evaluation.answers[CapturedFragments(key)]
        return programs, dict(evaluation.drawn.images), covered


def find_noticing(evaluation: Evaluation, keys: list[tuple[str, int]]) -> str:
    """What notices that these draws are wrong: "expectation", "module", or "" for nothing."""

    def asks_elsewhere(expectation: Expectation) -> bool:
        needs = expectation.needs(evaluation.scene, evaluation.programs)
        return not any(getattr(need, "key", None) in keys for need in needs)

    try:
        for expectation in sorted(evaluation.scene.expect, key=asks_elsewhere):
            if evaluation.judge(expectation).outcome.status == "fail":
                return "expectation"
            evaluation.forget(list(evaluation.answers))
    except ShaderlabError:
        return "expectation"
    _, judgement = SelfCheck(evaluation).judgement()
    return "module" if judgement.outcome.status == "fail" else ""


def judge(lab: SceneRunner, scene: Scene, drawn: Drawn, shader: tuple[str, str], how: str) -> str:
    """What notices an output of a shader falsified; "no effect" where no picture changes."""
    programs, images, covered = drawn
    keys = shaders_of(programs)[shader]
    at = lattice([covered[key] for key in keys if key in covered], STEPS[how])
    if at is None:
        return "no effect"
    kind = programs[keys[0][0]][keys[0][1]].interface.outputs[shader[1]].type
    text = falsify(*shader, kind, how, at)

    def changed(name: str, i: int, draw: PreparedDraw) -> PreparedDraw:
        same = (name, i) not in keys
        return draw if same else replace(draw, rewritten={**draw.texts, "fragment": text})

    wrong = {n: tuple(changed(n, i, d) for i, d in enumerate(ds)) for n, ds in programs.items()}
    try:
        with lab.evaluation(scene, wrong) as evaluation:
            pictures = evaluation.drawn.images
            if all(np.array_equal(pictures[n].values, images[n].values) for n in images):
                return "no effect"
            return find_noticing(evaluation, keys)
    except ShaderlabError as error:
        return f"error: {error.message}"


def judge_case(lab: SceneRunner, case: Case, hows: list[str]) -> Iterator[tuple[str, str, str]]:
    """The name of each output, how it is falsified, and what notices it in any variant."""
    fates: dict[tuple[str, str, str], tuple[str, str]] = {}
    for scene in case.scenes():
        drawn = draw_scene(lab, scene)
        for shader, keys in shaders_of(drawn[0]).items():
            name = drawn[0][keys[0][0]][keys[0][1]].draw.fragment
            for how in hows:
                before = fates.get((*shader, how), ("", "no effect"))[1]
                if before in ("no effect", ""):
                    fate = judge(lab, scene, drawn, shader, how)
                    fates[(*shader, how)] = (
                        f"{name} {shader[1]}",
                        (fate if fate != "no effect" else before),
                    )
    for (_, _, how), (name, fate) in fates.items():
        yield name, how, fate


def find_all(cases: list[Case], hows: list[str], found: Path | None) -> Iterator[tuple[str, Fates]]:
    """What notices each output of each case, as the file says where it has one."""
    known: dict[str, Fates] = {}
    if found and found.exists():
        known = dict(json.loads(line) for line in found.read_text(encoding="utf-8").splitlines())
    with SceneRunner() as lab:
        for case in cases:
            if case.id not in known:
                known[case.id] = list(judge_case(lab, case, hows))
                if found:
                    with found.open("a", encoding="utf-8") as file:
                        file.write(json.dumps([case.id, known[case.id]]) + "\n")
            yield case.id, known[case.id]


def main(words: list[str] | None = None) -> int:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("cases", nargs="*", help="ids of cases; all by default")
    options.add_argument("--pattern", action="append", choices=STEPS, help="all by default")
    options.add_argument("--found", type=Path, help="a file of what was found, to go on from")
    given = options.parse_args(words)
    counts: dict[str, Counter[str]] = {}
    catalogue = load_cases()
    cases = [catalogue[name] for name in given.cases or catalogue]
    for case, fates in find_all(cases, given.pattern or list(STEPS), given.found):
        for name, how, fate in fates:
            counts.setdefault(how, Counter())[fate.partition(":")[0] or "unnoticed"] += 1
            if fate in ("", "module") or fate.startswith("error"):
                print(f"{case}: {name}: {how}: {fate or 'unnoticed'}", flush=True)
    for how, number in counts.items():
        print(f"{how}: " + ", ".join(f"{count} {fate}" for fate, count in number.items()))
    return 1 if any(number["unnoticed"] for number in counts.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
