"""Collects a record while its scene runs, so that a failure half way loses nothing."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np

from shaderlab.compiler.diagnostics import mark_disagreement
from shaderlab.compiler.engines import ALL_TARGETS
from shaderlab.compiler.reflection import Interface
from shaderlab.compiler.sources import Source
from shaderlab.drivers.programs.prepare import PreparedDraw
from shaderlab.errors import ShaderlabError
from shaderlab.files import display_path
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement
from shaderlab.model.frame import Image, PassDraw, TracedCall
from shaderlab.model.records import (
    BufferRecord,
    CallsRecord,
    Curve,
    Declared,
    DrawnOutput,
    ErratumNote,
    ModulesRecord,
    Outcome,
    PassRecord,
    Plot,
    ProgramRecord,
    Record,
    SourceText,
    Status,
    Verdict,
)
from shaderlab.model.scene import Ramp

from .buffer_layouts import buffer_records
from .discovery import chapter_title
from .judging.distance import shown
from .picture_writer import PictureFiles
from .stored_images import digest

Assembly = Callable[[Mapping[str, Mapping[str, bytes]]], str]


class RecordBuilder:
    """Collects what a record is made of, in the order in which a scene runs."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._status: Status = "pass"
        self._message = ""
        self._programs: dict[tuple[Source, ...], ProgramRecord] = {}
        self._drawn_by: dict[PassDraw, tuple[Source, ...]] = {}
        self._outcomes: list[Outcome] = []
        self._curves: list[Curve] = []
        self._plots: list[Plot] = []
        self._notices: list[str] = []
        self._unread: tuple[str, ...] = ()
        self._not_asked: tuple[str, ...] = ()
        self._gl_calls: tuple[CallsRecord, ...] = ()
        self._modules: ModulesRecord | None = None
        self._outside: Collection[tuple[str, str]] = ()
        self._picture = PictureFiles()
        self._passes: tuple[PassRecord, ...] = ()
        self._buffers: tuple[BufferRecord, ...] = ()
        self._driver, self._size, self._picture_size = "", 0, 0
        self._images: dict[tuple[str, str], tuple[tuple[int, ...], str]] = {}

    def set_failure(self, status: Status, error: ShaderlabError) -> None:
        """Give the reason why the scene could not be run to its end."""
        self._status = status
        self._message = told(error)

    def set_unanswered(self, error: ShaderlabError) -> None:
        """Give the reason why some expectations were not judged; one that fails weighs more."""
        if all(outcome.status == "pass" for outcome in self._outcomes):
            self.set_failure("unsupported", error)

    def set_not_asked(self, names: tuple[str, ...]) -> None:
        """Set the names of the expectations about OpenGL's own calls, where another API draws."""
        self._not_asked = names

    def set_device(self, driver: Mapping[str, str], size: int, picture_size: int) -> None:
        """Set what the drawn values depend on besides the case."""
        self._driver = f"{driver['renderer']}; {driver['version']}"
        self._size, self._picture_size = size, picture_size

    def add_programs(
        self, prepared: Mapping[str, tuple[PreparedDraw, ...]], assembly: Assembly
    ) -> None:
        """Add each different program's sources and verdicts, and the layout of the buffers.

        `assembly` writes a program's modules to a file and returns its name.
        """
        for name, draws in prepared.items():
            for index, draw in enumerate(draws):
                self._drawn_by[name, index] = draw.sources
                if draw.sources not in self._programs:
                    self._programs[draw.sources] = _program(draw, assembly)
        self._buffers = buffer_records(prepared)

    def add_driver_verdicts(self, verdict_of: Callable[[tuple[Source, ...]], Verdict]) -> None:
        """Add the driver's own verdict on each program so far to those of the compilers."""
        for sources, program in self._programs.items():
            verdicts = mark_disagreement((*program.verdicts, _for_display(verdict_of(sources))))
            self._programs[sources] = replace(program, verdicts=verdicts)

    def set_unread(self, outputs: tuple[str, ...]) -> None:
        """Set the outputs that no expectation reads."""
        self._unread = outputs

    def set_gl_calls(self, trace: Sequence[TracedCall]) -> None:
        """Set the calls that change something, by pass and draw."""
        shown = [call for call in trace if call.effective]
        self._gl_calls = tuple(
            CallsRecord(pass_name=name, draw=draw, calls=tuple(map(str, calls)))
            for (name, draw), calls in groupby(shown, lambda c: (c.pass_name, c.draw))
        )

    def set_self_check(self, found: ModulesRecord, outside: Collection[tuple[str, str]]) -> None:
        """Set what was judged by its own shader, and the outputs that it does not allow."""
        self._modules, self._outside = found, outside

    def add_notice(self, text: str) -> None:
        """Add a message that changes no verdict."""
        if text not in self._notices:
            self._notices.append(text)

    def set_drawn(self, images: Mapping[tuple[str, str], Image]) -> None:
        """Set what was drawn, to be compared with what another driver draws."""
        self._images = {
            key: (image.values.shape[1::-1], digest(image.values)) for key, image in images.items()
        }

    def add_inactive_uniforms(self, names: frozenset[str]) -> None:
        """Add a notice for each declared uniform that the driver found to have no effect."""
        for name in sorted(names):
            self._notices.append(f"uniform {name} is declared but inactive: it changes no output")

    def add_outcome(self, outcome: Outcome, judgement: Judgement) -> None:
        """Add one expectation's outcome, with its curve and plot if it has any."""
        where = [replace(s, file=display_path(s.file)) for s in outcome.sources]
        if judgement.output is not None:
            where += self._assignments(*judgement.output)
        self._outcomes.append(replace(outcome, sources=tuple(where)))
        if judgement.curve is not None:
            self._curves.append(judgement.curve)
        if judgement.plot is not None:
            self._plots.append(judgement.plot)

    def set_pictures(self, picture: PictureFiles, passes: tuple[PassRecord, ...] = ()) -> None:
        """Set the case's picture, and those of its passes."""
        self._picture = picture
        self._passes = passes

    def build(self, seconds: float, timings: Mapping[str, float]) -> Record:
        """Build the record; `timings` are seconds by phase."""
        case = self._scene.case
        verdicts = _by_target(self._programs.values())
        return Record(
            id=case.id,
            variant=self._scene.variant,
            title=case.title,
            section=case.section,
            chapter=chapter_title(case.file, case.section),
            lesson=case.lesson,
            formula=case.math,
            file=display_path(case.file),
            status=self._final_status(verdicts),
            message=self._message or _refused(verdicts),
            seconds=seconds,
            timings=timings,
            compile=verdicts,
            programs=tuple(self._programs.values()),
            expectations=tuple(self._outcomes),
            curves=tuple(self._curves),
            plots=tuple(self._plots),
            errata=tuple(
                ErratumNote(
                    section=e.section or case.section, says=e.says, truth=e.truth, proof=e.proof
                )
                for e in case.errata
            ),
            inputs=_inputs(self._scene),
            notices=tuple(self._notices),
            images=self._picture.files,
            captions=self._picture.captions,
            passes=self._passes,
            buffers=self._buffers,
            driver=self._driver,
            size=self._size,
            picture_size=self._picture_size,
            unread=self._unread,
            not_asked=self._not_asked,
            gl_calls=self._gl_calls,
            modules=self._modules,
            drawn=tuple(self._drawn()),
        )

    def _drawn(self) -> Iterator[DrawnOutput]:
        """Each output with the expectations that read it and fail."""
        failed = {key: ["its own shader"] for key in self._outside}
        judged = zip(self._scene.expect, self._outcomes, strict=False)
        for expectation, outcome in judged if self._images else ():
            if outcome.status != "pass":
                for read in expectation.reads(self._scene):
                    failed.setdefault((read.pass_name, read.output), []).append(outcome.name)
        for key, ((width, height), found) in self._images.items():
            names = tuple(dict.fromkeys(failed.get(key, ())))
            name = ".".join(key)
            yield DrawnOutput(name=name, size=(width, height), digest=found, failed=names)

    def _final_status(self, verdicts: Mapping[str, str]) -> Status:
        if self._status != "pass":
            return self._status
        statuses = {outcome.status for outcome in self._outcomes}
        if "error" in statuses:
            return "error"
        if "fail" in statuses or "fail" in verdicts.values():
            return "fail"
        return "pass"

    def _assignments(self, key: PassDraw, output: str) -> list[SourceText]:
        """The last line of a draw's program that assigns to an output."""
        sources = self._drawn_by[key]
        name = output.rpartition(".")[2].partition("[")[0]  # blocks go by another name in a shader
        assigns = re.compile(rf"\b{re.escape(name)}(\.\w+|\[[^]]*\])*\s*[-+*/]?=(?!=)")
        for source in reversed(self._programs[sources].sources):
            lines = [line.split("//")[0] for line in source.text.splitlines()]
            hits = [n for n, line in enumerate(lines, 1) if assigns.search(line)]
            if hits:
                return [replace(source, line=hits[-1], text=lines[hits[-1] - 1].strip())]
        return []


def _program(draw: PreparedDraw, assembly: Assembly) -> ProgramRecord:
    modules = draw.compiled.spirv
    file = assembly(modules)
    parts: dict[str, str] = {}
    for source in draw.authored:
        parts.update(dict(source.parts))
    sources = [
        SourceText(file=display_path(path), line=1, language="glsl", text=text)
        for path, text in parts.items()
    ]
    return ProgramRecord(
        files=tuple(source.file for source in sources),
        sources=tuple(sources),
        verdicts=tuple(
            _for_display(verdict, file if modules.get(verdict.target) else "")
            for verdict in draw.compiled.verdicts
        ),
        declared=tuple(_declared(draw.compiled.interface)),
    )


def _declared(interface: Interface | None) -> Iterator[Declared]:
    """What a program declares, stage inputs first."""
    if interface is None:
        return
    groups = {
        "attribute": interface.attributes,
        "varying": interface.varyings,
        "output": interface.outputs,
        "uniform": interface.uniforms,
    }
    for kind, variables in groups.items():
        for name, v in variables.items():
            if name.startswith("shaderlab_"):  # of the vertex stage that the lab writes
                continue
            size = "" if v.array is None else f"[{v.array or ''}]"
            yield Declared(
                kind=kind, name=name, type=v.type + size, location=v.location, used=v.used
            )
    for name, block in interface.blocks.items():
        yield Declared(
            kind="block",
            name=name,
            type=f"{block.kind} block of {block.size} bytes",
            location=block.binding,
            used=block.used,
        )


def told(error: ShaderlabError) -> str:
    """What a record says of an error: its place as people read it, the message, the remedy."""
    place = "" if error.file is None else f"{display_path(error.file, error.line or None)}: "
    remedy = f"\n→ {error.remedy}" if error.remedy else ""
    return f"{place}{error.message}{remedy}"


def _for_display(verdict: Verdict, assembly: str = "") -> Verdict:
    if not (verdict.diagnostics or assembly):
        return verdict
    diagnostics = (replace(d, file=display_path(d.file)) for d in verdict.diagnostics)
    return replace(verdict, diagnostics=tuple(diagnostics), assembly=assembly)


def _by_target(programs: Iterable[ProgramRecord]) -> dict[str, str]:
    verdicts: dict[str, str] = {}
    for program in programs:
        for verdict in program.verdicts:
            if not verdict.ok or verdict.target not in verdicts:
                verdicts[verdict.target] = "pass" if verdict.ok else "fail"
    return verdicts


def _refused(verdicts: Mapping[str, str]) -> str:
    refused = [target for target, verdict in verdicts.items() if verdict == "fail"]
    if not refused:
        return ""
    accepted = [target for target in ALL_TARGETS if verdicts.get(target) == "pass"]
    remedy = f"\n→ if it is meant for {' and '.join(accepted)} alone: targets={accepted}"
    message = f"a program does not compile for {', '.join(refused)}"
    return message + (f"{remedy}, in the case or in [tool.shaderlab]" if accepted else "")


def _inputs(scene: Scene) -> dict[str, str]:
    """All uniforms and ramps as text; those that the variant changes come first."""
    texts = {name: _input_text(value) for name, value in scene.inputs.items()}
    return {name: texts[name] for name in sorted(texts, key=lambda n: n not in scene.changes)}


def _input_text(value: object) -> str:
    if isinstance(value, Ramp):
        ends = [shown(value.origin)]
        for label, step in (("across", value.dx), ("up", value.dy)):
            if any(v != 0.0 for v in _numbers(step)):
                ends.append(f"{label} {shown(step)}")
        return " + ".join(ends)
    try:
        return shown(value)
    except (TypeError, ValueError):  # not numbers: another part of the record says so
        return repr(value)


def _numbers(value: object) -> list[float]:
    return [float(v) for v in np.ravel(np.asarray(value, np.float64))]
