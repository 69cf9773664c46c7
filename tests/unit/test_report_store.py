"""A run as JSON: exact round trips, strictness, and the public view's documented shape."""

from __future__ import annotations

import enum
import json
import math
import os
import re
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab.errors import Diagnostic, ShaderlabError, UsageError, Verdict
from shaderlab.model.records import (
    Attachment,
    Curve,
    Declared,
    ErratumNote,
    Outcome,
    PassRecord,
    ProgramRecord,
    Record,
    Row,
    Run,
    SourceText,
    Worst,
)
from shaderlab.model.store import load, save, to_plain
from shaderlab.report.formats.json import render

NAN, INF = math.nan, math.inf
ODD = "\x00\x1b</script>\udc80 ½ 🜂"


def full_run() -> Run:
    """A run with every field set to something that is hard to keep."""
    source = SourceText(file=ODD, line=3, language="glsl", text=ODD)
    said = Diagnostic(file="a.frag", line=None, severity="warning", message=ODD, token="x")
    verdict = Verdict(target="vulkan1.3", ok=False, diagnostics=(said,), spirv_bytes=12)
    worst = Worst(
        pixel=(1, 2),
        component=0,
        measured=(NAN, 0.1),
        reference=(-0.0, 5e-324),
        low=(-INF, 1 / 3),
        high=(INF, 1.7976931348623157e308),
        ulp=INF,
        widths=NAN,
        inputs={"light.constant": (1.0, NAN)},
    )
    outcome = Outcome(
        name="factor",
        kind="formula",
        status="fail",
        message=ODD,
        judged=4096,
        outside=3,
        worst=worst,
        vacuous=0.01,
        undecided=0.2,
        rows=(Row(label="F(7)", expected=".01", measured=".02", ok=False, note=ODD),),
        images={"measured": "a.png"},
        captions={"measured": ODD},
        sources=(source,),
        values="a.values",
    )
    curve = Curve(
        title="t",
        x_label="x",
        y_label="y",
        x=(1.0, 2.0),
        measured=(NAN, INF),
        reference=(0.1, 0.2),
        low=(0.0, -INF),
        high=(1.0, INF),
        log_x=True,
    )
    record = Record(
        id="a",
        variant="v",
        title="A",
        section="5.5.2",
        lesson="l",
        formula="x",
        file="cases/a.py",
        status="fail",
        message="m",
        seconds=0.25,
        timings={"draw": 0.1},
        compile={"vulkan1.3": "refused"},
        programs=(
            ProgramRecord(
                files=("a.frag",),
                sources=(source,),
                verdicts=(verdict,),
                declared=(Declared(kind="uniform", name=ODD, type="vec3[2]", used=False),),
            ),
        ),
        expectations=(outcome, Outcome(name="n", kind="value", status="pass")),
        curves=(curve,),
        errata=(ErratumNote(section="1", says="a", truth="b", proof="c"),),
        inputs={"k": "v"},
        notices=("n",),
        unread=("main.a",),
        images={"picture": "p.png"},
        captions={"picture": "c"},
        passes=(
            PassRecord(
                name="main",
                draws=(("a.vert", "a.frag"), ("b.frag",)),
                reads=("shadow.depth",),
                attachments=(Attachment(name="factor", format="r32f", image="f.png"),),
                size=(64, 48),
            ),
        ),
    )
    crashed = Record(
        id="b", variant="w", title="", section="", lesson="", formula="", file="", status="crash"
    )
    return Run(
        driver={"renderer": "llvmpipe"},
        versions={"numpy": "2"},
        started="2026-11-21T10:33:00+00:00",
        seconds=3.5,
        records=(record, crashed),
        replaced={"a.frag": "mine.frag"},
        missing=2,
    )


def bits(value: object) -> object:
    """Everything in `value` in a form where NaN equals NaN, and −0 is not 0."""
    if isinstance(value, float):
        return ("float", struct.pack(">d", math.nan if math.isnan(value) else value))
    if isinstance(value, dict):
        return {key: bits(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return tuple(bits(item) for item in value)
    if hasattr(value, "__dataclass_fields__"):
        return (type(value), {name: bits(getattr(value, name)) for name in vars(value)})
    return (type(value), value)


def test_a_round_trip_is_exact(tmp_path: Path) -> None:
    before = full_run()
    path = save(before, tmp_path / "new" / "folder")
    assert path == tmp_path / "new" / "folder" / "run.json"
    assert bits(load(path.parent)) == bits(before)


def test_the_comparison_can_fail(tmp_path: Path) -> None:
    assert bits(0.0) != bits(-0.0) and bits(1) != bits(1.0) and bits((1.0,)) != bits([1.0])


def refuse(word: str) -> None:
    raise AssertionError(f"{word} is no JSON")


def test_the_files_json_is_strict(tmp_path: Path) -> None:
    text = save(full_run(), tmp_path).read_text(encoding="utf-8")
    data = json.loads(text, parse_constant=refuse)
    worst = data["records"][0]["expectations"][0]["worst"]
    assert worst["measured"] == ["nan", 0.1] and worst["low"][0] == "-inf" and worst["ulp"] == "inf"


class Named(enum.StrEnum):
    """Names of variants, as a case may have them."""

    NEAR = "near"

    def __str__(self) -> str:
        return "another text"


@pytest.mark.parametrize("odd", [1.0, math.nan])
def test_numbers_of_numpy_and_strings_of_other_classes_are_written_as_what_they_are(
    tmp_path: Path, odd: float
) -> None:
    def run(variant: str, seconds: Any, size: Any, text: str) -> Run:
        record = replace(full_run().records[0], variant=variant, seconds=seconds, size=size)
        return replace(full_run(), records=(replace(record, title=text),), seconds=odd)

    made = run(Named.NEAR, np.float32(0.5), np.int64(3), np.str_("t"))
    usual = run("near", 0.5, 3, "t")
    assert bits(load(save(made, tmp_path).parent)) == bits(usual)
    assert repr(to_plain(made)) == repr(to_plain(usual))
    assert repr(to_plain(np.float64(odd))) == repr(to_plain(odd))


def test_the_public_json_is_strict_and_as_documented() -> None:
    public = json.loads(render(full_run()))
    assert set(public) >= {"driver", "seconds", "cases"}
    case = public["cases"][0]
    assert set(case) >= {
        "id", "variant", "status", "seconds", "compile", "expectations", "images",
    }  # fmt: skip
    first = case["expectations"][0]
    assert set(first) >= {
        "name", "kind", "status", "message", "worst", "vacuous", "undecided", "judged", "outside",
        "values",
    }  # fmt: skip
    assert first["values"] == [
        {"label": "F(7)", "expected": ".01", "measured": ".02", "ok": False, "note": ODD}
    ]
    assert first["worst"]["inputs"] == {"light.constant": [1.0, "nan"]}
    assert case["expectations"][1]["worst"] is None
    assert public["cases"][1]["status"] == "crash"


def test_the_documentation_names_every_public_field() -> None:
    text = (Path(__file__).parents[2] / "docs" / "guide" / "json.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([a-z_]+)`", text))

    def fields(value: object) -> set[str]:
        if isinstance(value, dict):
            found = set() if "light.constant" in value else set(value)
            return found.union(*(fields(v) for k, v in value.items() if k != "inputs"))
        if isinstance(value, list):
            return set().union(*(fields(item) for item in value))
        return set()

    keys = {"renderer", "measured", "picture"}  # keys of maps, not fields
    missing = {f for f in fields(json.loads(render(full_run()))) if f.isidentifier()} - named - keys
    assert not missing


def test_a_failed_save_leaves_the_old_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    save(full_run(), tmp_path)
    before = (tmp_path / "run.json").read_bytes()

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(ShaderlabError, match="No space left"):
        save(full_run(), tmp_path)
    assert (tmp_path / "run.json").read_bytes() == before
    assert len(list(tmp_path.iterdir())) == 1


def test_a_missing_run_is_a_usage_error(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no run was saved") as caught:
        load(tmp_path / "nowhere")
    assert caught.value.file == str(tmp_path / "nowhere" / "run.json")


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text[: len(text) // 2],
        lambda text: "[]",
        lambda text: text.replace('"seconds":3.5', '"seconds":"soon"'),
        lambda text: text.replace('"seconds":3.5', '"seconds":true'),
        lambda text: text.replace('"status":"crash"', '"status":"fine"'),
        lambda text: text.replace('"started"', '"begun"'),
        lambda text: text.replace('"judged":4096', '"judged":"4096"'),
        lambda text: text.replace('"log_x":true', '"log_x":"yes"'),
    ],
)
def test_a_damaged_run_names_the_file(tmp_path: Path, change: object) -> None:
    path = save(full_run(), tmp_path)
    old = path.read_text()
    new = change(old)  # type: ignore[operator]
    assert new != old
    path.write_text(new)
    with pytest.raises(ShaderlabError, match="not a run of this version") as caught:
        load(tmp_path)
    assert caught.value.file == str(path)
