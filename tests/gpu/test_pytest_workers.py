"""Under pytest a worker runs items: each when its turn comes, each record at its own item, and no
more run than is asked for."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest

from shaderlab.engine.jobs import ProcessExecutor, make_jobs
from shaderlab.model.options import RunOptions
from tests.gpu import faulty

TELL = "open('{file}', 'a').write('once ')"
PID = "open('{told}/pids', 'a').write(str(os.getpid()) + ' ')"
OUTCOMES = ("-rA", "--tb=no", "-o", "shaderlab_jobs=2")


class Cases:
    """A folder in which cases are written that do something in the middle of their draw."""

    def __init__(self, pytester: pytest.Pytester) -> None:
        self.pytester = pytester
        self.told = pytester.path / "told"
        self.told.mkdir()

    def add(self, name: str, act: str = "pass", *, wrong: bool = False) -> Path:
        """A case that tells when it is drawn, then acts; a wrong one fails."""
        acts = f"{TELL.format(file=self.told / name)}\n    {act.format(told=self.told)}"
        body = "x = 10.0;" if wrong else ""
        before = faulty.in_draw(name, acts)
        file: Path = faulty.write(self.pytester.path, name, before=before, body=body)
        return file

    def count(self) -> dict[str, int]:
        """How often each case was drawn."""
        return {file.name: file.read_text().count("once") for file in self.told.iterdir()}

    def run(self, *args: str | Path) -> pytest.RunResult:
        """A session in this process; its workers are others."""
        return self.pytester.runpytest_inprocess(*map(str, args))


@pytest.fixture
def cases(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> Cases:
    monkeypatch.delenv("SHADERLAB_JOBS", raising=False)
    return Cases(pytester)


def test_with_one_worker_nothing_is_begun_before_its_turn(cases: Cases) -> None:
    cases.pytester.makeconftest(
        "import os, time\ndef pytest_runtest_setup(item):\n    time.sleep(0.3)\n"
        f"    assert not os.path.exists(os.path.join({str(cases.told)!r}, item.name))"
    )
    files = [cases.add(name) for name in "ab"]
    cases.run(*files, "-o", "shaderlab_jobs=1").assert_outcomes(passed=2)


def test_each_outcome_and_duration_is_at_its_own_item(cases: Cases) -> None:
    files = [
        cases.add("a"),
        cases.add("b", wrong=True),
        cases.add("c", "os.kill(os.getpid(), 11)"),
        cases.add("d", "__import__('time').sleep(0.5)"),
        cases.add("e", faulty.HANG),
        cases.add("f", "os._exit(3)"),
        cases.add("g"),
    ]
    options = (*OUTCOMES, "--tb=short", "-o", "shaderlab_timeout=60", "--junitxml=found.xml")
    result = cases.run(*files, *options)
    assert outcomes(result) == dict(zip("abcdefg", "PFFPFFP", strict=True))
    last = "*last step: draw 0 of pass 'main', program "
    result.stdout.fnmatch_lines(
        ["*b · T", "*FragColor (exact)*", "*c · T", "*SIGSEGV*", f"{last}c.frag", "*e · T",
         "*took longer than 60 s", f"{last}e.frag", "*f · T", "*exit status 3*", f"{last}f.frag"]
    )  # fmt: skip
    found = ElementTree.parse(files[0].parent / "found.xml").getroot().iter("testcase")
    seconds = {case.attrib["name"]: float(case.attrib["time"]) for case in found}
    assert seconds["e"] == pytest.approx(60.0, abs=1.0)  # the limit, not the clock
    assert seconds["d"] >= 0.5


def outcomes(result: pytest.RunResult) -> dict[str, str]:
    """The first letter of each item's outcome, by its case."""
    lines = [line.split() for line in result.outlines if "::" in line]
    return {line[1].split("::")[1]: line[0][0] for line in lines if line[0].isupper()}


SELECTING = """
import pytest
from _pytest.runner import runtestprotocol

def pytest_collection_modifyitems(items):
    items.reverse()
    for item in items:
        if item.name == "marked":
            item.add_marker("skip")

def pytest_runtest_setup(item):
    if item.name == "passed-over":
        pytest.skip("not today")

def pytest_runtest_protocol(item, nextitem):
    if item.name != "twice":
        return None
    for _ in range(2):
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        for report in runtestprotocol(item, nextitem=nextitem, log=False):
            item.ihook.pytest_runtest_logreport(report=report)
    return True
"""


def test_what_is_left_out_turned_round_or_run_twice(cases: Cases) -> None:
    cases.pytester.makeconftest(SELECTING)
    for name in ("early", "left_out", "marked", "passed_over", "twice"):
        cases.add(name)
    cases.add("wrong", wrong=True)
    result = cases.run(*OUTCOMES, "-k", "not left_out")
    result.assert_outcomes(passed=3, failed=1, skipped=2, deselected=1)
    assert outcomes(result) == {"early": "P", "twice": "P", "wrong": "F"}
    count = cases.count()
    assert count == {"twice": 2, "wrong": 1, "early": 1}


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes as Linux shows them")
def test_an_interrupt_ends_everything_at_once(cases: Cases) -> None:
    files = [cases.add("a", f"{PID}; __import__('time').sleep(600)")]
    command = [sys.executable, "-m", "pytest", *map(str, files), *OUTCOMES]
    session = subprocess.Popen(
        [*command, "-o", "shaderlab_timeout=600"], cwd=cases.pytester.path, stdout=subprocess.PIPE,
        text=True, env=faulty.surroundings(), preexec_fn=faulty.restore_interrupts,
    )  # fmt: skip
    pids = cases.told / "pids"
    while not pids.exists() or not pids.read_text().endswith(" "):
        assert session.poll() is None
        time.sleep(0.01)
    session.send_signal(signal.SIGINT)
    said, _ = session.communicate(timeout=120.0)
    assert session.returncode == pytest.ExitCode.INTERRUPTED and "KeyboardInterrupt" in said
    workers = [Path("/proc", pid) for pid in pids.read_text().split()]
    assert len(workers) == 1
    end = time.monotonic() + 60.0  # a process that was killed takes a moment to end
    while any(worker.exists() for worker in workers):
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.parametrize(("options", "names"), [((), ["inner"]), (("--full-trace",), None)])
def test_only_the_last_frame_of_an_interrupt_is_looked_at(
    pytester: pytest.Pytester, options: tuple[str, ...], names: list[str] | None
) -> None:
    """Parsing the sources of all takes pytest a second; --full-trace still has them."""

    def inner() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as raised:
        inner()
    hook = pytester.parseconfigure(*options).hook
    for found in hook.pytest_keyboard_interrupt.get_hookimpls():
        if found.plugin_name.isdecimal():  # registered without a name
            found.function(raised)
    assert len(raised.traceback) == 2 if names is None else raised.traceback[0].name in names


def test_under_xdist_each_variant_is_run_once(
    cases: Cases, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHADERLAB_JOBS", "0")  # its own processes are enough to start
    for name in "abcd":
        cases.add(name, wrong=name == "d")
    result = cases.run("-n2", *OUTCOMES, "--tb=short")
    assert outcomes(result) == dict(zip("abcd", "PPPF", strict=True))
    assert cases.count() == dict.fromkeys("abcd", 1)
    result.stdout.fnmatch_lines(["*FragColor (exact)*"])


def test_a_number_of_workers_that_is_none_is_said(
    cases: Cases, monkeypatch: pytest.MonkeyPatch
) -> None:
    cases.add("a")
    for value in ("two", "-1", "1.5", "²"):
        result = cases.pytester.runpytest_inprocess("-o", f"shaderlab_jobs={value}")
        assert result.ret != 0
        assert f"shaderlab_jobs is {value!r}" in result.stdout.str() + result.stderr.str()
    monkeypatch.setenv("SHADERLAB_JOBS", "many")
    result = cases.pytester.runpytest_inprocess("-o", "shaderlab_jobs=2")
    assert "SHADERLAB_JOBS is 'many'" in result.stdout.str() + result.stderr.str()


def test_the_environment_goes_before_the_configuration(
    cases: Cases, monkeypatch: pytest.MonkeyPatch
) -> None:
    pids = cases.told / "pid"
    alone = cases.add("alone", f"open('{pids}', 'w').write(str(os.getpid()))")
    for jobs, here in (("0", True), ("1", False)):
        monkeypatch.setenv("SHADERLAB_JOBS", jobs)
        cases.run(alone, "-o", "shaderlab_jobs=2").assert_outcomes(passed=1)
        assert (pids.read_text() == str(os.getpid())) is here


def test_runs_of_one_executor_keep_their_notes_apart(cases: Cases) -> None:
    """One that was left may have jobs under way, whose notes are not those of the next one."""
    files = [cases.add("a"), cases.add("dies", "os._exit(3)"), cases.add("b")]
    options = RunOptions(pictures=False)
    with contextlib.closing(ProcessExecutor(workers=1)) as executor:
        jobs = [job for facts in executor.load(files) for job in make_jobs(facts)]
        first = executor.run(jobs, options)
        assert next(first)[1].status == "pass"
        second = executor.run(jobs[:1], options)
        assert [record.status for _, record in second] == ["pass"]
        assert "program dies.frag" in next(first)[1].message
        assert [record.status for _, record in first] == ["pass"]
