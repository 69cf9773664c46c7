"""The rewrites of shipped shaders are of what stands there now."""

from __future__ import annotations

import pytest

from benchmarks.rewrites import Rewrite, rewrites
from shaderlab.engine.catalogue import shipped_cases


@pytest.mark.parametrize("kind", ["right", "wrong"])
def test_each_rewrites_a_shader_of_today(kind: str) -> None:
    found = rewrites(kind)
    known = {file.stem.replace("_", "-") for file in shipped_cases()}
    assert len(found) == len(set(found)) > 50
    for rewrite in found:
        assert rewrite.text() and rewrite.case in known, str(rewrite)


def test_a_piece_that_is_gone_is_told() -> None:
    with pytest.raises(ValueError, match="does not have 'no such piece'"):
        Rewrite("lib/reflection.glsl", "specular", "no such piece", "").text()
