"""Fixed-function state of a draw, under OpenGL's own names in lower case.

Every enumerated word is checked when the state is made, so a misspelt one fails where it was
written and not where the driver meets it. Defaults are OpenGL's, with one test at a time off.
"""

from __future__ import annotations

from dataclasses import dataclass

from shaderlab.errors import CaseError, nearest

COMPARISONS = (
    "never",
    "less",
    "equal",
    "lequal",
    "greater",
    "notequal",
    "gequal",
    "always",
)
STENCIL_OPERATIONS = (
    "keep",
    "zero",
    "replace",
    "incr",
    "incr_wrap",
    "decr",
    "decr_wrap",
    "invert",
)
BLEND_EQUATIONS = ("add", "subtract", "reverse_subtract", "min", "max")
BLEND_FACTORS = (
    "zero",
    "one",
    "src_color",
    "one_minus_src_color",
    "dst_color",
    "one_minus_dst_color",
    "src_alpha",
    "one_minus_src_alpha",
    "dst_alpha",
    "one_minus_dst_alpha",
    "constant_color",
    "one_minus_constant_color",
    "constant_alpha",
    "one_minus_constant_alpha",
    "src_alpha_saturate",
)
FACES = ("front", "back", "front_and_back")
WINDINGS = ("ccw", "cw")


def one_of(owner: str, field: str, word: str, choices: tuple[str, ...]) -> None:
    """Raise CaseError unless `word` is one of `choices`."""
    if word not in choices:
        raise CaseError(
            f"{owner}: {field} is {word!r}",
            remedy=nearest(word, choices) if isinstance(word, str) else f"one of {choices}",
        )


@dataclass(frozen=True, kw_only=True)
class Depth:
    """The depth test: passes where `incoming func stored`; `write` is the depth mask."""

    func: str = "less"
    write: bool = True

    def __post_init__(self) -> None:
        one_of("Depth", "func", self.func, COMPARISONS)


@dataclass(frozen=True, kw_only=True)
class Stencil:
    """The stencil test: passes where `(reference & mask) func (stored & mask)`.

    `fail`, `depth_fail` and `depth_pass` say what happens to the stored value then; only the
    bits in `write_mask` change. All values are 8 bits wide.
    """

    func: str = "always"
    reference: int = 0
    mask: int = 0xFF
    fail: str = "keep"
    depth_fail: str = "keep"
    depth_pass: str = "keep"
    write_mask: int = 0xFF

    def __post_init__(self) -> None:
        one_of("Stencil", "func", self.func, COMPARISONS)
        for field in ("fail", "depth_fail", "depth_pass"):
            one_of("Stencil", field, getattr(self, field), STENCIL_OPERATIONS)
        for field in ("reference", "mask", "write_mask"):
            if not 0 <= getattr(self, field) <= 0xFF:
                raise CaseError(f"Stencil: {field} must lie in 0…255, not {getattr(self, field)}")


@dataclass(frozen=True, kw_only=True)
class Blend:
    """Blending: `source·src ∘ destination·dst`, the alpha channel by its own factors if given."""

    source: str = "src_alpha"
    destination: str = "one_minus_src_alpha"
    source_alpha: str | None = None
    destination_alpha: str | None = None
    equation: str = "add"
    equation_alpha: str | None = None
    constant: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for field in ("source", "destination", "source_alpha", "destination_alpha"):
            word = getattr(self, field)
            if word is not None or not field.endswith("_alpha"):
                one_of("Blend", field, word, BLEND_FACTORS)
        one_of("Blend", "equation", self.equation, BLEND_EQUATIONS)
        if self.equation_alpha is not None:
            one_of("Blend", "equation_alpha", self.equation_alpha, BLEND_EQUATIONS)


@dataclass(frozen=True, kw_only=True)
class Cell:
    """Confines a draw to one cell of a `columns` × `rows` grid laid over the target.

    Column 0, row 0 is the lower left. Viewport and scissor are both set to the cell, so a whole
    truth table can be drawn into one target, each row with a state of its own.
    """

    column: int
    row: int
    columns: int
    rows: int

    def __post_init__(self) -> None:
        if not (0 <= self.column < self.columns and 0 <= self.row < self.rows):
            raise CaseError(
                f"Cell: ({self.column}, {self.row}) lies outside {self.columns} × {self.rows} cells"
            )


@dataclass(frozen=True, kw_only=True)
class State:
    """All fixed-function state of one draw. None turns that test or stage off."""

    depth: Depth | None = None
    stencil: Stencil | None = None
    blend: Blend | None = None
    cull: str | None = None
    front_face: str = "ccw"
    color_mask: tuple[bool, bool, bool, bool] = (True, True, True, True)
    cell: Cell | None = None
    srgb: bool = False

    def __post_init__(self) -> None:
        one_of("State", "front_face", self.front_face, WINDINGS)
        if self.cull is not None:
            one_of("State", "cull", self.cull, FACES)
