"""value and computed: a printed figure follows from a reference in float64; for a value, the shader
must lie in its band, too."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any

from shaderlab.engine.expectations.formula import Formula, Reference, ReferenceExpectation, Sweep
from shaderlab.engine.expectations.needs import (
    CapturedFragments,
    Probe,
    decimal_inputs,
    find_image,
    inputs_of,
    pixel_inputs,
)
from shaderlab.engine.judging.banded import figure_row, format_value, judge_band, rounds_to
from shaderlab.engine.judging.references import evaluate, make_error
from shaderlab.errors import CaseError
from shaderlab.model.case import Scene
from shaderlab.model.checked import require_unmasked
from shaderlab.model.expectation import Expectation, Judgement, Need, Programs, Read
from shaderlab.model.frame import Array, Frame
from shaderlab.model.records import Row
from shaderlab.model.scene import Pixel, UniformValue

Figure = float | Sequence[float]


@dataclass(frozen=True)
class Value(ReferenceExpectation):
    """A figure as printed (rounded to `digits` decimals) holds for the formula and the shader.

    `at` gives some inputs by name (the others stay as the case has them) and the program is run
    once more on exactly these; or it is a Pixel of the frame. The reference is that of the
    case's `formula` of the same output unless given. In float64, on the decimal inputs, it must
    round to the figure; the shader, on the float32 ones, must lie in its band.
    """

    kind = "value"

    output: str
    _: KW_ONLY
    reference: Reference | None = None
    equals: Figure
    digits: int
    at: Mapping[str, UniformValue] | Pixel
    note: str = ""

    def __post_init__(self) -> None:
        if self.digits < 0:
            raise CaseError(f"value of {self.output!r}: digits must not be negative")

    def find_reads(self, scene: Scene) -> Iterable[Read]:
        pixel = self.at if isinstance(self.at, Pixel) else None
        for read in super().find_reads(scene):
            yield replace(read, pixel=pixel)

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        self.require_read(self._reference(scene))
        if not isinstance(self.at, Pixel):
            self.is_of_vertex(scene, programs)  # raises where there is no such output
            yield Probe(self, [dict(self.at)])
            return
        if not self.is_of_depth(scene, programs):
            self.is_of_vertex(scene, programs)
        yield CapturedFragments(self.key(scene))

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        key, format = self.key(scene), "rgba32f"
        decimal: Mapping[str, Array]
        if isinstance(self.at, Pixel):
            image = find_image(self.output, scene, frame)
            x, y, (height, width) = self.at.x, self.at.y, image.values.shape[:2]
            if not (0 <= x < width and 0 <= y < height):
                raise CaseError(f"{self.at} lies outside the {width} × {height} target")
            measured, format = image.values[y, x][None], image.format
            each = {n: v[y, x][None] for n, v in pixel_inputs(frame, key, image).items()}
            number = y * image.values.shape[1] + x
            decimal = {n: v[number][None] for n, v in decimal_inputs(frame, key, each).items()}
        else:
            samples = frame.answer(Probe(self))
            measured = samples.outputs[self.own_name(scene)]
            each, decimal = dict(samples.inputs), samples.decimal
        reference = self._reference(scene)
        if reference is None:
            ok = rounds_to(measured[0], self.equals, self.digits)
            row = self._row(measured[0], measured[0], ok)
            message = "" if ok else f"measured {format_value(measured[0])}"
            return self.judge_rows([row], message, judged=measured.size)
        inputs = inputs_of(frame, key, each=each, given=self.given, decimal=decimal)
        banded = judge_band(measured, reference, inputs, rules=self.rules, format=format)
        computed = evaluate(reference, inputs, rules=None, decimal=True)
        status, message = banded.verdict()
        if not rounds_to(computed, self.equals, self.digits):
            status = "fail"
            message = f"the reference gives {format_value(computed, self.digits + 3)}"
        row = self._row(computed, banded.measured[0], status == "pass")
        asked = message and isinstance(self.at, Pixel)
        if asked and not frame.answer(CapturedFragments(key)).covered[y, x]:
            message += "\n→ the draw does not cover this pixel"
        return self.judgement(scene, banded, (status, message), [row], rows_show_worst=True)

    def _reference(self, scene: Scene) -> Any:
        if self.reference is not None:
            return self.reference
        for other in scene.expect:
            if isinstance(other, Formula | Sweep) and other.output == self.output:
                return other.reference
        return None

    def _row(self, computed: Any, measured: Any, ok: bool) -> Row:
        if isinstance(self.at, Pixel):
            where = f"pixel ({self.at.x}, {self.at.y})"
        else:
            where = ", ".join(f"{k} = {format_value(v)}" for k, v in self.at.items())
        named = self.name != self.output
        label = f"{self.name} ({where})" if named else f"{self.name} at {where}"
        return figure_row(label, self.equals, self.digits, computed, measured, ok, self.note)


@dataclass(frozen=True)
class Computed(Expectation):
    """A figure that follows from a reference alone: what `compute` gives in float64, rounded to
    `digits` decimals, is `equals`."""

    kind = "computed"
    once = True

    name: str
    compute: Callable[[], Any]
    _: KW_ONLY
    equals: Figure
    digits: int
    note: str = ""

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        try:
            got = self.compute()
        except Exception as error:
            message = f"{self.name}: {type(error).__name__}: {error}"
            raise make_error(self.compute, message) from error
        require_unmasked(got, f"{self.name}: what it computes")
        ok = rounds_to(got, self.equals, self.digits)
        note = self.note or "float64, no shader"
        row = figure_row(self.name, self.equals, self.digits, got, None, ok, note)
        message = "" if ok else f"the reference gives {format_value(got, self.digits + 3)}"
        return self.judge_rows([row], message, judged=1, rows_per_variant=False)


value = Value
computed = Computed
