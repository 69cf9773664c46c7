"""Collects a record while its scene runs, so that a failure half way loses nothing."""

import re
import traceback
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from shaderlab.compiler.diagnostics import mark_disagreement
from shaderlab.compiler.glslang import ALL_TARGETS
from shaderlab.compiler.reflection import Interface
from shaderlab.compiler.sources import Source
from shaderlab.drivers.programs import bind
from shaderlab.drivers.programs.prepare import PreparedDraw, Programs
from shaderlab.errors import (
    AssetError,
    CaseError,
    DeviceLostError,
    DriverError,
    OtherApiError,
    ShaderlabError,
    UnsupportedError,
    Verdict,
)
from shaderlab.files import display_path
from shaderlab.model import records
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement
from shaderlab.model.frame import Image, PassDraw, TracedCall
from shaderlab.model.mesh import Mesh
from shaderlab.model.scene import Ramp, UniformBuffer

from .catalogue import chapter_title, is_project_file, place_of
from .jobs import DEFECT
from .judging.banded import format_value
from .pictures import PictureWriter, digest_values

_MOST_BUFFERS = 24


class RecordBuilder:
    """Collects what a record is made of, in the order in which a scene runs: `record` is what is
    known so far; `drawn` is what was drawn, where another driver's is compared with it."""

    def __init__(self, scene: Scene) -> None:
        case = scene.case
        self.drawn: Mapping[tuple[str, str], Image] = {}
        self._scene = scene
        self._programs: dict[tuple[Source, ...], records.ProgramRecord] = {}
        self._drawn_by: dict[PassDraw, tuple[Source, ...]] = {}
        self._outside: Collection[tuple[str, str]] = ()
        self.record = records.Record(
            id=case.id,
            variant=scene.variant,
            title=case.title,
            section=case.section,
            chapter=chapter_title(case.file, case.section),
            place=place_of(case.file, case.id, case.section),
            lesson=case.lesson,
            formula=case.math,
            file=display_path(case.file),
            status="pass",
            errata=tuple(
                records.ErratumNote(
                    section=e.section or case.section, says=e.says, truth=e.truth, proof=e.proof
                )
                for e in case.errata
            ),
            inputs=_format_inputs(scene),
            columns=tuple(case.columns),
            rows=tuple(case.rows),
        )

    def set(self, **fields: Any) -> None:
        """Set fields of the record."""
        self.record = replace(self.record, **fields)

    def set_error(self, error: BaseException, driver: str | None) -> None:
        """Set the exception that ended the scene, with the status that it gives the record."""
        status, shown_error = _status_of(error, driver)
        self.set(status=status, message=format_error(shown_error))

    def set_unanswered(self, unanswered: Mapping[int, UnsupportedError]) -> None:
        """Set the expectations, by number, that the driver has no answer for, and why.

        Those about OpenGL's own calls do not count against a driver that draws by another API,
        unless there is nothing else. An expectation that fails weighs more.
        """
        if not unanswered:
            return
        expect = self._scene.expect
        lacking = {i: e for i, e in unanswered.items() if not isinstance(e, OtherApiError)}
        self.set(not_asked=tuple(expect[i].name for i in unanswered if i not in lacking))
        if lacking:
            names = ", ".join(repr(expect[index].name) for index in lacking)
            self.add_notice(f"not judged on this driver: {names}")
        passed = all(outcome.status == "pass" for outcome in self.record.expectations)
        if passed and (lacking or len(unanswered) == len(expect)):
            message = format_error(next(iter((lacking or unanswered).values())))
            self.set(status="unsupported", message=message)

    def add_programs(self, programs: Programs, pictures: PictureWriter) -> None:
        """Add each different program's sources and verdicts, and the layout of the buffers."""
        for name, draws in programs.items():
            for index, draw in enumerate(draws):
                self._drawn_by[name, index] = draw.sources
                if draw.sources not in self._programs:
                    file = ""
                    with self.notice_if_unwritable():
                        file = pictures.write_assembly(draw.compiled.spirv)
                    self._programs[draw.sources] = _program_record(draw, file)
        buffers = [*_uniform_buffers(programs), *_vertex_buffers(programs)]
        self.set(buffers=tuple(buffers[:_MOST_BUFFERS]))

    def add_driver_verdicts(self, verdict_of: Callable[[tuple[Source, ...]], Verdict]) -> None:
        """Add the driver's own verdict on each program so far to those of the compilers."""
        for sources, program in self._programs.items():
            verdicts = mark_disagreement((*program.verdicts, _for_display(verdict_of(sources))))
            self._programs[sources] = replace(program, verdicts=verdicts)

    def set_gl_calls(self, trace: Sequence[TracedCall]) -> None:
        """Set the calls that change something, by pass and draw."""
        effective = [call for call in trace if call.effective]
        self.set(
            gl_calls=tuple(
                records.CallsRecord(pass_name=name, draw=draw, calls=tuple(map(str, calls)))
                for (name, draw), calls in groupby(effective, lambda c: (c.pass_name, c.draw))
            )
        )

    def set_self_check(
        self,
        modules: records.ModulesRecord,
        judgement: Judgement,
        outside: Collection[tuple[str, str]],
        *,
        always: bool,
    ) -> None:
        """Set what holding draws against their own shaders gave: what was judged, its outcome,
        shown where it fails, or `always`, and the outputs that their shader does not allow."""
        self.set(modules=modules)
        self._outside = outside
        if always or judgement.outcome.message:
            self.add_outcome(judgement.outcome, judgement)

    def add_notice(self, text: str) -> None:
        """Add a message that changes no verdict."""
        if text not in self.record.notices:
            self.set(notices=(*self.record.notices, text))

    @contextmanager
    def notice_if_unwritable(self, what: str = "a picture") -> Iterator[None]:
        """A file for people that can't be written changes no verdict: the record gets a notice."""
        try:
            yield
        except AssetError as error:
            self.add_notice(error.message)
        except OSError as error:
            self.add_notice(f"can't write {what} ({error.strerror or error})")

    def add_outcome(self, outcome: records.Outcome, judgement: Judgement) -> None:
        """Add one expectation's outcome, with its curve and plot if it has any."""
        where = [replace(s, file=display_path(s.file)) for s in outcome.sources]
        if judgement.output is not None:
            where += self._find_assignment(*judgement.output)
        known, outcome = self.record, replace(outcome, sources=tuple(where))
        self.set(expectations=(*known.expectations, outcome))
        if judgement.curve is not None:
            self.set(curves=(*known.curves, judgement.curve))
        if judgement.plot is not None:
            self.set(plots=(*known.plots, judgement.plot))

    def build(self, seconds: float, timings: Mapping[str, float]) -> records.Record:
        """Build the record; `timings` are seconds by phase."""
        verdicts = _by_target(self._programs.values())
        return replace(
            self.record,
            status=self._final_status(verdicts),
            message=self.record.message or _refusal_message(verdicts),
            seconds=seconds,
            timings=timings,
            compile=verdicts,
            programs=tuple(self._programs.values()),
            drawn=tuple(self._find_drawn_outputs()),
        )

    def _find_drawn_outputs(self) -> Iterator[records.DrawnOutput]:
        """Each output with the expectations that read it and fail."""
        failed = {key: ["its own shader"] for key in self._outside}
        judged = zip(self._scene.expect, self.record.expectations, strict=False)
        for expectation, outcome in judged if self.drawn else ():
            if outcome.status != "pass":
                for read in expectation.find_reads(self._scene):
                    failed.setdefault((read.pass_name, read.output), []).append(outcome.name)
        for key, image in self.drawn.items():
            height, width = image.values.shape[:2]
            yield records.DrawnOutput(
                name=".".join(key),
                size=(width, height),
                digest=digest_values(image.values),
                failed=tuple(dict.fromkeys(failed.get(key, ()))),
            )

    def _final_status(self, verdicts: Mapping[str, str]) -> records.Status:
        if self.record.status != "pass":
            return self.record.status
        statuses = {outcome.status for outcome in self.record.expectations}
        if "error" in statuses:
            return "error"
        if "fail" in statuses or "fail" in verdicts.values():
            return "fail"
        return "pass"

    def _find_assignment(self, key: PassDraw, output: str) -> list[records.SourceText]:
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


def _program_record(draw: PreparedDraw, assembly: str) -> records.ProgramRecord:
    modules = draw.compiled.spirv
    parts: dict[str, str] = {}
    for source in draw.authored:
        parts.update(dict(source.parts))
    sources = [
        records.SourceText(file=display_path(path), line=1, language="glsl", text=text)
        for path, text in parts.items()
    ]
    return records.ProgramRecord(
        files=tuple(source.file for source in sources),
        sources=tuple(sources),
        verdicts=tuple(
            _for_display(verdict, assembly if modules.get(verdict.target) else "")
            for verdict in draw.compiled.verdicts
        ),
        declared=tuple(_declarations(draw.compiled.interface)),
    )


def _declarations(interface: Interface | None) -> Iterator[records.Declared]:
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
            yield records.Declared(
                kind=kind, name=name, type=v.type + size, location=v.location, used=v.used
            )
    for name, block in interface.blocks.items():
        yield records.Declared(
            kind="block",
            name=name,
            type=f"{block.kind} block of {block.size} bytes",
            location=block.binding,
            used=block.used,
        )


def _status_of(error: BaseException, driver: str | None) -> tuple[records.Status, ShaderlabError]:
    """The status of a scene that an exception ended, and the error to show."""
    match error:
        case UnsupportedError():
            return "unsupported", error
        case DeviceLostError():
            return "crash", DriverError(f"{driver}: {error.message}")
        case MemoryError():
            return "error", ShaderlabError(f"out of memory: {error}".rstrip(": "))
        case ShaderlabError():
            return "error", error
    frames = traceback.extract_tb(error.__traceback__)
    lab = str(Path(__file__).parents[1])
    own = [f for f in frames if f.filename[0] == "/" and is_project_file(Path(f.filename))]
    place = [f for f in frames if f in own or f.filename.startswith(lab)][-1]
    if place in own or not isinstance(error, Exception):  # SystemExit: a case's own code alone
        message = f"raised {type(error).__name__}: {error}".rstrip(": ")
        return "error", CaseError(message, file=place.filename, line=place.lineno)
    return "error", ShaderlabError(
        f"unforeseen {type(error).__name__}: {error}",
        file=place.filename,
        line=place.lineno,
        remedy=DEFECT,
    )


def format_error(error: ShaderlabError) -> str:
    """Format an error for a record: its place as people read it, the message, the remedy."""
    place = "" if error.file is None else f"{display_path(error.file, error.line or None)}: "
    remedy = f"\n→ {error.remedy}" if error.remedy else ""
    return f"{place}{error.message}{remedy}"


def _for_display(verdict: Verdict, assembly: str = "") -> Verdict:
    if not (verdict.diagnostics or assembly):
        return verdict
    diagnostics = (replace(d, file=display_path(d.file)) for d in verdict.diagnostics)
    return replace(verdict, diagnostics=tuple(diagnostics), assembly=assembly)


def _by_target(programs: Iterable[records.ProgramRecord]) -> dict[str, str]:
    verdicts: dict[str, str] = {}
    for program in programs:
        for verdict in program.verdicts:
            if not verdict.ok or verdict.target not in verdicts:
                verdicts[verdict.target] = "pass" if verdict.ok else "fail"
    return verdicts


def _refusal_message(verdicts: Mapping[str, str]) -> str:
    refused = [target for target, verdict in verdicts.items() if verdict == "fail"]
    if not refused:
        return ""
    accepted = [target for target in ALL_TARGETS if verdicts.get(target) == "pass"]
    remedy = f"\n→ if it is meant for {' and '.join(accepted)} alone: targets={accepted}"
    message = f"a program does not compile for {', '.join(refused)}"
    return message + (f"{remedy}, in the case or in [tool.shaderlab]" if accepted else "")


def _format_inputs(scene: Scene) -> dict[str, str]:
    """All uniforms and ramps as text; those that the variant changes come first."""
    texts = {name: _format_input(value) for name, value in scene.inputs.items()}
    return {name: texts[name] for name in sorted(texts, key=lambda n: n not in scene.changes)}


def _format_input(value: object) -> str:
    if isinstance(value, Ramp):
        ends = [format_value(value.origin)]
        for label, step in (("across", value.dx), ("up", value.dy)):
            if np.any(np.asarray(step, np.float64)):
                ends.append(f"{label} {format_value(step)}")
        return " + ".join(ends)
    try:
        return format_value(value)
    except (TypeError, ValueError):  # not numbers: another part of the record says so
        return repr(value)


def _uniform_buffers(prepared: Programs) -> Iterator[records.BufferRecord]:
    users: dict[int, list[tuple[str, UniformBuffer, PreparedDraw]]] = {}
    for draws in prepared.values():
        for draw in draws:
            for name, buffer in draw.draw.blocks.items():
                users.setdefault(id(buffer), []).append((name, buffer, draw))
    for uses in users.values():
        name, _, draw = uses[0]
        interface = draw.compiled.interface
        block = None if interface is None else bind.uniform_blocks(interface).get(name)
        if block is not None:
            parts = tuple(
                records.BufferPart(
                    name=member.name, offset=member.offset, stride=member.array_stride
                )
                for member in block.members.values()
            )
            yield records.BufferRecord(
                name=name, kind="uniform", size=block.size, used=len(uses), parts=parts
            )


def _vertex_buffers(prepared: Programs) -> Iterator[records.BufferRecord]:
    meshes: dict[int, tuple[str, Mesh, int]] = {}
    for name, draws in prepared.items():
        for draw in draws:
            mesh = draw.draw.mesh
            if mesh is not None and _has_own_layout(mesh):
                first, _, count = meshes.get(id(mesh), (name, mesh, 0))
                meshes[id(mesh)] = (first, mesh, count + 1)
    for name, mesh, count in meshes.values():
        places = mesh.placements()
        for number, pieces in enumerate(mesh.parts()):
            yield records.BufferRecord(
                name=f"{name}, buffer {number}",
                kind="vertex",
                size=sum(len(piece) for _, piece in pieces),
                used=count,
                parts=tuple(
                    records.BufferPart(
                        name=attribute, offset=p.offset, stride=p.stride, divisor=p.divisor
                    )
                    for attribute, p in places.items()
                    if p.buffer == number
                ),
                usage=mesh.usage,
                upload=mesh.upload,
            )


def _has_own_layout(mesh: Mesh) -> bool:
    """Whether the mesh asks for another layout than the default, or for instances."""
    default = ("separate", "static_draw", "data")
    return bool(mesh.instance_attributes) or (mesh.layout, mesh.usage, mesh.upload) != default
