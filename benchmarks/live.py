"""Counts the cases whose live picture is what was judged: `python -m benchmarks.live [CASE…]`.

With --draw nothing is judged: what is drawn is compared alone, in about .3 s a case.

Each case runs on WebGL2 with the texts that the page has, and is judged as on any driver. Then its
recording is played as the page plays it, and compared with what was drawn, bit by bit. It takes
Chromium; about 3 s a case.
"""

from __future__ import annotations

import base64
import sys
import time
from collections import Counter
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from shaderlab.drivers.programs.module_texts import write_point_texts
from shaderlab.drivers.programs.prepare import PreparedDraw
from shaderlab.drivers.webgl.live import record_calls, write_essl
from shaderlab.drivers.webgl.program import Program
from shaderlab.drivers.webgl.session import WebGLBackend, WebGLSession
from shaderlab.engine.catalogue import load_case
from shaderlab.engine.pictures import with_read_passes
from shaderlab.engine.run import SceneRunner, picture_of
from shaderlab.errors import ShaderlabError
from shaderlab.model.case import Scene
from shaderlab.model.options import RunOptions

PLAY = """async (text) => {
    const packed = new Blob([Uint8Array.fromBase64(text)]).stream();
    const stream = packed.pipeThrough(new DecompressionStream("deflate"));
    const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
    const length = Number(new DataView(bytes.buffer).getBigUint64(0, true));
    const about = JSON.parse(new TextDecoder().decode(bytes.subarray(8, 8 + length)));
    const held = makePlayer().hold(about, bytes.slice(8 + length).buffer);
    if (held.lacks) return [held.lacks, ""];
    held.draw();
    const values = held.draw();
    const errors = held.errors();
    held.lose();
    return [errors.join(), new Uint8Array(values.buffer).toBase64()];
}"""


class PageSession(WebGLSession):
    """Draws with the page's texts."""

    def program_of(self, draw: PreparedDraw) -> Program:
        if draw.rewritten is not None:
            return super().program_of(draw)  # the lab's own way of capturing
        texts = write_point_texts(draw.draw, draw.texts)

        def make() -> Program:
            return Program(self.device, write_essl(texts, draw.interface), draw.interface)

        return self.linker.get(("page", *sorted(texts.items())), make)


def compare(runner: SceneRunner, scene: Scene) -> tuple[str, float]:
    """How a scene is judged with the page's texts, or why it has no live picture; and how far what
    its recording draws is from that."""
    programs = runner.prepare(scene)
    try:
        with runner.evaluation(scene, programs) as evaluation:
            drawn = evaluation.drawn
            shown = picture_of(scene, drawn.images)
            only = with_read_passes(scene, [shown[0]])
            parts = evaluation.session, drawn, only, shown, runner.options.size
            recording, why = record_calls(*parts)
            if why:
                return f"none: {why}", 0.0
            browser: Any = runner.backend.device._browser  # type: ignore[attr-defined]
            text = base64.b64encode(recording).decode()
            said, values = browser._wait(browser._page.evaluate(PLAY, text))
            measured = drawn.images[shown].values
    except ShaderlabError as error:
        return f"none: {error.message}", 0.0
    if said:
        return f"not played: {said}", 0.0
    kind = np.float32 if measured.dtype == np.float16 else measured.dtype
    played = np.frombuffer(base64.b64decode(values), kind).reshape(measured.shape)
    with np.errstate(invalid="ignore"):
        off = np.abs(played.astype(float) - measured.astype(float))
    far = float(np.where(np.isnan(played) & np.isnan(measured), 0.0, off).max())
    if "--draw" in sys.argv:
        return "drawn", far
    record = runner.run(scene)
    bad = [each.name for each in record.expectations if each.status != "pass"]
    return ("fail: " + ", ".join(bad) if bad else "pass"), far


def main() -> None:
    """Print a line for each variant that is not judged alike, and the counts of cases."""
    WebGLBackend.session_class = PageSession
    counts: Counter[str] = Counter()
    only = [word for word in sys.argv[1:] if not word.startswith("-")]
    player = files("shaderlab.drivers.webgl").joinpath("player.js").read_text(encoding="utf-8")
    with SceneRunner(RunOptions(driver="webgl2", modules=False)) as runner:
        browser: Any = runner.backend.device._browser  # type: ignore[attr-defined]
        browser._wait(browser._page.evaluate(f"{player}\nwindow.makePlayer = makePlayer;"))
        for path in sorted(Path("cases").glob("ch*/*.py")):
            if path.name.startswith("_"):
                continue
            scene = next(iter(load_case(path).scenes()))
            if only and scene.case.id not in only:
                continue
            started = time.perf_counter()
            said, far = compare(runner, scene)
            word = said.partition(":")[0]
            alike = word in ("pass", "drawn")
            near = ("" if far == 0.0 else ", near" if far < 0.004 else ", off") if alike else ""
            counts[word + near] += 1
            if not alike or far:
                seconds = time.perf_counter() - started
                print(f"{scene.case.id}: {said}; off by {far:.3g} ({seconds:.1f} s)", flush=True)
    print(dict(counts))


if __name__ == "__main__":
    main()
