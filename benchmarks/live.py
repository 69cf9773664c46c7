"""Counts the cases whose live picture is what was judged: `python -m benchmarks.live [CASE…]`.

Each case is drawn by the WebGL2 driver with the texts that the page has. Then its recording is
played by the page's own script, and what that draws is put in the place of the driver's picture and
judged by the case's own expectations of it. With --draw nothing is judged: the two pictures are
compared alone. With --redraw each case's picture is drawn by OpenGL, as for a page, and the time is
measured that the page takes to draw it anew when a number changes. It takes Chromium.
"""

from __future__ import annotations

import base64
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from shaderlab.drivers.programs.module_texts import write_point_texts
from shaderlab.drivers.programs.prepare import PreparedDraw
from shaderlab.drivers.webgl.device import Browser
from shaderlab.drivers.webgl.live import record_calls, write_essl
from shaderlab.drivers.webgl.program import Program
from shaderlab.drivers.webgl.session import WebGLBackend, WebGLSession
from shaderlab.engine.catalogue import load_case
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.pictures import with_read_passes
from shaderlab.engine.run import SceneRunner, picture_of
from shaderlab.errors import ShaderlabError, UnsupportedError
from shaderlab.model.case import Scene
from shaderlab.model.options import RunOptions
from shaderlab.report.rendering import live_script

MOST = 6
"""Numbers that are changed in a picture, one after the other."""
UNPACK = """
    const packed = new Blob([Uint8Array.fromBase64(text)]).stream();
    const stream = packed.pipeThrough(new DecompressionStream("deflate"));
    const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
"""
PLAY = f"""async (text) => {{
    {UNPACK}
    try {{
        const live = play(unpack(bytes));
        live.lose();
        return ["", new Uint8Array(live.own.buffer).toBase64()];
    }} catch (error) {{
        return [error.message, ""];
    }}
}}"""
REDRAW = f"""async (text) => {{
    {UNPACK}
    const box = document.createElement("section");
    box.innerHTML = '<p class="tool"></p>';
    const colours = {{ broken: [255, 0, 255] }};
    const tools = {{ general: String, ramp: Array(256).fill([0, 0, 0]), colours }};
    try {{
        const panel = shaderlabLive(box, [["", "", ""]], bytes, tools);
        const {{ live, small }} = panel;
        const timed = (played) => {{
            const started = performance.now();
            panel.paint(played);
            return performance.now() - started;
        }};
        const found = [];
        for (const {{ all, own }} of live.uniforms.slice(0, {MOST})) {{
            const change = (factor) => {{
                for (const numbers of all) numbers.set(own.map((value) => value * factor));
            }};
            const moving = Math.min(...[1.01, 1.02, 1.03].map((factor) => {{
                change(factor);
                return timed(small ?? live);
            }}));
            found.push([moving, small ? timed(live) : moving]);
        }}
        for (const each of [live, small]) each?.lose();
        return ["", found, small?.show.size[0] ?? live.show.size[0]];
    }} catch (error) {{
        return [error.message, [], 0];
    }}
}}"""
SIDE = 512
"""Pixels of a page's picture."""
GOAL = 50.0
"""Milliseconds in which a page's picture is to be drawn anew."""


class PageSession(WebGLSession):
    """Draws with the page's texts."""

    def program_of(self, draw: PreparedDraw) -> Program:
        if draw.rewritten is not None:
            return super().program_of(draw)  # the lab's own way of capturing
        texts = write_point_texts(draw.draw, draw.texts)

        def make() -> Program:
            return Program(self.device, write_essl(texts, draw.interface), draw.interface)

        return self.linker.get(("page", *sorted(texts.items())), make)


class Page:
    """The page's script in a browser."""

    def __init__(self, browser: Any) -> None:
        self._browser = browser
        script = live_script().rstrip().removesuffix("}")
        self._wait(f"{script}Object.assign(globalThis, {{ unpack, play }}); }}")

    def ask(self, question: str, recording: bytes) -> Any:
        return self._wait(question, base64.b64encode(recording).decode())

    def _wait(self, *given: str) -> Any:
        return self._browser._wait(self._browser._page.evaluate(*given))


def record(evaluation: Evaluation, side: int) -> tuple[bytes, str]:
    scene, drawn = evaluation.scene, evaluation.drawn
    shown = picture_of(scene, drawn.images)
    return record_calls(evaluation.session, drawn, with_read_passes(scene, [shown[0]]), shown, side)


def judge(runner: SceneRunner, page: Page, scene: Scene) -> tuple[str, float]:
    """How a scene's live picture is judged, or why it has none; and how far it is from what the
    driver draws."""
    try:
        with runner.evaluation(scene, runner.prepare(scene)) as evaluation:
            recording, why = record(evaluation, runner.options.size)
            said, values = ("", "") if why else page.ask(PLAY, recording)
            if why or said:
                return f"none: {why}" if why else f"not played: {said}", 0.0
            far = put_played(evaluation, base64.b64decode(values))
            bad = [] if "--draw" in sys.argv else list(find_failures(evaluation))
    except ShaderlabError as error:
        return f"none: {error.message}", 0.0
    return ("fail: " + ", ".join(bad) if bad else "pass"), far


def put_played(evaluation: Evaluation, values: bytes) -> float:
    """Put what was played where the driver's picture is; returns how far they are apart."""
    images: Any = evaluation.drawn.images
    shown = picture_of(evaluation.scene, images)
    measured = images[shown].values
    kind = np.float32 if measured.dtype == np.float16 else measured.dtype
    played = np.frombuffer(values, kind).reshape(measured.shape)
    images[shown] = replace(images[shown], values=played.astype(measured.dtype))
    with np.errstate(invalid="ignore"):
        off = np.abs(played.astype(float) - measured.astype(float))
    return float(np.where(np.isnan(played) & np.isnan(measured), 0.0, off).max())


def find_failures(evaluation: Evaluation) -> Iterator[str]:
    """The expectations of the picture that fail."""
    scene = evaluation.scene
    shown = picture_of(scene, evaluation.drawn.images)
    for _, expectation in evaluation.iter_with_release():
        reads = ((read.pass_name, read.output) for read in expectation.find_reads(scene))
        with suppress(UnsupportedError):  # of the driver, not of the picture
            if shown in reads and evaluation.judge(expectation).outcome.status != "pass":
                yield expectation.name


def scenes() -> Iterator[Scene]:
    """The first variant of each case, or of those that the command names."""
    only = [word for word in sys.argv[1:] if not word.startswith("-")]
    for path in sorted(Path("cases").glob("ch*/*.py")):
        if not path.name.startswith("_"):
            scene = next(iter(load_case(path).scenes()))
            if not only or scene.case.id in only:
                yield scene


def judge_all() -> None:
    """Print a line for each case that is not judged alike, and the counts of cases."""
    WebGLBackend.session_class = PageSession
    counts: Counter[str] = Counter()
    with SceneRunner(RunOptions(driver="webgl2", modules=False)) as runner:
        page = Page(runner.backend.device._browser)  # type: ignore[attr-defined]
        for scene in scenes():
            started = time.perf_counter()
            said, far = judge(runner, page, scene)
            word = said.partition(":")[0]
            near = "" if far == 0.0 else ", near" if far < 0.004 else ", off"
            counts[word + near * (word == "pass")] += 1
            if word != "pass" or far or "--times" in sys.argv:
                seconds = time.perf_counter() - started
                print(f"{scene.case.id}: {said}; off by {far:.3g} ({seconds:.1f} s)", flush=True)
    print(dict(counts))


def time_all() -> None:
    """Print how long each case takes to be drawn anew, the slowest of its numbers counting."""
    slowest = {}
    browser = Browser()
    with SceneRunner(RunOptions(modules=False)) as runner:
        page = Page(browser)
        for scene in scenes():
            try:
                with runner.evaluation(scene, runner.prepare(scene)) as evaluation:
                    recording, why = record(evaluation, SIDE)
                said, times, side = ("", [], 0) if why else page.ask(REDRAW, recording)
            except ShaderlabError as error:
                said, times, why = error.message, [], ""
            if why or said or not times:
                print(f"{scene.case.id}: {why or said or 'no number to change'}", flush=True)
                continue
            moving, whole = (max(each[n] for each in times) for n in (0, 1))
            slowest[scene.case.id] = moving
            print(f"{scene.case.id}: {moving:.0f} ms at {side}, {whole:.0f} in full", flush=True)
    browser.close()
    late = [name for name, moving in slowest.items() if moving > GOAL]
    print(f"{len(slowest)} cases, median {median(slowest.values()):.0f} ms, over {GOAL:g}: {late}")


if __name__ == "__main__":
    time_all() if "--redraw" in sys.argv else judge_all()
