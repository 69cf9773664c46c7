"""The fault table: cases that hang, crash, or eat memory cost themselves and nothing else."""

from __future__ import annotations

import sys
from typing import Any

import pytest

from tests.gpu import faulty

linux = pytest.mark.skipif(sys.platform != "linux", reason="signals and limits of Linux")

FAULTS: dict[str, dict[str, str]] = {
    "endless": {"body": faulty.ENDLESS, "before": faulty.in_draw("endless", faulty.ALARM)},
    "segfault": {
        "before": faulty.in_draw("segfault", "os.kill(os.getpid(), signal.SIGSEGV)"),
    },
    "abort": {"before": faulty.in_draw("abort", "os.abort()")},
    "huge": {"target": ", target=Target(size=(16384, 16384))"},
    "hungry": {"before": faulty.in_draw("hungry", "bytearray(64 << 30)")},
    "nans": {"body": "x = sqrt(-1.0 - x); FragColor = vec4(x / 0.0); if (x != 0.5) return;"},
    "raises": {"before": "1 / 0"},
    "exits": {"before": "raise SystemExit(0)"},
    "quits": {"before": faulty.in_draw("quits", "raise SystemExit(3)")},
    "leaves": {"before": "import os; os._exit(0)"},
    "stays": {"before": f"import signal; {faulty.ALARM}\nwhile True: pass"},
    "speaks": {"before": "print('{' * 9999)"},
}
EXPECTED = {
    "endless": "timeout",
    "segfault": "crash",
    "abort": "crash",
    "huge": "error",
    "hungry": "error",
    "nans": "fail",
    "raises": "error",
    "exits": "error",
    "quits": "error",
    "leaves": "crash",
    "stays": "timeout",
    "speaks": "pass",
}


@pytest.fixture(scope="module")
def survived(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    """The records of one run of everything that is wrong, with good cases in between."""
    folder = tmp_path_factory.mktemp("faults")
    for name, parts in FAULTS.items():
        faulty.write(folder / "cases", name, **parts)
        faulty.write(folder / "cases", f"{name}_then_good")
    eight = "\n".join(f"layout(location={i}) out vec4 a{i};" for i in range(1, 8))
    shader = folder / "cases" / "huge.frag"
    text = shader.read_text().replace("out vec4 FragColor;", f"out vec4 FragColor;\n{eight}")
    written = "".join(f"a{i} = vec4(1.0);" for i in range(1, 8))
    shader.write_text(text.replace("float x", f"{written} float x"))
    done = faulty.shaderlab(
        "./cases", "--timeout", "60", "--memory", "4", "-j", "2", "--json", "out.json",
        "--report", "run", "--size", "16", cwd=folder,
    )  # fmt: skip
    assert done.returncode == 1, done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    assert (folder / "run" / "index.html").is_file()
    assert len(faulty.kept(folder / "run")) == 2 * len(FAULTS)
    found: dict[str, dict[str, Any]] = faulty.results(folder / "out.json")
    found["output"] = {"text": done.stdout}
    return found


@linux
@pytest.mark.parametrize("name", FAULTS)
def test_each_fault_ends_as_it_should(survived: dict[str, Any], name: str) -> None:
    assert survived[name]["status"] == EXPECTED[name]


@linux
def test_every_other_case_passes(survived: dict[str, Any]) -> None:
    good = [case["status"] for key, case in survived.items() if key.endswith("-then-good")]
    assert good == ["pass"] * len(FAULTS)


@linux
def test_order_is_that_of_the_files(survived: dict[str, Any]) -> None:
    ids = [key for key in survived if key != "output"]
    assert ids == sorted(ids)


@linux
@pytest.mark.parametrize(
    ("name", "said"),
    [
        (
            "endless",
            ["took longer than 60 s", "draw 0 of pass 'main'", "endless.frag", "llvmpipe"],
        ),
        ("segfault", ["SIGSEGV", "draw 0 of pass 'main'", "segfault.frag"]),
        ("abort", ["SIGABRT"]),
        ("huge", ["16384 × 16384 with 8 attachments takes 32 GB"]),
        ("hungry", ["out of memory"]),
        ("stays", ["importing the case file: took longer than 60 s"]),
        ("quits", ["quits.py:", "raised SystemExit: 3"]),
        ("leaves", ["importing the case file", "exit status 0"]),
        ("raises", ["ZeroDivisionError"]),
    ],
)
def test_the_last_step_is_told(survived: dict[str, Any], name: str, said: list[str]) -> None:
    text = survived["output"]["text"]
    told = text[text.index(f"✗ {name} · ") :].split("✗ ")[1]
    for words in said:
        assert words in told
