"""Runs to make reports of, and a parser that looks at the page. No tests are in here."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

from shaderlab.errors import Diagnostic, Verdict
from shaderlab.files import write_text
from shaderlab.model.records import (
    Curve,
    ErratumNote,
    Outcome,
    Plot,
    PlotPoint,
    ProgramRecord,
    Record,
    Row,
    Run,
    SourceText,
    Worst,
)
from shaderlab.report.html import render_single

HOSTILE = "</script></style><img src=x onerror=alert(1)>\"'&{{ 7*7 }}\x00\x1b\u202e\udc80"
NAN, INF = float("nan"), float("inf")
VOID = {"meta", "img", "br", "input", "link", "hr"}


def write(run: Run, folder: Path) -> Path:
    """The report of a run as one file, which holds all that can be seen of it."""
    path = folder / "report.html"
    write_text(path, render_single(run, folder))
    return path


class Page(HTMLParser):
    """Parses a page, checks that tags are nested, and keeps what the tests ask about."""

    def __init__(self, path: Path) -> None:
        super().__init__(convert_charrefs=True)
        self.source = path.read_text(encoding="utf-8")
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self.raw: dict[str, str] = {}
        self._open: list[str] = []
        self.feed(self.source)
        self.close()
        assert self._open == [], f"left open: {self._open}"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        assert len(dict(attrs)) == len(attrs), f"an attribute twice: <{tag} {attrs}>"
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self._open and self._open[-1] == tag, f"</{tag}> closes {self._open[-3:]}"
        self._open.pop()

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] in ("style", "script"):
            self.raw[self._open[-1]] = self.raw.get(self._open[-1], "") + data
        elif "template" not in self._open:  # what only scripts see
            self.text.append(data)

    def words(self) -> str:
        return re.sub(r"[ \n]+", " ", " ".join(self.text))

    def attributes(self, name: str) -> list[str]:
        return [attrs[name] or "" for _, attrs in self.tags if name in attrs]


def worst(value: float = 0.5) -> Worst:
    return Worst(
        pixel=(3, 5),
        component=1,
        measured=(0.25, value),
        reference=(0.25, 0.5),
        low=(0.25, 0.4999),
        high=(0.25, 0.5001),
        ulp=12.0,
        widths=2.5,
        inputs={"distance": (1.5, NAN)},
    )


def outcome(**changes: object) -> Outcome:
    fields: dict[str, object] = {"name": "factor", "kind": "formula", "status": "pass"}
    return Outcome(**(fields | {"judged": 1000} | changes))  # type: ignore[arg-type]


def record(id: str = "ch05/attenuation", variant: str = "default", **changes: object) -> Record:
    fields: dict[str, object] = {
        "id": id,
        "variant": variant,
        "title": "Attenuation",
        "section": "5.5.2",
        "chapter": "Lighting",
        "lesson": "The light fades.\n\n- one `d`\n- two",
        "formula": r"\frac{1}{K_c + K_l d}",
        "file": "cases/a.py",
        "status": "pass",
        "expectations": (outcome(),),
    }
    return Record(**(fields | changes))  # type: ignore[arg-type]


def run(*records: Record, **changes: object) -> Run:
    fields: dict[str, object] = {
        "driver": {"renderer": "llvmpipe", "vendor": "Mesa", "version": "4.5", "glsl": "4.50"},
        "versions": {"numpy": "2.0"},
        "started": "2026-11-21T10:33:00+00:00",
        "seconds": 1.5,
        "records": records,
    }
    return Run(**(fields | changes))  # type: ignore[arg-type]


def curve(**changes: object) -> Curve:
    fields: dict[str, object] = {
        "title": "Light over distance",
        "x_label": "distance",
        "y_label": "factor",
        "x": (0.0, 1.0, 2.0, 3.0),
        "measured": (1.0, 0.5, 0.9, NAN),
        "reference": (1.0, 0.5, 0.25, 0.1),
        "low": (1.0, 0.4, 0.2, -INF),
        "high": (1.0, 0.6, 0.3, INF),
    }
    return Curve(**(fields | changes))  # type: ignore[arg-type]


def hostile() -> Run:
    """A run in which every free string is an attack."""
    h = HOSTILE
    source = SourceText(file=h, line=1, language="glsl", text=f"void main() {{}} // {h}\n{h}")
    formula = SourceText(file=h, line=7, language="python", text=f"def f(x):\n    '''{h}'''\n")
    said = Diagnostic(file=h, line=1, severity="error", message=h, token=h)
    verdict = Verdict(target=h, ok=False, diagnostics=(said,), spirv_bytes=4)
    check = outcome(
        name=h,
        kind=h,
        status="fail",
        message=h,
        outside=2,
        vacuous=NAN,
        undecided=0.5,
        worst=replace(worst(INF), inputs={h: (NAN, INF)}),
        rows=(Row(label=h, expected=h, measured=h, ok=False, note=h),),
        images={h: h, "distance": "../../etc/passwd"},
        captions={h: h},
        sources=(source, formula),
    )
    points = tuple(
        PlotPoint(
            series=h + "2" * n, x=float(n), y=NAN if n == 2 else n, low=-INF, high=INF, ok=n < 2
        )
        for n in range(3)
    )
    bad = record(
        h,
        h,
        title=h,
        section="5 " + h,
        chapter=h,
        lesson=f"{h}\n\n- {h}\n\n    {h}\n\n[a](javascript:alert(1)) <b>raw</b>",
        formula=rf"\text{{{h}}} \href{{javascript:alert(1)}}{{x}}",
        file=h,
        status="error",
        message=h,
        timings={h: NAN},
        compile={h: h},
        programs=(ProgramRecord(files=(h,), sources=(source,), verdicts=(verdict,)),),
        expectations=(check,),
        curves=(curve(title=h, x_label=h, y_label=h),),
        plots=(Plot(title=h, x_label=h, y_label=h, points=points),),
        errata=(ErratumNote(section=h, says=h, truth=h, proof=h),),
        inputs={h: h},
        notices=(h,),
        unread=(h,),
        images={h: h},
        captions={h: h},
    )
    return run(
        bad,
        replace(bad, variant=h + "2", programs=()),
        driver={"renderer": h, h: h},
        versions={h: h},
        replaced={h: h},
        started=h,
        seconds=NAN,
    )
