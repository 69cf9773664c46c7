"""Fixed-function state of a draw, under OpenGL's own names in lower case.

Every enumerated word is checked when the state is made, so a misspelt one fails where it was
written and not where the driver meets it. Defaults are OpenGL's, with one test at a time off.
Rectangles are (x, y, width, height) in pixels, from the target's lower left corner.
"""

import math
from dataclasses import dataclass

from shaderlab.errors import CaseError, suggest
from shaderlab.model.checked import Checked

COMPARISONS = (
    "never", "less", "equal", "lequal", "greater", "notequal", "gequal", "always",
)  # fmt: skip
STENCIL_OPERATIONS = (
    "keep", "zero", "replace", "incr", "decr", "invert", "incr_wrap", "decr_wrap",
)  # fmt: skip
BLEND_EQUATIONS = ("add", "subtract", "reverse_subtract", "min", "max")
BLEND_FACTORS = (
    "zero", "one",
    "src_color", "one_minus_src_color", "dst_color", "one_minus_dst_color",
    "src_alpha", "one_minus_src_alpha", "dst_alpha", "one_minus_dst_alpha",
    "constant_color", "one_minus_constant_color", "constant_alpha", "one_minus_constant_alpha",
    "src_alpha_saturate",
)  # fmt: skip
FACES = ("front", "back", "front_and_back")
WINDINGS = ("ccw", "cw")

Rectangle = tuple[int, int, int, int]


def check_choice(owner: str, field: str, word: str, choices: tuple[str, ...]) -> None:
    """Raise CaseError unless `word` is one of `choices`."""
    if word not in choices:
        raise CaseError(
            f"{owner}: {field} is {word!r}",
            remedy=suggest(word, choices) if isinstance(word, str) else f"one of {choices}",
        )


@dataclass(frozen=True, kw_only=True)
class Depth(Checked):
    """The depth test: passes where `incoming func stored`; `write` is the depth mask."""

    func: str = "less"
    write: bool = True

    def __post_init__(self) -> None:
        check_choice("Depth", "func", self.func, COMPARISONS)


@dataclass(frozen=True, kw_only=True)
class Stencil(Checked):
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
        check_choice("Stencil", "func", self.func, COMPARISONS)
        for field in ("fail", "depth_fail", "depth_pass"):
            check_choice("Stencil", field, getattr(self, field), STENCIL_OPERATIONS)
        for field in ("reference", "mask", "write_mask"):
            if not 0 <= getattr(self, field) <= 0xFF:
                raise CaseError(f"Stencil: {field} must lie in 0…255, not {getattr(self, field)}")


@dataclass(frozen=True, kw_only=True)
class Blend(Checked):
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
                check_choice("Blend", field, word, BLEND_FACTORS)
        check_choice("Blend", "equation", self.equation, BLEND_EQUATIONS)
        if self.equation_alpha is not None:
            check_choice("Blend", "equation_alpha", self.equation_alpha, BLEND_EQUATIONS)


@dataclass(frozen=True, kw_only=True)
class Cell(Checked):
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

    def rectangle(self, size: tuple[int, int]) -> Rectangle:
        """The cell's pixels in a target of `size`; neighbouring cells share no pixel and no gap.

        >>> Cell(column=1, row=0, columns=3, rows=8).rectangle((64, 64))
        (21, 0, 21, 8)
        """
        x, right = (size[0] * k // self.columns for k in (self.column, self.column + 1))
        y, top = (size[1] * k // self.rows for k in (self.row, self.row + 1))
        return x, y, right - x, top - y


@dataclass(frozen=True, kw_only=True)
class State(Checked):
    """All fixed-function state of one draw. None turns that test or stage off.

    Attributes:
        depth, stencil, blend: the tests and the blending; a depth test that is off writes nothing.
        stencil_back: the stencil test of faces that look away, where it differs from `stencil`.
        cull, front_face: which faces are dropped, and which winding looks this way.
        color_mask: which channels are written.
        cell: one cell of a grid over the target; takes the place of `viewport` and `scissor`.
        srgb: whether colours are encoded for attachments that hold sRGB.
        viewport: the rectangle that device coordinates from −1 to 1 are laid over; None is the
            whole target.
        scissor: the rectangle outside which nothing is drawn; None turns the test off.
        depth_range: window depths of the near and the far plane, each 0…1.
        polygon_offset: (factor, units), added to a triangle's depth: factor times its steepest
            slope, and units of the smallest step that the depth buffer can tell.
        point_size: a point's diameter in pixels, or "program" for what gl_PointSize says; None is
            the program's size where the shader writes one, and else a pixel.
        multisample: whether a target with several samples a pixel is covered sample by sample.
        sample_shading: the least share (0…1) of a pixel's samples that are shaded one by one.
        alpha_to_coverage: whether a fragment's alpha thins out the samples it covers.
    """

    depth: Depth | None = None
    stencil: Stencil | None = None
    stencil_back: Stencil | None = None
    blend: Blend | None = None
    cull: str | None = None
    front_face: str = "ccw"
    color_mask: tuple[bool, bool, bool, bool] = (True, True, True, True)
    cell: Cell | None = None
    srgb: bool = False
    viewport: Rectangle | None = None
    scissor: Rectangle | None = None
    depth_range: tuple[float, float] = (0.0, 1.0)
    polygon_offset: tuple[float, float] | None = None
    point_size: float | str | None = None
    multisample: bool = True
    sample_shading: float | None = None
    alpha_to_coverage: bool = False

    def __post_init__(self) -> None:
        check_choice("State", "front_face", self.front_face, WINDINGS)
        if self.cull is not None:
            check_choice("State", "cull", self.cull, FACES)
        if self.stencil_back is not None and self.stencil is None:
            raise CaseError(
                "State: stencil_back without stencil",
                remedy="give stencil= for front faces as well; one test is on for both or neither",
            )
        for field in ("viewport", "scissor"):
            box = getattr(self, field)
            if box is not None:
                _check_rectangle(field, box)
            if box is not None and self.cell is not None:
                raise CaseError(f"State: {field} and cell both confine the draw; give one of them")
        if isinstance(self.point_size, str):
            check_choice("State", "point_size", self.point_size, ("program",))
        elif self.point_size is not None and not 0.0 < self.point_size < math.inf:
            raise CaseError(f"State: point_size must be above 0, not {self.point_size}")
        _check_shares("depth_range", self.depth_range)
        _check_pair("depth_range", self.depth_range)
        _check_shares("sample_shading", (self.sample_shading or 0.0,))
        if self.polygon_offset is not None:
            _check_pair("polygon_offset", self.polygon_offset)

    @property
    def in_pixels(self) -> str:
        """The first field that counts pixels from the target's corner; "" if there is none."""
        return next((f for f in ("viewport", "scissor") if getattr(self, f) is not None), "")


def _check_rectangle(field: str, box: Rectangle) -> None:
    if len(box) != 4 or not all(isinstance(n, int) for n in box) or min(box[2:]) < 0:
        raise CaseError(f"State: {field} is {box!r}", remedy="whole pixels: (x, y, width, height)")


def _check_shares(field: str, values: tuple[float, ...]) -> None:
    if not all(0.0 <= v <= 1.0 for v in values):
        given = values if len(values) > 1 else values[0]
        raise CaseError(f"State: {field} must lie in 0…1, not {given}")


def _check_pair(field: str, pair: tuple[float, float]) -> None:
    if len(pair) != 2 or not all(math.isfinite(v) for v in pair):
        raise CaseError(f"State: {field} takes two numbers, not {pair!r}")
