"""Each draw held against its own shader's band: whether the driver draws what the shader says.

A formula looks at one draw's output. This looks at all of them, by interpreting their modules: a
driver that miscompiles a shader is caught even where no formula is. A shader that is wrong in
itself is not.
"""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from shaderlab.bands import Band
from shaderlab.compiler.sources import Source
from shaderlab.errors import ShaderlabError
from shaderlab.evaluation.evaluation import Evaluation
from shaderlab.evaluation.interpreting import Invocations, fragments
from shaderlab.expectations import judge_rows
from shaderlab.expectations.needs import CapturedFragments
from shaderlab.frame import PassDraw
from shaderlab.interpreter import Bands, interpret
from shaderlab.interpreter.memory import Flags
from shaderlab.judging.formats import stored
from shaderlab.model import Judgement
from shaderlab.records import Row

PIXELS = 256
"""Of each draw, whole quads from all over the picture."""
DRAWS = 4
"""Of each program, in a scene."""
_MOST_BLOCKS = 10_000
_NAME = "each draw is what its shader says"


def judge_modules(evaluation: Evaluation) -> Judgement:
    """Whether the driver drew, at some pixels of each draw, what its fragment shader allows; asked
    while the scene is on the device."""
    rows, judged, message = [], 0, ""
    for key in _keys(evaluation):
        need = CapturedFragments(key)
        known = need in evaluation.answers
        try:
            given, outputs = _interpreted(evaluation, key)
            wrong = {name: outside(given, name, band) for name, band in outputs.items()}
        except ShaderlabError as error:
            rows.append(_row(key, "", error.message.partition("\n")[0], ok=True))
            continue
        finally:
            if not known:  # of many draws, all are more than fits into memory
                evaluation.answers.pop(need, None)
        for name, flags in wrong.items():
            if flags is None:
                continue
            judged += given.count
            measured = f"{flags.sum()} of {given.count} pixels outside"
            rows.append(_row(key, name, measured, ok=not flags.any()))
            if flags.any() and not message:
                message = _message(given, key, name, int(flags.argmax()), outputs[name])
    return judge_rows(_NAME, "module", rows, message, judged=judged)


def _interpreted(evaluation: Evaluation, key: PassDraw) -> tuple[Invocations, Mapping[str, Any]]:
    given = fragments(evaluation, key, PIXELS)
    if not given.count:
        return given, {}
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        result = interpret(
            given.program, given.each, given.bindings, Bands(),
            count=given.count, blocks=_MOST_BLOCKS,
        )  # fmt: skip
    return given, result.outputs


def shows_what_is_written(evaluation: Evaluation, key: PassDraw) -> bool:
    """Whether attachments hold what a draw's shader wrote, and nothing else."""
    state = evaluation.programs[key[0]][key[1]].draw.state
    target = evaluation.scene.find_pass(key[0]).target
    return not (state.blend or state.srgb or target.samples) and all(state.color_mask)


def outside(given: Invocations, name: str, band: Any) -> Flags | None:
    """Where an output that was read back lies outside of its band; None where it can't be told."""
    if name not in given.measured or not isinstance(band, Band) or band.ndim != 2:
        return None
    measured = given.measured[name]
    components = min(measured.shape[-1], band.shape[-1])
    allowed = stored(band[:, :components], given.formats[name], components)
    found: Flags = np.asarray(~allowed.contains(measured[:, :components]).all(axis=-1))
    return found


def _keys(evaluation: Evaluation) -> Iterator[PassDraw]:
    """The draws that are judged: some of each program."""
    taken = Counter[tuple[Source, ...]]()
    for name, draws in evaluation.programs.items():
        for i, draw in enumerate(draws):
            if draw.sources[-1].stage not in ("fragment", "compute"):
                continue
            if shows_what_is_written(evaluation, (name, i)) and taken[draw.sources] < DRAWS:
                taken[draw.sources] += 1
                yield name, i


def _row(key: PassDraw, name: str, measured: str, *, ok: bool) -> Row:
    label = f"draw {key[1]} of pass {key[0]!r}" + (f", {name}" if name else "")
    return Row(label=label, expected="inside the band of its module", measured=measured, ok=ok)


def _message(given: Invocations, key: PassDraw, name: str, row: int, band: Band) -> str:
    assert given.pixels is not None
    x, y = (int(v) for v in given.pixels[row])
    values = ", ".join(f"{v:.9g}" for v in given.measured[name][row])
    allowed = ", ".join(
        f"{low:.9g} … {high:.9g}" for low, high in zip(band.lo[row], band.hi[row], strict=True)
    )
    return (
        f"draw {key[1]} of pass {key[0]!r} leaves what its shader allows: {name} is {values} at "
        f"pixel ({x}, {y}), allowed {allowed}"
    )
