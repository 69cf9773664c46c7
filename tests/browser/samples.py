"""A run to look at in a browser: pictures and numbers made of arrays, without a device."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from shaderlab.engine.pictures import PictureWriter
from shaderlab.errors import Verdict
from shaderlab.model.frame import Array, Image
from shaderlab.model.records import (
    Declared,
    ErratumNote,
    Outcome,
    ProgramRecord,
    Record,
    Row,
    Run,
    SourceText,
    Worst,
)
from shaderlab.model.store import save
from shaderlab.report.html import render_single, write
from tests.unit.test_report_samples import curve, outcome, record, run

WIDTH, HEIGHT = 20, 12
WORST = (13, 4)
BROKEN = (2, 9)


@dataclass(frozen=True)
class Sample:
    """A front page, the run that it shows, and the arrays behind the failing check's pictures."""

    page: Path
    run: Run
    arrays: dict[str, Array]

    def case(self, id: str) -> Path:
        """The page of a case."""
        return self.page.parent / "cases" / f"{id}.html"

    @property
    def single(self) -> Path:
        """The report as one file."""
        return self.page.parent / "single.html"


def arrays(seed: int, *, wrong: bool) -> dict[str, Array]:
    """A check's arrays: four components, the outermost pixels not drawn."""
    generator = np.random.default_rng(seed)
    reference = generator.uniform(0.05, 0.95, (HEIGHT, WIDTH, 4))
    measured = (reference * (1 + generator.uniform(-2, 2, reference.shape) * 2**-24)).astype("f4")
    covered = np.zeros((HEIGHT, WIDTH), bool)
    covered[1:-1, 1:-1] = True
    if wrong:
        measured[WORST[1], WORST[0]] = (0.5, 0.875, 0.25, 1.0)
        measured[BROKEN[1], BROKEN[0], 0] = np.nan
    low = (reference * (1 - 2.0**-20)).astype("f4").astype(float)
    high = (reference * (1 + 2.0**-20)).astype("f4").astype(float)
    outside = ~((measured >= low) & (measured <= high)) & covered[..., None]
    distance = np.where(outside.any(axis=2), np.inf, 0.25)
    return {
        "measured": np.where(covered[..., None], measured, 0).astype("f4"),
        "reference": np.where(covered[..., None], reference, np.nan),
        "distance": np.where(covered, distance, np.nan),
        "covered": covered,
        "outside": outside,
        "unit": np.float64(0),
        "exact": reference,
        "low": low,
        "high": high,
    }


def judged(folder: Path, variant: str, values: dict[str, Array]) -> Outcome:
    """The outcome of a check over these arrays, its files written."""
    seen = PictureWriter(folder, "lamp", variant).write_comparison("0-FragColor", values, WORST)
    x, y = WORST
    each = {
        name: tuple(float(v) for v in values[key][y, x])
        for name, key in (
            ("measured", "measured"), ("reference", "exact"), ("low", "low"), ("high", "high"),
        )
    }  # fmt: skip
    outside = int(values["outside"].sum())
    return outcome(
        name="FragColor",
        status="fail" if outside else "pass",
        message=f"{outside} values lie outside their band" if outside else "",
        judged=int(values["covered"].sum()) * 4,
        outside=outside,
        worst=Worst(pixel=WORST, component=1, ulp=1.0, widths=9.0 if outside else 0.3, **each),
        images=seen.files,
        captions=seen.captions,
        values=seen.values,
        rows=(Row(label="F(7)", expected="0.5", measured="0.5", ok=True),),
        sources=(SourceText(file="lamp.frag", line=3, language="glsl", text="FragColor = a;"),),
    )


def lamp(folder: Path) -> Sample:
    """A run of two cases; the first has a variant that fails. Its page and its run.json."""
    bad = arrays(1, wrong=True)
    text = "#version 330 core\nuniform float a;\nFragColor = a;\n"
    program = ProgramRecord(
        files=("lamp.frag",),
        sources=(SourceText(file="lamp.frag", line=1, language="glsl", text=text),),
        verdicts=(
            Verdict(target="vulkan", ok=True, spirv_bytes=640, assembly="spirv/lamp.spvasm"),
        ),
        declared=(Declared(kind="uniform", name="a", type="float", location=0),),
    )
    (folder / "spirv").mkdir(parents=True)
    (folder / "spirv" / "lamp.spvasm").write_text("; fragment\n%main = OpFunction <img src=x>\n")
    picture = np.random.default_rng(2).random((256, 256, 3)).astype("f4")
    writer = PictureWriter(folder, "lamp", "good")
    shown = writer.write_picture(Image(picture, "rgba32f"))
    note = ErratumNote(section="5.1", says="the lamp is off", truth="it is on", proof="F(7)")
    common = {"programs": (program,), "images": shown.files, "captions": shown.captions}
    lamp_records: list[Record] = [
        record("lamp", "good", title="A lamp", curves=(curve(),), errata=(note,),
               expectations=(judged(folder, "good", arrays(3, wrong=False)),), **common),
        record("lamp", "bad", title="A lamp", status="fail",
               expectations=(judged(folder, "bad", bad),), **common),
    ]  # fmt: skip
    other = replace(
        lamp_records[0], id="blend", variant="default", title="Blending", section="6.3",
        lesson="Two colours become one.",
    )  # fmt: skip
    made = run(*lamp_records, other)
    save(made, folder)
    (folder / "single.html").write_text(render_single(made, folder), encoding="utf-8")
    return Sample(write(made, folder), made, bad)
