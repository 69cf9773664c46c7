"""Expectations: what must hold of a frame. Data only; `shaderlab.checks` judges them.

An output is named as the fragment shader spells it ("FragColor"), with its pass before it where
there are several ("shadow.FragColor"; without, the last pass is meant), or as the vertex shader
spells it ("gl_Position" or any of its `out` variables): then every vertex is judged.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from shaderlab.bands import Rules
from shaderlab.errors import CaseError
from shaderlab.model.calls import GL_ERRORS, GlCall
from shaderlab.model.counts import Cost, Query
from shaderlab.model.layouts import AttributeLayout, BlockLayout
from shaderlab.model.measure import Measure
from shaderlab.model.refusals import CompileFails, InactiveUniforms, Refused
from shaderlab.model.scene import UniformValue
from shaderlab.model.state import one_of
from shaderlab.model.textures import Output

Reference = Callable[..., Any]
Figure = float | Sequence[float]


@dataclass(frozen=True)
class Pixel:
    """A place in a frame: x to the right, y up, from (0, 0) at the lower left."""

    x: int
    y: int


@dataclass(frozen=True, kw_only=True)
class Formula:
    """Every covered pixel (or every vertex) lies in the reference's derived band."""

    output: str
    reference: Reference
    draw: int = -1
    given: Mapping[str, UniformValue] = field(default_factory=dict)
    also: Mapping[str, Reference] = field(default_factory=dict)
    rules: Rules | None = None
    name: str = ""


@dataclass(frozen=True, kw_only=True)
class Value:
    """A printed figure holds: for the reference in float64, and for the shader in its band."""

    output: str
    equals: Figure
    digits: int
    at: Mapping[str, UniformValue] | Pixel
    reference: Reference | None = None
    draw: int = -1
    given: Mapping[str, UniformValue] = field(default_factory=dict)
    rules: Rules | None = None
    name: str = ""
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """The band holds along one input, all others fixed; drawn as a curve in the report."""

    output: str
    reference: Reference
    over: str
    values: tuple[float, ...]
    at: Mapping[str, UniformValue] = field(default_factory=dict)
    draw: int = -1
    given: Mapping[str, UniformValue] = field(default_factory=dict)
    rules: Rules | None = None
    log_x: bool = False
    name: str = ""


@dataclass(frozen=True, kw_only=True)
class Property(Sweep):
    """A law that holds while inputs vary (see `shaderlab.model.laws`): a sweep that is judged
    without a reference. `steps` are the inputs of each run, by name."""

    reference: Any = None
    values: tuple[float, ...] = ()
    law: Any
    steps: tuple[Mapping[str, UniformValue], ...]


@dataclass(frozen=True, kw_only=True)
class Exact:
    """An output equals an array, or another pass's output, bit for bit, at every pixel.

    `pictured` says whether it is shown where that holds; where it does not, it always is.
    """

    output: str
    equals: Any
    name: str = ""
    pictured: bool = True


@dataclass(frozen=True, kw_only=True)
class Coverage:
    """Exactly this many pixels show a draw in the end."""

    pixels: int
    pass_name: str | None = None
    draw: int = -1
    name: str = ""


@dataclass(frozen=True, kw_only=True)
class Computed:
    """A printed figure that no shader draws follows from a Python reference."""

    label: str
    compute: Callable[[], Any]
    equals: Figure
    digits: int
    name: str = ""
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class GlError:
    """A draw raises this GL error, and nothing else does."""

    error: str
    pass_name: str | None = None
    draw: int = -1
    name: str = ""


Expectation = (
    Formula
    | Value
    | Sweep
    | Property
    | Measure
    | Exact
    | Coverage
    | Computed
    | CompileFails
    | GlError
    | GlCall
    | Query
    | Cost
    | AttributeLayout
    | BlockLayout
    | Refused
    | InactiveUniforms
)


def formula(
    output: str,
    reference: Reference,
    *,
    draw: int = -1,
    given: Mapping[str, UniformValue] | None = None,
    also: Mapping[str, Reference] | None = None,
    rules: Rules | None = None,
    name: str = "",
) -> Formula:
    """Every covered pixel (or vertex) of `output` lies in the band derived from `reference`.

    The reference's parameters are found by name: captured varyings (or attributes), uniforms
    (`light.constant` as `light_constant`), textures, `frag_coord`, and what `given` adds.

    Args:
        output: see the module's docstring.
        reference: a formula over float64 arrays and bands alike, built with `shaderlab.glslmath`.
        draw: which draw of the pass the inputs come from; the last by default.
        given: further inputs by name, as exact float32 values.
        also: independent implementations by name; in float64 each must lie in the band too.
        rules: other precision rules than the default ones.
        name: how outcomes call it; the output's name by default.
    """
    return Formula(
        output=output,
        reference=_callable("formula", reference),
        draw=draw,
        given=given or {},
        also={k: _callable("formula: also", v) for k, v in (also or {}).items()},
        rules=rules,
        name=name or output,
    )


def value(
    output: str,
    *,
    at: Mapping[str, UniformValue] | Pixel,
    equals: Figure,
    digits: int,
    reference: Reference | None = None,
    draw: int = -1,
    given: Mapping[str, UniformValue] | None = None,
    rules: Rules | None = None,
    name: str = "",
    note: str = "",
) -> Value:
    """A figure as printed (rounded to `digits` decimals) holds for the formula and the shader.

    `at` gives some inputs by name (the others stay as the case has them) and the program is run
    once more on exactly these; or it is a Pixel of the frame. The reference is that of the
    case's `formula` of the same output unless given. In float64, on the decimal inputs, it must
    round to the figure; the shader, on the float32 ones, must lie in its band.
    """
    if digits < 0:
        raise CaseError(f"value of {output!r}: digits must not be negative")
    return Value(
        output=output,
        equals=equals,
        digits=digits,
        at=at,
        reference=reference,
        draw=draw,
        given=given or {},
        rules=rules,
        name=name or output,
        note=note,
    )


def sweep(
    output: str,
    reference: Reference,
    *,
    over: str,
    values: Sequence[float],
    at: Mapping[str, UniformValue] | None = None,
    draw: int = -1,
    given: Mapping[str, UniformValue] | None = None,
    rules: Rules | None = None,
    log_x: bool = False,
    name: str = "",
) -> Sweep:
    """The band holds while the input `over` takes each of `values`; the report draws the curve."""
    return Sweep(
        output=output,
        reference=_callable("sweep", reference),
        over=over,
        values=tuple(float(v) for v in values),
        at=at or {},
        draw=draw,
        given=given or {},
        rules=rules,
        log_x=log_x,
        name=name or f"{output} over {over}",
    )


def exact(output: str, equals: Any, *, name: str = "", pictured: bool = True) -> Exact:
    """Every pixel of `output` equals `equals` bit for bit.

    `equals` is a number or vector, an array (height, width, components) with row 0 at the
    bottom (a smaller one is repeated in equal blocks, as a table's cells are), or an
    `Output(pass, name)` to be compared with. Without `pictured` it is shown only if it fails: for
    what each pass's own picture shows already.
    """
    return Exact(output=output, equals=equals, name=name or output, pictured=pictured)


def coverage(
    pixels: int, *, pass_name: str | None = None, draw: int = -1, name: str = ""
) -> Coverage:
    """Exactly `pixels` pixels show the draw in the end: those that it covers, that pass every test
    and are not discarded, and that no later draw of the pass covers."""
    return Coverage(pixels=pixels, pass_name=pass_name, draw=draw, name=name or "coverage")


def computed(
    label: str, compute: Callable[[], Any], *, equals: Figure, digits: int, note: str = ""
) -> Computed:
    """A figure that follows from a reference alone, in float64, rounded to `digits` decimals."""
    return Computed(
        label=label,
        compute=_callable("computed", compute),
        equals=equals,
        digits=digits,
        name=label,
        note=note,
    )


def gl_error(
    error: str, *, pass_name: str | None = None, draw: int = -1, name: str = ""
) -> GlError:
    """The draw raises this error ("invalid_operation", …); any other error fails the case."""
    one_of("gl_error", "error", error, tuple(GL_ERRORS))
    return GlError(error=error, pass_name=pass_name, draw=draw, name=name or f"GL {error}")


def output_of(name: str) -> Output | str:
    """Split "pass.output" into an Output; a bare name stays as it is."""
    pass_name, dot, output = name.rpartition(".")
    return Output(pass_name, output) if dot else name


def _callable(owner: str, reference: Any) -> Any:
    if not callable(reference):
        raise CaseError(f"{owner}: needs a Python function, not {type(reference).__name__}")
    return reference
