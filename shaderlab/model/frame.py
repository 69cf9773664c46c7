"""What running a case gave: named arrays, nothing that still needs a device.

Pictures have shape (height, width, components), row 0 at the bottom, column 0 at the left, so
that `values[y, x]` is the pixel whose centre is (x + 0.5, y + 0.5) in window coordinates.
Everything that a shader read is here too, as the very values it got: float32 for floats, integer
arrays for integers. Single numbers keep a last axis of one component.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
PassDraw = tuple[str, int]
_PLACES = 64


def differ(one: Array, other: Array) -> bool:
    """Whether two arrays differ in any bit; one NaN is as good as another."""
    if one.shape != other.shape or one.dtype != other.dtype:
        return True
    if one.dtype.kind != "f":
        return not np.array_equal(one, other)
    same = (one == other) & (np.signbit(one) == np.signbit(other))
    return not bool((same | (np.isnan(one) & np.isnan(other))).all())


def every_component(holds: Array) -> Array:
    """Where something holds of all of a value's components, (…, components) → (…).

    NumPy takes ten times as long to reduce a last axis of four.

    >>> every_component(np.array([[True, True], [True, False]])).tolist()
    [True, False]
    """
    found: Array = np.ones(holds.shape[:-1], np.bool_)
    for component in range(holds.shape[-1]):
        found &= holds[..., component]
    return found


def leading(values: Array, count: int) -> Array:
    """Copy the first components of each value, (…, components) → (…, count): the copy is no larger
    than needed and contiguous, as the compiled kernels take it.

    NumPy takes ten times as long to copy all at once.

    >>> leading(np.array([[1, 2, 3], [4, 5, 6]]), 2).tolist()
    [[1, 2], [4, 5]]
    """
    if values.shape[-1] == count:
        return values
    found = np.empty((*values.shape[:-1], count), values.dtype)
    for component in range(count):
        found[..., component] = values[..., component]
    return found


@dataclass(frozen=True)
class Image:
    """One attachment, read back in its own components and type; `format` as in `Target`.

    `layers` is how many layers lie one above the other, where a dispatch wrote an image that has
    some; else 0.
    """

    values: Array
    format: str
    layers: int = 0


@dataclass(frozen=True, kw_only=True, eq=False)
class Fragments:
    """What one draw's fragment shader got, at each pixel where it was the last to write.

    `covered` has shape (height, width); `inputs` and `frag_coord` (x, y, z, 1/w) have one more
    axis and mean something only where `covered` is true; but 1/w is negative where another draw of
    the pass is seen, and 0 where none is. `undiscarded` is what the shader would get if it kept
    every fragment, at the depth that it comes with; None for one that does.
    """

    covered: npt.NDArray[np.bool_]
    frag_coord: Array
    inputs: Mapping[str, Array]
    undiscarded: "Fragments | None" = None

    @cached_property
    def misplaced(self) -> str:
        """Where `gl_FragCoord` lies outside of its pixel, in words, or "": all that was judged by
        it was judged at another place. Looks at `_PLACES` of the fragments, the last among them."""
        pixels = np.flatnonzero(self.covered)
        some = pixels[:: -max(len(pixels) // _PLACES, 1)]
        at = np.stack(np.unravel_index(some, self.covered.shape)[::-1], axis=-1)
        said = self.frag_coord[at[:, 1], at[:, 0], :2]
        wrong = ~((said >= at) & (said <= at + 1)).all(axis=-1)
        if not wrong.any():
            return ""
        (x, y), (x_said, y_said) = at[wrong][-1], said[wrong][-1]
        return f"the driver is wrong: gl_FragCoord is ({x_said:g}, {y_said:g}) at pixel ({x}, {y})"


@dataclass(frozen=True, kw_only=True)
class Samples:
    """Inputs and outputs of single invocations: vertices, or a program run on given inputs.

    All arrays have shape (count, components). `decimal` holds inputs as the case writes them,
    in float64, before they were rounded to float32. `discarded` is how many of them wrote nothing.
    `entering` are the vertices that a geometry stage's primitives are made of, as their own stage
    got and gave them.
    """

    inputs: Mapping[str, Array]
    outputs: Mapping[str, Array]
    decimal: Mapping[str, Array] = field(default_factory=dict)
    discarded: int = 0
    entering: "Samples | None" = None

    def of_output(self, name: str) -> "Samples":
        """The invocations that gave this output: these, or those of the stage before."""
        return self if self.entering is None or name in self.outputs else self.entering


@dataclass(frozen=True)
class Texels:
    """A texture's contents as exact values, and how it is sampled.

    Attributes:
        values: the largest level: (height, width, channels), or with one more axis in front the
            layers of an array or of a texture in three dimensions, the faces of a cube, the samples
            of a multisampled texture.
        filter, wrap, border, compare, lod: as in `shaderlab.model.Texture`.
        kind: what comes after "sampler" in GLSL, without "Shadow": "2D", "2DArray", "3D", "Cube",
            "2DMS"; or after "image": "2D", "2DArray", "3D".
        format: the texture's format; 8-bit texels are codes.
        smaller: the mipmap levels below the largest one, if there are any.
        seamless: whether a cube's filters reach over its edges.
    """

    values: Array
    filter: tuple[str, str]
    wrap: tuple[str, ...]
    border: tuple[float, float, float, float]
    kind: str = field(default="2D", kw_only=True)
    format: str = field(default="rgba32f", kw_only=True)
    smaller: tuple[Array, ...] = field(default=(), kw_only=True)
    compare: str | None = field(default=None, kw_only=True)
    lod: tuple[float, float] = field(default=(-1000.0, 1000.0), kw_only=True)
    seamless: bool = field(default=True, kw_only=True)


@dataclass(frozen=True, kw_only=True)
class Bindings:
    """The uniforms and textures of one draw, by GLSL name.

    `uniforms` are the float32 or integer values that the shader got, `decimal` the float64 values
    that the case wrote; `arrays` names those that are GLSL arrays (their first axis counts).
    `buffers` are what the members of a dispatch's storage blocks held before it, `images` what its
    images did.
    """

    uniforms: Mapping[str, Array] = field(default_factory=dict)
    decimal: Mapping[str, Array] = field(default_factory=dict)
    textures: Mapping[str, Texels] = field(default_factory=dict)
    arrays: frozenset[str] = frozenset()
    buffers: Mapping[str, Array] = field(default_factory=dict)
    images: Mapping[str, Texels] = field(default_factory=dict)

    @property
    def computes(self) -> bool:
        """Whether it is a dispatch that they are bound for."""
        return bool(self.buffers or self.images)


@dataclass(frozen=True, kw_only=True)
class Reply:
    """What the API said to a call.

    `errors` are those that the call `at` raised: the last one, or the first before it that raised
    any. `wanted` are the values asked for and `returned` as many that came, names of constants
    resolved; `names` has such a constant's name for each of its numbers.
    """

    errors: tuple[int, ...]
    at: str
    wanted: tuple[Any, ...] = ()
    returned: tuple[Any, ...] = ()
    names: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True)
class AttributeReading:
    """Where OpenGL says that an attribute lies: `offset` bytes into the mesh's buffer number
    `buffer`, a vertex every `stride` bytes, a new value every `divisor` instances (0: a vertex)."""

    buffer: int
    offset: int
    stride: int
    divisor: int


@dataclass(frozen=True)
class BlockReading:
    """Where OpenGL says that a uniform block's members lie, and the block's size, in bytes; and
    the same as the lab has `placed` them. A block without any effect has no offsets."""

    offsets: Mapping[str, int]
    size: int
    placed: Mapping[str, int]
    placed_size: int


@dataclass(frozen=True, kw_only=True)
class Timing:
    """What drawing one pass took: draw calls, vertices that were submitted (over all instances),
    and the seconds of each repetition."""

    draw_calls: int
    vertices: int
    seconds: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class TracedCall:
    """A call of the API that drawing a scene took: in which pass and for which draw of it (None for
    its target), and each argument by its parameter's name, as text: constants by their names.
    `returned` is the number of the object that it made, "" for none. A call that is not `effective`
    sets what is set already, or what counts for nothing at that moment. `state` is a digest of all
    state that a call finds which does more than set state; "" for others."""

    pass_name: str
    draw: int | None
    function: str
    arguments: Mapping[str, str]
    returned: str = ""
    effective: bool = True
    state: str = ""

    def __str__(self) -> str:
        called = f"{self.function}({', '.join(self.arguments.values())})"
        return f"{called} → {self.returned}" if self.returned else called


Programs = Mapping[str, tuple[Any, ...]]
"""The compiled draws of each pass: `shaderlab.drivers.programs.PreparedDraw`."""
Answer = TypeVar("Answer")


class Need(ABC):
    """What an expectation needs beyond the pictures. Equal needs are answered once a scene."""

    @abstractmethod
    def answer(self, context: Any) -> Any:
        """Ask the device or the compilers, given a `shaderlab.engine.expectations.base.Context`.
        Raises ShaderlabError: there is no answer."""

    def has_same_answer(self, programs: Programs, others: Programs) -> bool:
        """Whether the answer must be the same for the same scene with `others` for its programs.
        False where that is unknown."""
        return False


class TypedNeed(Need, Generic[Answer]):
    """A need whose answer has a known type: a `TypedNeed[Samples]` is answered by samples."""

    @abstractmethod
    def answer(self, context: Any) -> Answer: ...


@dataclass(frozen=True, kw_only=True)
class Frame:
    """All that one scene gave.

    Attributes:
        images: attachments by (pass, output).
        order: the passes' names in the order they ran.
        bindings: uniforms and textures by (pass, draw).
        sample_positions: where the driver takes a pixel's samples, by pass, for passes that have
            several: (samples, 2), from the pixel's lower left corner, 0…1.
        subpixel_step: the grid that corners are moved to before they are rasterised, in pixels.
        vendor: whose driver it is, in the driver's own words.
        answers: what else expectations need, by their needs: captured inputs, probes,
            counts, layouts, verdicts; read by `answer`.
    """

    images: Mapping[tuple[str, str], Image]
    order: tuple[str, ...]
    bindings: Mapping[PassDraw, Bindings]
    sample_positions: Mapping[str, Array] = field(default_factory=dict)
    subpixel_step: float = 2.0**-8
    vendor: str = ""
    answers: Mapping[Need, Any] = field(default_factory=dict)

    def answer(self, need: TypedNeed[Answer]) -> Answer:
        """Return the answer to a need. Raises KeyError if the expectation did not name it."""
        found: Answer = self.answers[need]
        return found
