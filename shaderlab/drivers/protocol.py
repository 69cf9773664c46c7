"""What the lab asks of a graphics API: a device, and sessions on it that draw one scene each."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Container, Mapping, Sequence, Set
from contextlib import AbstractContextManager
from dataclasses import dataclass, field

from shaderlab.compiler.sources import Source
from shaderlab.errors import OtherApiError, UnsupportedError
from shaderlab.model.calls import Call, CallEdit
from shaderlab.model.case import Scene
from shaderlab.model.frame import (
    Array,
    AttributeReading,
    Bindings,
    BlockReading,
    Fragments,
    Image,
    PassDraw,
    Reply,
    Samples,
    Timing,
    TracedCall,
)
from shaderlab.model.records import Verdict
from shaderlab.model.scene import Pass
from shaderlab.model.textures import TextureSource

from .programs.prepare import Programs

Size = tuple[int, int]


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """What drawing a scene's passes gave, as in `Frame`; `inactive` are the uniforms without any
    effect."""

    images: Mapping[tuple[str, str], Image]
    bindings: Mapping[PassDraw, Bindings]
    gl_errors: Mapping[PassDraw, tuple[int, ...]] = field(default_factory=dict)
    inactive: frozenset[str] = field(default_factory=frozenset)
    sample_positions: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """Fragment shaders that compute words (uint32) at each pixel of a grid.

    Attributes:
        passes: each shader, and how many words it writes, to locations 0, 1, …
        size: (width, height) of the grid in pixels.
        lanes: words a pixel has of each input and output, 1 or 4.
        shared: the uniform array "shaderlab_shared", (count, 4) of uint32.
        uniforms: others, by name.
        textures: what samplers read, by name: the sampler's type, and the texture.
        folder: what textures' files are relative to.
    """

    passes: tuple[tuple[Source, int], ...]
    size: Size
    lanes: int
    shared: Array
    uniforms: Mapping[str, Array] = field(default_factory=dict)
    textures: Mapping[str, tuple[str, TextureSource]] = field(default_factory=dict)
    folder: str = ""


class Session(ABC):
    """One scene on a device. `draw` comes first; the rest answers questions about that draw.

    A backend overrides what it can answer. All else raises UnsupportedError, as does what its
    driver can't; what is about OpenGL's own calls raises OtherApiError where others draw.

    Attributes:
        scene: what is drawn.
        programs: each pass's draws, compiled.
        subpixel_step: the grid that corners are moved to before they are rasterised, in pixels.
    """

    # Of OpenGL's drivers: Mesa reports the least that is allowed, 4 bits, and has 8.
    subpixel_step: float = 2.0**-8

    def __init__(self, scene: Scene, programs: Programs) -> None:
        self.scene = scene
        self.programs = programs

    @abstractmethod
    def draw(self, only: Container[str] | None = None) -> Drawn:
        """Draw the passes in order, all or only these, and read their attachments.

        Raises:
            CaseError: the scene's data do not fit its programs or each other.
            ShaderError: the driver refuses a program.
        """

    def fragments(self, key: PassDraw) -> Fragments:
        """What the fragment shader of a draw got, at each pixel that it was the last to write."""
        raise UnsupportedError("capturing fragments: this backend can't")

    def release_captures(self, kept: Set[str]) -> None:  # noqa: B027
        """Release what is kept for further fragments of the same passes, but for some passes."""

    def written(self, key: PassDraw, text: str, outputs: Mapping[str, str]) -> Mapping[str, Array]:
        """What the fragments that are seen of a draw write to some outputs (format by name), where
        their shader has another text; (height, width, components), zeros elsewhere."""
        raise UnsupportedError("drawing with another text: this backend can't")

    def vertices(self, key: PassDraw) -> Samples:
        """Every vertex that a draw hands to rasterisation: what its last stage got and gave."""
        raise UnsupportedError("capturing vertices: this backend can't")

    def probe_fragments(
        self, key: PassDraw, runs: Sequence[Bindings], inputs: Mapping[str, Array]
    ) -> list[Samples]:
        """Run a draw's fragment stage once for each row of `inputs`, (count, components), with the
        uniforms and textures of each of the `runs`."""
        raise UnsupportedError("running a fragment stage on given inputs: this backend can't")

    def probe_vertices(
        self, key: PassDraw, bindings: Bindings, inputs: Mapping[str, Array]
    ) -> Samples:
        """Run a draw's vertex stage once for each row of `inputs`, (count, components)."""
        raise UnsupportedError("running a vertex stage on given inputs: this backend can't")

    def drawn_anew(self, changed: Pass, output: str, largest: int) -> Array:
        """One attachment of a pass of the scene that is drawn once more, other than that in its
        target's values or its draws' states; made smaller, to so many pixels along the longer side,
        unless a state counts pixels."""
        raise UnsupportedError("drawing a pass with other states: this backend can't")

    def count(self, key: PassDraw, counter: str) -> int:
        """What a draw makes the driver count; `counter` as in `shaderlab.query`."""
        raise UnsupportedError(f"counting {counter}: this backend can't")

    def time(self, pass_name: str, repeats: int) -> Timing:
        """How long a pass takes to draw, each of so many times."""
        raise UnsupportedError("timing a pass: this backend can't")

    def attributes(self, key: PassDraw) -> Mapping[str, AttributeReading]:
        """Where the API reads each attribute of a draw."""
        raise UnsupportedError("reading where attributes lie: this backend can't")

    def blocks(self, key: PassDraw) -> Mapping[str, BlockReading]:
        """Where the driver has the members of each uniform block of a draw's program."""
        raise UnsupportedError("reading where the members of blocks lie: this backend can't")

    def locations(self, key: PassDraw) -> Mapping[str, int]:
        """Where the driver put each declared uniform; −1 for one without any effect."""
        raise OtherApiError("locations of uniforms: this driver's API has none")

    def attachment(self, pass_name: str, name: str) -> Image:
        """What is in an attachment of a pass: a colour, "depth" or "stencil"."""
        raise UnsupportedError("reading an attachment once more: this backend can't")

    def gl_errors(self, key: PassDraw) -> Sequence[int]:
        """The errors that a draw raised."""
        raise OtherApiError("errors of OpenGL: this driver draws by another API")

    def trace(self) -> Sequence[TracedCall]:
        """The calls of the API that drawing the scene takes, in order; the lab's own questions
        apart."""
        raise OtherApiError("calls of OpenGL are recorded on OpenGL's drivers only")

    def call(self, made: Sequence[Call], returns: Sequence[int | float | str]) -> Reply:
        """What the API itself answers to the last of some calls. OpenGL alone has an answer.

        Args:
            made: one after the other in a context of their own, up to the first that raises
                an error.
            returns: the values that the last one should return or write.

        Raises:
            CaseError: a function, a constant, an argument or a pass does not exist.
        """
        raise OtherApiError("calls of OpenGL are answered by OpenGL's drivers only")


class Backend(ABC):
    """An open device.

    Attributes:
        info: what the driver says of itself: "renderer", "vendor", "version" and "glsl", and its
            limits.
    """

    info: Mapping[str, str]

    @abstractmethod
    def session(
        self, scene: Scene, programs: Programs, size: Size, *, temporary_programs: bool = False
    ) -> AbstractContextManager[Session]:
        """A scene to draw and to ask about; its device memory is released at the end.

        Args:
            scene: what to draw.
            programs: each pass's draws, compiled.
            size: (width, height) in pixels of targets that do not say.
            temporary_programs: release what is linked for this session at its end too, as of
                shaders that are drawn only once.
        """

    def edited_session(
        self, scene: Scene, programs: Programs, size: Size, edit: CallEdit | None
    ) -> AbstractContextManager[Session]:
        """As `session`, in a context of its own, with one call of the drawing made otherwise.

        It holds for `draw` and for what `trace` tells of that; None changes no call. What the lab
        reads and captures is not touched.

        Raises:
            ShaderlabError: drawing the scene takes no such call.
        """
        raise UnsupportedError("changing calls of OpenGL: this backend can't")

    def release_caches(self) -> None:  # noqa: B027
        """Free what is kept for scenes to come: programs, and what was captured."""

    @abstractmethod
    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        """The driver's own verdict on a program, as a target named "driver".

        Raises:
            DriverError: the driver has no such stage.
        """

    def verdict_before_draw(self, sources: Sequence[Source]) -> Verdict:
        """As `driver_verdict`, of a program that compiles and is drawn next: what is linked for the
        verdict may be kept for the draw."""
        return self.driver_verdict(sources)

    def require_compute(self) -> None:
        """Raise UnsupportedError where there are no compute passes."""
        raise UnsupportedError("compute passes run on OpenGL drivers only")

    def storage(self, count: int) -> AbstractContextManager[Callable[[], Array]]:
        """A storage buffer of `count` zeros (uint32), bound as binding 0 of all that is drawn
        meanwhile; gives a function that reads it, (count,).

        Raises:
            UnsupportedError: there are no storage buffers.
        """
        raise UnsupportedError("storage buffers: this backend has none")

    def evaluate(self, evaluation: Evaluation, inputs: Array, outputs: Array) -> None:
        """Run an evaluation's passes.

        Args:
            evaluation: what to run.
            inputs: the texture array "shaderlab_input", (layers, height, width, lanes) of uint32.
            outputs: gets the words, one after the other, (words, height, width, lanes) of uint32;
                0 where a pixel was discarded.

        Raises:
            ShaderError: the driver refuses a shader.
            CaseError: a texture does not fit its sampler.
        """
        raise UnsupportedError("calling functions: this backend can't")

    @abstractmethod
    def close(self) -> None:
        """Release the device."""
