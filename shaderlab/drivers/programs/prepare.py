"""From a draw to a compiled program: sources read, stages generated, interface known. No device."""

import functools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from shaderlab.compiler.compile import Compile, Compiled, compile_program
from shaderlab.compiler.glslang import TARGETS
from shaderlab.compiler.reflection import Interface, Variable
from shaderlab.compiler.shader_files import STAGES
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.errors import CaseError, ShaderError, UnsupportedError, suggest
from shaderlab.model.case import Scene
from shaderlab.model.frame import Array, PassDraw
from shaderlab.model.scene import Draw, Pass
from shaderlab.model.textures import outputs_read

from . import bind, stages, storage, textures

# Files and programs of one folder that are not read and compiled once more.
_KEPT = 512


@dataclass(frozen=True, kw_only=True)
class PreparedDraw:
    """A draw with its program compiled.

    `sources` are all stages, generated ones too; `authored` those of them that are files.
    `compiling` is what compiled them; `rewritten` are texts by stage to draw in place of theirs.
    """

    draw: Draw
    sources: tuple[Source, ...]
    authored: tuple[Source, ...]
    compiled: Compiled
    compiling: Compile = field(default=compile_program, repr=False, compare=False)
    rewritten: Mapping[str, str] | None = None

    @property
    def interface(self) -> Interface:
        """What the program declares. Raises ShaderError if it does not compile for OpenGL."""
        if self.compiled.interface is None:
            self.compiled.require()
            raise ShaderError(
                "the program can be compiled, but not drawn: it is no GLSL for OpenGL",
                file=self.authored[0].path,
                remedy="`shaderlab compile` compiles without rendering",
            )
        return self.compiled.interface

    @functools.cached_property
    def outputs(self) -> Mapping[str, Variable]:
        """What its fragment stage writes, or what a dispatch may leave in storage blocks. Raises
        ShaderError as `interface` does."""
        return storage.find_outputs(self.interface) if self.draw.compute else self.interface.outputs

    @functools.cached_property
    def vertex_interface(self) -> Interface:
        """What the vertex stage alone declares: before further ones, other outputs than the
        program's. Raises ShaderError as `interface` does."""
        if self.draw.geometry is None and self.draw.tess_evaluation is None:
            return self.interface
        alone = self.compiling(self.sources[:1], ("glsl", "opengl"))
        alone.require()
        assert alone.interface is not None
        return alone.interface

    @functools.cached_property
    def ramps(self) -> Mapping[str, Array]:
        """Uniforms of the lab's vertex stage over a domain, none with a mesh; to be read only."""
        return bind.make_ramp_uniforms(self.draw, self.interface.varyings)

    @property
    def texts(self) -> dict[str, str]:
        """The text of each stage after includes, by stage."""
        if self.rewritten is not None:
            return dict(self.rewritten)
        return {source.stage: source.text for source in self.sources}

    @property
    def last_stage(self) -> str:
        """The last stage before rasterisation."""
        stages = ("geometry", "tess_evaluation", "vertex")
        return next((stage for stage in stages if stage in self.texts), "vertex")

    @property
    def last_text(self) -> str:
        """The text of the last stage before rasterisation, empty of a dispatch."""
        return self.text(self.last_stage)

    def text(self, stage: str) -> str:
        """One stage's text after includes, "" where the program has no such stage."""
        return self.texts.get(stage, "")


Programs = Mapping[str, tuple[PreparedDraw, ...]]
"""Each pass's draws, compiled, by the pass's name."""


class Preparer:
    """Prepares draws, reading each file and compiling each program once: `shaders` is where files
    are found, in its `folders`, `compiling` what compiles a program for some targets. `source`
    gives a shader file with its includes; it raises ShaderError if it can't be read."""

    def __init__(self, shaders: Shaders, compiling: Compile = compile_program) -> None:
        self._shaders = shaders
        self._compiling = compiling
        self.source = functools.lru_cache(_KEPT)(shaders.load)
        self._compile = functools.lru_cache(_KEPT)(compiling)
        self.folders = shaders.folders

    def prepare(self, draw: Draw, targets: tuple[str, ...] = TARGETS) -> PreparedDraw:
        """Read, complete and compile a draw's program for these targets. Raises ShaderError: a file
        can't be read or included (one that does not compile has verdicts that say so);
        UnsupportedError: the lab can't write a vertex stage for a domain; CaseError: a domain does
        not fit the fragment shader's inputs, or a mesh its vertex stage."""
        if draw.mesh is not None and draw.mesh is not draw.mesh.made():
            draw = replace(draw, mesh=draw.mesh.made())
        _check_patches(draw)
        named = ((getattr(draw, stage), stage) for stage in STAGES if getattr(draw, stage))
        twice = len(set(draw.shaders)) < len(draw.shaders)  # then a file has sections
        authored = tuple(self.source(name, stage if twice else None) for name, stage in named)
        sources = authored if draw.domain is None else self._with_domain(draw, authored)
        compiled = self._compile(sources, targets)
        if compiled.interface is None and sources is not authored:
            raise UnsupportedError(
                f"a domain for {authored[0].path}: no vertex stage can be written that declares "
                "its inputs as it does",
                remedy="draw a mesh with a vertex shader of your own",
            )
        if draw.mesh is not None and compiled.interface is not None:
            bind.check_attributes(draw, compiled.interface)
        return PreparedDraw(
            draw=draw,
            sources=sources,
            authored=authored,
            compiled=compiled,
            compiling=self._compiling,
        )

    def _with_domain(self, draw: Draw, authored: tuple[Source, ...]) -> tuple[Source, ...]:
        """Add the vertex stage that lays the domain over the screen, if the interface is known."""
        # One target is enough to read what the files of a program declare.
        interface = self._compile(authored, ("glsl", "opengl")).interface
        if interface is None:
            return authored
        bind.check_domain(draw, interface.varyings)
        text = stages.write_domain_stage(authored[0].text, interface.varyings.values())
        return self._shaders.from_text(text, "vertex", "<domain>"), *authored

    def refusal(self, names: Sequence[str]) -> tuple[tuple[Source, ...], Compiled]:
        """Some shader files as one program, and what the plain GLSL compiler says of it."""
        sources = tuple(self.source(name) for name in names)
        return sources, self._compiling(sources, ("glsl",))


def _check_patches(draw: Draw) -> None:
    """Raise CaseError unless patches are drawn by tessellation stages, and nothing else is."""
    patches = draw.mesh is not None and draw.mesh.primitive == "patches"
    if patches and draw.tess_evaluation is None:
        raise CaseError(
            f"Draw of {draw.fragment}: a mesh of patches needs tessellation stages",
            remedy="give tess_control= and tess_evaluation=, or draw another primitive",
        )
    if draw.tess_evaluation is not None and not patches:
        raise CaseError(
            f"Draw of {draw.fragment}: tessellation stages take patches",
            remedy='Mesh(primitive="patches", patch_vertices=…)',
        )


def output_types(draws: Iterable[PreparedDraw]) -> dict[str, str]:
    """Return the GLSL type of each fragment output of a pass, in the order of their locations."""
    return {
        variable.name: variable.type
        for draw in draws
        for variable in sorted(
            draw.interface.outputs.values(), key=lambda v: (v.location is None, v.location or 0)
        )
    }


def pass_colors(description: Pass, draws: tuple[PreparedDraw, ...]) -> Mapping[str, str]:
    """Return the pass's colour attachments: format by output name. Raises CaseError: the target
    names an output that none of its programs writes."""
    outputs = output_types(draws)
    asked = description.target.colors
    if asked is None:
        return {name: textures.output_format(kind) for name, kind in outputs.items()}
    for name in asked:
        if name not in outputs:
            raise CaseError(
                f"pass {description.name!r}: its target has a colour {name!r}, "
                f"but its shaders write {', '.join(outputs) or 'nothing'}",
                remedy=suggest(name, outputs),
            )
    return asked


def describe_draw(key: PassDraw, draw: PreparedDraw) -> str:
    """Describe a draw: what is to blame if the driver crashes in it."""
    what = "dispatch" if draw.draw.compute else f"draw {key[1]}"
    return f"{what} of pass {key[0]!r}, program {' + '.join(draw.draw.shaders)}"


def check_continues(
    scene: Scene,
    description: Pass,
    colors: Mapping[str, str],
    earlier: Mapping[str, Mapping[str, str]],
) -> None:
    """Check that a pass with `onto` can draw on in the target of the one that it names; `colors`
    are its attachments' formats by output name, `earlier` those of the passes before it. Raises
    CaseError: there is no such earlier pass, or its target is another one."""
    before = description.onto
    if before not in earlier:
        raise CaseError(
            f"pass {description.name!r} continues {before!r}, which is no earlier pass",
            remedy=suggest(before, earlier),
        )
    same = scene.find_pass(before).target == description.target
    if not same or earlier[before] != colors:
        raise CaseError(
            f"pass {description.name!r} continues {before!r}, but its target differs",
            remedy="give both the same Target and shaders with the same outputs",
        )


def check_reads(scene: Scene, description: Pass, draw: Draw, earlier: Iterable[str]) -> None:
    """Check that all that a draw reads is still there; `earlier` are the passes before its own.
    Raises CaseError: a texture has been drawn over since, is the target that is being drawn into,
    or is a renderbuffer; UnsupportedError: a texture is a buffer of a dispatch."""
    images = {p.name: p.draws[0].images for p in scene.passes if p.computes}
    owners = {name: _find_owner(scene, name) for name in earlier}
    for name, source in draw.textures.items():
        for output in outputs_read(source):
            read = output.pass_name
            if output.name not in images.get(read, (output.name,)):
                raise UnsupportedError(
                    f"sampling a buffer: {name!r} is a texture, and {output.path} is left in a "
                    "storage buffer",
                    remedy="read it in another compute pass: buffers={…: Output(…)}",
                )
            if read not in owners:
                continue  # what is read does not exist: reported where it is looked for
            drawn = scene.find_pass(read).target
            if output.name == "depth" and drawn.depth and drawn.depth_storage == "renderbuffer":
                raise CaseError(
                    f"{name!r} is the depth of pass {read!r}, which keeps it in a renderbuffer: "
                    "that is drawn with, and no sampler reads it",
                    remedy=f"give {read!r} a Target(depth_storage='texture')",
                )
            if owners[read] == _find_owner(scene, description.name):
                raise CaseError(
                    f"pass {description.name!r} reads {name!r} from the target it draws into",
                    remedy="draw into another target, and exchange the two",
                )
            last = [other for other, owner in owners.items() if owner == owners[read]][-1]
            if last != read:
                raise CaseError(
                    f"pass {read!r} was drawn over", remedy=f"read the output of {last!r}"
                )


def _find_owner(scene: Scene, name: str) -> str:
    """Find the pass whose target a pass draws into: itself, or the one that it continues."""
    before = scene.find_pass(name).onto
    return _find_owner(scene, before) if before else name
