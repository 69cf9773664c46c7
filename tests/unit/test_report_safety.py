"""The report page is one safe, sound file, written whole."""

from __future__ import annotations

import base64
import hashlib
import itertools
import os
import re
from pathlib import Path

import numpy as np
import pytest

from shaderlab.errors import ShaderlabError
from shaderlab.model import pictures
from shaderlab.report.pictures import Pictures
from tests.unit.test_report_samples import (
    Page,
    curve,
    hostile,
    record,
    run,
    write,
)


def test_hostile_strings_stay_text(tmp_path: Path) -> None:
    page = Page(write(hostile(), tmp_path))
    scripts = [tag for tag, _ in page.tags if tag == "script"]
    assert len(scripts) == 1
    assert {tag for tag, _ in page.tags}.isdisjoint({"iframe", "object", "embed", "link", "base"})
    for tag, attrs in page.tags:
        assert not [name for name in attrs if name.startswith("on")], (tag, attrs)
        assert "style" not in attrs, f"<{tag}> has a style that the policy would refuse"
        for name in ("src", "href", "action"):
            assert (attrs.get(name) or "#").startswith(("#", "data:image/png;base64,")), attrs
    assert "onerror=alert(1)>" in page.words()
    assert "49" not in page.words().replace("0.4999", "")
    assert "[U+202E]" in page.words() and "\u202e" not in page.source
    assert "\x00" not in page.source and "\x1b" not in page.source


def test_nothing_is_asked_of_a_network(tmp_path: Path) -> None:
    pictures.save_png(tmp_path / "p.png", np.zeros((4, 4, 3), np.uint8))
    page = Page(write(run(record(images={"picture": "p.png"}, curves=(curve(),))), tmp_path))
    source = re.sub(r"// |sha256-[\w+/=]+", "", page.source)  # comments, and digests of scripts
    assert not re.search(r"https?:|//[a-z]|@import|url\((?!#)", source)
    images = [a.get("src") or a["href"] for tag, a in page.tags if tag in ("img", "image")]
    assert images and all(str(link).startswith("data:image/png;base64,") for link in images)


def test_the_policy_allows_this_style_and_script_only(tmp_path: Path) -> None:
    page = Page(write(run(record()), tmp_path))
    policy = next(
        str(attrs["content"])
        for tag, attrs in page.tags
        if tag == "meta" and attrs.get("http-equiv") == "Content-Security-Policy"
    )
    assert "default-src 'none'" in policy and "unsafe" not in policy
    for name in ("style", "script"):
        digest = base64.b64encode(hashlib.sha256(page.raw[name].encode()).digest()).decode()
        assert f"{name}-src 'sha256-{digest}'" in policy


def test_anchors_are_unique_and_every_link_has_a_goal(tmp_path: Path) -> None:
    twins = [record("a b"), record("a-b"), record("A B", "x"), record("A B", "x")]
    page = Page(write(run(*twins, *hostile().records), tmp_path))
    ids = page.attributes("id")
    assert len(ids) == len(set(ids))
    goals = [h[1:] for h in page.attributes("href") if h.startswith("#")]
    assert goals and set(goals) <= set(ids)
    for name in ("aria-labelledby",):
        assert set(page.attributes(name)) <= set(ids)


def test_headings_descend_one_level_at_a_time(tmp_path: Path) -> None:
    page = Page(write(hostile(), tmp_path))
    levels = [int(tag[1]) for tag, _ in page.tags if re.fullmatch(r"h[1-6]", tag)]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after - before <= 1 for before, after in itertools.pairwise(levels))


def test_missing_and_outside_pictures_are_noted_not_read(tmp_path: Path) -> None:
    secret = tmp_path / "secret.png"
    pictures.save_png(secret, np.zeros((1, 1, 3), np.uint8))
    folder = tmp_path / "run"
    images = {"picture": "gone.png", "up": "../secret.png", "root": str(secret)}
    page = Page(write(run(record(images=images)), folder))
    assert not [tag for tag, _ in page.tags if tag == "img"]
    assert page.words().count("No picture:") == 3
    assert page.words().count("outside the run's folder") == 2


def test_a_failed_write_leaves_the_old_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(run(record()), tmp_path)
    before = path.read_bytes()

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(ShaderlabError, match="No space left") as caught:
        write(run(), tmp_path)
    assert caught.value.file == str(path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]


def test_links_are_followed_to_what_is_in_the_folder_only(tmp_path: Path) -> None:
    secret = tmp_path / "elsewhere" / "secret.png"
    folder = tmp_path / "run"
    for made in (secret.parent, folder / "images"):
        made.mkdir(parents=True)
    pictures.save_png(secret, np.zeros((1, 1, 3), np.uint8))
    pictures.save_png(folder / "images" / "own.png", np.zeros((1, 1, 3), np.uint8))
    (folder / "beside").symlink_to(folder / "images")
    (folder / "images" / "again.png").symlink_to(folder / "images" / "own.png")
    (folder / "images" / "link.png").symlink_to(secret)
    (folder / "away").symlink_to(secret.parent)
    (folder.parent / "run2").symlink_to(secret.parent)
    found = Pictures(folder)
    for name in (
        "images/own.png",
        "images/again.png",
        "beside/own.png",
        "away/../run/images/own.png",
    ):
        assert not found.find(name).missing, name
    for name in ("images/link.png", "away/secret.png", "../run2/secret.png", "images/../..", ".."):
        assert "outside the run's folder" in found.find(name).missing, name
    assert found.find("images/own.png").path == (folder / "images" / "own.png").resolve()
