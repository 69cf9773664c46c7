"""A case: passes, what must hold of them, and what it teaches; and its variants."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from shaderlab.errors import CaseError, suggest
from shaderlab.model.checked import Checked
from shaderlab.model.expectation import Expectation
from shaderlab.model.scene import Draw, Pass, Ramp, UniformBuffer
from shaderlab.model.textures import Output

from .frame import PassDraw

DEFAULT_VARIANT = "default"


@dataclass(frozen=True)
class Variant(Checked):
    """A named change of a case's inputs.

    `changes` replaces uniforms, textures, buffers, images, ramps of the domain, or members of
    uniform blocks ("Matrices.view"), by the names the case uses, in every draw that has them;
    `passes` replaces the passes altogether. `expect` is added to the case's own expectations.
    """

    name: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    expect: Sequence[Expectation] = ()
    passes: tuple[Pass, ...] | None = None

    def __post_init__(self) -> None:
        if not self.name or "/" in self.name:
            raise CaseError(f"Variant: {self.name!r} is no name: it must not be empty or hold '/'")


@dataclass(frozen=True, kw_only=True)
class Erratum(Checked):
    """Where the text that a case follows is wrong: what it says, what is true, what proves it."""

    says: str
    truth: str
    proof: str
    section: str = ""


@dataclass(frozen=True, kw_only=True)
class Case(Checked):
    """One lesson with its shaders and its checks.

    Args:
        title: a few words.
        section: its number in the text that it follows ("5.5.2"), "" where it follows none.
        passes: what is drawn, from `fullscreen`, `mesh_pass`, `compute` or `Pass` themselves.
        expect: what must hold of every variant.
        variants: named changes of inputs; without any there is one, called "default".
        errata: where that text is wrong.
        math: the formula in LaTeX, for the report.
        picture: the output that is the case's picture; the last pass's first one by default.
        columns, rows: what the picture's columns and rows are, from the left and from above, where
            it is a table: the page writes them beside it.
        targets: what its programs are compiled for: "glsl", "opengl", "vulkan" or "vulkan-strict";
            by default what the project says, or else the first three.

    `id`, `file` and `lesson` (the module's docstring) are filled in when the file is loaded.
    """

    title: str
    section: str = ""
    passes: tuple[Pass, ...]
    expect: Sequence[Expectation]
    variants: Sequence[Variant] = ()
    errata: Sequence[Erratum] = ()
    math: str = ""
    picture: str = ""
    columns: Sequence[str] = ()
    rows: Sequence[str] = ()
    targets: Sequence[str] = ()
    id: str = ""
    file: str = ""
    lesson: str = ""

    def __post_init__(self) -> None:
        for name in ("passes", "expect", "variants"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        _check_unique("passes", [p.name for p in self.passes])
        _check_unique("variants", [v.name for v in self.variants])
        if not self.passes:
            raise CaseError("Case: there are no passes; see shaderlab.fullscreen")
        checked = bool(self.variants) and all(v.expect for v in self.variants)
        if not self.expect and not checked:
            raise CaseError("Case: expect is empty, so nothing could fail")

    @property
    def chapter(self) -> int:
        """The chapter that its section lies in; 0 without a section."""
        head = self.section.split(".")[0]
        return int(head) if head.isdigit() else 0

    def scenes(self) -> "Iterator[Scene]":
        """Each variant with its changes made, in the order they are written. Raises CaseError: a
        variant changes something that no draw has, or the picture's pass is none."""
        for index, variant in enumerate(self.variants or (Variant(DEFAULT_VARIANT),)):
            passes = self.passes if variant.passes is None else tuple(variant.passes)
            # Figures that no input changes are judged once, with the first variant.
            again = [e for e in self.expect if index == 0 or not e.once]
            scene = Scene(
                case=self,
                variant=variant.name,
                passes=_apply_changes(passes, variant),
                expect=(*again, *variant.expect),
                changes=variant.changes,
            )
            if scene.picture is not None:
                scene.find_pass(scene.picture.pass_name)
            yield scene

    def scene(self, variant: str) -> "Scene":
        """The scene of one variant, by name."""
        scenes = {scene.variant: scene for scene in self.scenes()}
        if variant not in scenes:
            raise CaseError(
                f"{self.id} has no variant {variant!r}",
                file=self.file or None,
                remedy=suggest(variant, scenes),
            )
        return scenes[variant]


@dataclass(frozen=True, kw_only=True)
class Scene:
    """One variant of a case, ready to run."""

    case: Case
    variant: str
    passes: tuple[Pass, ...]
    expect: tuple[Expectation, ...]
    changes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def inputs(self) -> dict[str, Any]:
        """All uniforms, members of uniform blocks and ramps by the names that the case uses; of
        several draws with one name the first one's value."""
        found: dict[str, Any] = {}
        for draw in (draw for description in self.passes for draw in description.draws):
            members = {
                f"{block}.{name}": value
                for block, buffer in draw.blocks.items()
                for name, value in buffer.values.items()
            }
            for name, value in {**draw.uniforms, **members, **(draw.domain or {})}.items():
                found.setdefault(name, value)
        return found

    def find_pass(self, name: str | None) -> Pass:
        """The pass called `name`; the last one for None."""
        if name is None:
            return self.passes[-1]
        for candidate in self.passes:
            if candidate.name == name:
                return candidate
        raise CaseError(
            f"there is no pass {name!r}",
            file=self.case.file or None,
            remedy=suggest(name, [p.name for p in self.passes]),
        )

    def split_output(self, name: str) -> tuple[str | None, str]:
        """An output's pass (None for the last one) and its own name.

        "VS_OUT.FragPos" is a block's member, unless a pass is called VS_OUT.
        """
        head, dot, rest = name.partition(".")
        if dot and any(head == description.name for description in self.passes):
            return head, rest
        return None, name

    def draw_key(self, pass_name: str | None, draw: int) -> PassDraw:
        """The (pass, draw) that an expectation means; negative draws count from the last one.
        Raises CaseError: there is no such pass or draw."""
        description = self.find_pass(pass_name)
        count = len(description.draws)
        if not -count <= draw < count:
            raise CaseError(f"pass {description.name!r} has {count} draws, there is no draw {draw}")
        return description.name, draw % count

    @property
    def picture(self) -> Output | None:
        """The output that the case names as its picture; None for the last pass's first one."""
        if not self.case.picture:
            return None
        own = "." not in self.case.picture
        return Output(f"{self.passes[-1].name}." * own + self.case.picture)

    def named_outputs(self) -> dict[str, set[str]]:
        """The outputs that textures, expectations and the picture name, by pass. Colours are read
        back always, depth and stencil only where they are named here."""
        found: dict[str, set[str]] = {}
        draws = (draw for description in self.passes for draw in description.draws)
        sampled = (output for draw in draws for output in draw.outputs_read())
        for output in filter(None, (self.picture, *sampled)):
            found.setdefault(output.pass_name, set()).add(output.name)
        for expectation in self.expect:
            for read in expectation.find_reads(self):
                found.setdefault(read.pass_name, set()).add(read.output)
        return found


def _apply_changes(passes: tuple[Pass, ...], variant: Variant) -> tuple[Pass, ...]:
    if not variant.changes:
        return passes
    known: dict[str, None] = {}
    # A buffer that several draws share is changed once, and stays shared.
    buffers: dict[tuple[str, int], UniformBuffer] = {}

    def changes_of(present: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
        names = {prefix + name: name for name in present}
        known.update(dict.fromkeys(names))
        return {names[name]: v for name, v in variant.changes.items() if name in names}

    def change_block(name: str, buffer: UniformBuffer) -> UniformBuffer:
        if (name, id(buffer)) not in buffers:
            hits = changes_of(buffer.values, f"{name}.")
            changed = UniformBuffer(values={**buffer.values, **hits}) if hits else buffer
            buffers[name, id(buffer)] = changed
        return buffers[name, id(buffer)]

    def change(draw: Draw) -> Draw:
        edits: dict[str, Any] = {}
        for slot in ("uniforms", "textures", "domain", "buffers", "images"):
            present = getattr(draw, slot) or {}
            hits = changes_of(present)
            if slot == "domain":
                hits = {k: v if isinstance(v, Ramp) else Ramp(v) for k, v in hits.items()}
            if hits:
                edits[slot] = {**present, **hits}
        blocks = {name: change_block(name, buffer) for name, buffer in draw.blocks.items()}
        if any(blocks[name] is not draw.blocks[name] for name in blocks):
            edits["blocks"] = blocks
        return replace(draw, **edits) if edits else draw

    changed = tuple(replace(p, draws=tuple(change(d) for d in p.draws)) for p in passes)
    for name in sorted(variant.changes.keys() - known):
        raise CaseError(
            f"variant {variant.name!r} changes {name!r}, which no draw has",
            remedy=suggest(name, known),
        )
    return changed


def _check_unique(what: str, names: list[str]) -> None:
    for name in names:
        if names.count(name) > 1:
            raise CaseError(f"two {what} are called {name!r}")
