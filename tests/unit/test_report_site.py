"""The report as a site: its pages lead to one another, and to nothing that is not there."""

from __future__ import annotations

import fcntl
import itertools
import json
import os
import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from shaderlab.errors import Verdict
from shaderlab.model import pictures, store
from shaderlab.model.records import ProgramRecord, Record, SourceText
from shaderlab.report import html, page as page_module
from tests.unit.test_report_samples import Page, hostile, outcome, record, run, write


def pages(folder: Path) -> dict[Path, Page]:
    return {path: Page(path) for path in folder.rglob("*.html")}


def broken_links(folder: Path) -> Iterator[str]:
    """Every link of every page whose file or place is not there."""
    found = pages(folder)
    for path, page in found.items():
        links = page.attributes("href") + page.attributes("src")
        for link in links:
            if link.startswith("data:"):
                continue
            file, _, anchor = link.partition("#")
            goal = (path.parent / unquote(file)).resolve() if file else path
            if not goal.is_file() or folder not in goal.parents:
                yield f"{path.name}: {link}"
            elif anchor and anchor not in found[goal].attributes("id"):
                yield f"{path.name}: {link}: no such place"


def programs(*texts: str) -> tuple[ProgramRecord, ...]:
    return tuple(
        ProgramRecord(
            files=(f"{text}.frag",),
            sources=(SourceText(file=f"{text}.frag", line=1, language="glsl", text=f"{text};\n"),),
            verdicts=(Verdict(target="vulkan", ok=True, assembly="spirv/a b.txt"),),
        )
        for text in texts
    )


@pytest.fixture
def three(tmp_path: Path) -> Path:
    """A folder with the run of three cases, two of which share a source, and its pages."""
    folder = tmp_path / "run"
    for name in ("images/a b?.png", "spirv/a b.txt"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(b"; text\n")
    pictures.save_png(folder / "images/a b?.png", np.zeros((4, 4, 3), np.uint8))
    failed = outcome(status="fail", message="3 outside", outside=3)
    records: list[Record] = [
        record("lamp", "x", images={"picture": "images/a b?.png"}, programs=programs("one", "both"),
               section="5.1", chapter="Lighting"),
        record("lamp", "y", status="fail", expectations=(failed,), section="5.1"),
        record("blend", programs=programs("both", "two"), section="6.1", chapter="More"),
        record("own", section="", lesson="Nothing but fresnel."),
    ]  # fmt: skip
    made = run(*records)
    store.save(made, folder)
    html.write(made, folder)
    return folder


def test_each_case_has_a_page_and_no_link_is_broken(three: Path) -> None:
    names = {str(path.relative_to(three)) for path in pages(three)}
    assert names == {"index.html", "cases/lamp.html", "cases/blend.html", "cases/own.html"}
    assert list(broken_links(three)) == []
    front = (three / "index.html").read_text()
    assert 'href="cases/lamp.html#case-lamp-y"' in front and "fresnel" not in front
    (three / "cases" / "own.html").unlink()
    assert any("own.html" in found for found in broken_links(three))


def test_both_forms_have_the_same_places(three: Path) -> None:
    """So that a link into one of them is one into the other."""
    single = Page(write(store.load(three), three))
    here = {
        name
        for path, page in pages(three).items()
        if path.parent.name == "cases" or path.name == "index.html"
        for name in page.attributes("id")
    }
    own = set(single.attributes("id")) - here
    assert own == {"search"}


def test_lines_of_sources_have_anchors_of_their_case(three: Path) -> None:
    lines = [
        set(re.findall(r'id="(s\d+-L1)"', (three / "cases" / name).read_text()))
        for name in ("lamp.html", "blend.html")
    ]
    assert len(lines[0]) == len(lines[1]) == 2 and not lines[0] & lines[1]


def test_words_of_lessons_checks_and_sources_are_found(three: Path) -> None:
    text = (three / "page" / "search.js").read_text()
    found = json.loads(re.sub(r",\n};\n$", "}", text.removeprefix("globalThis.shaderlabWords = ")))
    assert "fresnel" in found["case-own"] and "fresnel" not in found["case-lamp"]
    assert "two;" in found["case-blend"] and "outside" in found["case-lamp"]


def test_headings_of_a_cases_page_begin_with_its_title(three: Path) -> None:
    for name in ("lamp", "own"):
        page = Page(three / "cases" / f"{name}.html")
        levels = [int(tag[1]) for tag, _ in page.tags if re.fullmatch(r"h[1-6]", tag)]
        assert levels[0] == 1 and levels.count(1) == 1
        assert all(after - before <= 1 for before, after in itertools.pairwise(levels))


def test_what_all_pages_say_of_the_run_is_found_once(
    three: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []
    monkeypatch.setattr(
        page_module, "format_conditions", lambda run: asked.append(run) or ["a note"]
    )
    html.write(store.load(three), three)
    assert len(asked) == 1
    assert all("a note" in path.read_text() for path in three.rglob("*.html"))


def test_hostile_strings_stay_text_on_every_page(tmp_path: Path) -> None:
    html.write(hostile(), tmp_path)
    for page in pages(tmp_path).values():
        assert [attrs for tag, attrs in page.tags if tag == "script"] == [{}]
        assert {tag for tag, _ in page.tags}.isdisjoint({"iframe", "object", "embed", "base"})
        for tag, attrs in page.tags:
            assert not [name for name in attrs if name.startswith("on")], (tag, attrs)
            for name in ("src", "href"):
                link = attrs.get(name) or "#"
                assert re.match(r"#|data:image/|(\.\./)?(index|cases/|page/|images/)", link), link
        policy = next(str(a["content"]) for _, a in page.tags if "http-equiv" in a)
        assert "default-src 'none'" in policy and "unsafe" not in policy


def test_ids_of_any_length_have_pages_of_their_own(tmp_path: Path) -> None:
    html.write(run(record("x" * 300 + "1"), record("x" * 300 + "2"), record("..")), tmp_path)
    names = [path.name for path in (tmp_path / "cases").iterdir()]
    assert len(names) == 3 and all(len(name) < 150 and name[0] != "." for name in names)


def test_the_single_file_may_be_a_device(three: Path, tmp_path: Path) -> None:
    """It stays one: as root, /dev/null itself would be replaced."""
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    fcntl.fcntl(reader, fcntl.F_SETPIPE_SZ, 1 << 20)
    result = CliRunner().invoke(
        cli, ["report", str(three), "--single-file", str(tmp_path / "pipe")]
    )
    assert result.exit_code == 0 and (tmp_path / "pipe").is_fifo(), result.output
    assert os.read(reader, 15) == b"<!doctype html>"
    os.close(reader)


def test_the_single_file_needs_no_other(three: Path, tmp_path: Path) -> None:
    goal = tmp_path / "mailed.html"
    result = CliRunner().invoke(cli, ["report", str(three), "--single-file", str(goal)])
    assert result.exit_code == 0, result.output
    page = Page(goal)
    links = page.attributes("href") + page.attributes("src")
    assert links and all(link.startswith(("#", "data:")) for link in links)
    assert {link[1:] for link in links if link[0] == "#"} <= set(page.attributes("id"))
