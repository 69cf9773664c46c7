"""`pytest my_cases/` in a folder of someone else's: what is collected, run and shown.

The first half needs no device (a stand-in lab is put in by a conftest, and cases run in pytest's
own process); the last tests draw, in a worker.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import shaderlab.engine.worker
from tests.gpu import faulty

STAND_IN = """
import dataclasses, os
import shaderlab.engine.worker
from shaderlab.model.records import Outcome, Record, Worst

WORST = Worst(pixel=(3, 17), component=0, measured=(0.5,), reference=(0.25,), low=(0.2,),
              high=(0.3,), ulp=9.0, widths=5.0, inputs={"distance": (2.5,)})
BAD = Outcome(name="factor", kind="formula", status="fail", judged=9, outside=4, worst=WORST)

class Lab:
    driver = "a stand-in"
    def __init__(self, options=None, notice=None):
        self.options = options
        print("lab opened in", os.getpid())
    def run(self, scene):
        status = {"far": "fail", "mars": "unsupported"}.get(scene.variant, "pass")
        return Record(id=scene.case.id, variant=scene.variant, title=scene.case.title, section="",
                      lesson="", formula="", file=scene.case.file, status=status,
                      message="no red light" if status == "unsupported" else "",
                      expectations=(BAD,) if status == "fail" else ())
    def close(self):
        print("lab closed")

shaderlab.engine.worker.SceneRunner = Lab
"""


@pytest.fixture
def cases(
    pytester: pytest.Pytester, case_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> pytest.Pytester:
    """A pytester whose folder holds the case `lamp` and the stand-in lab."""
    monkeypatch.setenv("SHADERLAB_JOBS", "0")
    monkeypatch.setattr(
        shaderlab.engine.worker, "SceneRunner", shaderlab.engine.worker.SceneRunner
    )  # as it is after
    for file in case_folder.iterdir():
        (pytester.path / file.name).write_text(file.read_text())
    pytester.makeconftest(STAND_IN)
    return pytester


def test_each_variant_is_an_item(cases: pytest.Pytester) -> None:
    result = cases.runpytest_inprocess("--collect-only", "-q")
    result.stdout.fnmatch_lines(["lamp.py::lamp[[]near]", "lamp.py::lamp[[]far]"])
    assert result.ret == 0


def test_a_failure_shows_what_run_shows(cases: pytest.Pytester) -> None:
    result = cases.runpytest_inprocess()
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(
        [
            "*lamp[[]far]*A lamp",
            "*factor (formula)",
            "*4 of 9 values outside",
            "*worst pixel (3, 17): *",
            "*measured   0.5",
            "*distance = 2.5",
        ]
    )
    result.stdout.no_fnmatch_line("*Traceback*")
    result.stdout.no_fnmatch_line("*pytest_plugin.py*")


def test_selecting_and_stopping(cases: pytest.Pytester) -> None:
    cases.runpytest_inprocess("-k", "near").assert_outcomes(passed=1, deselected=1)
    (cases.path / "alamp.py").write_text((cases.path / "lamp.py").read_text())
    cases.runpytest_inprocess("-x").assert_outcomes(passed=1, failed=1)
    cases.runpytest_inprocess("lamp.py::lamp[far]").assert_outcomes(failed=1)


def test_one_lab_a_process_and_none_unless_needed(cases: pytest.Pytester) -> None:
    result = cases.runpytest_inprocess("-s")
    assert result.stdout.str().count("lab opened") == 1
    assert result.stdout.str().count("lab closed") == 1
    quiet = cases.runpytest_inprocess("-s", "--collect-only")
    assert "lab opened" not in quiet.stdout.str()


def test_unsupported_is_skipped_with_its_reason(cases: pytest.Pytester) -> None:
    file = cases.path / "lamp.py"
    file.write_text(file.read_text().replace('"far"', '"mars"'))
    result = cases.runpytest_inprocess("-rs")
    result.assert_outcomes(passed=1, skipped=1)
    result.stdout.fnmatch_lines(["*no red light*"])


def test_other_files_are_left_alone(cases: pytest.Pytester) -> None:
    cases.makepyfile(
        helper="raise SystemExit('a helper was imported')",
        broken_tool="def (:",
        test_own="def test_own(): pass",
    )
    cases.runpytest_inprocess("-k", "not far").assert_outcomes(passed=2, deselected=1)


def test_cases_called_tests_are_collected_and_what_is_no_case_is_named(
    cases: pytest.Pytester,
) -> None:
    """A case that has tests of its own is both; a file that takes `Case` in vain is a warning."""
    case = (cases.path / "lamp.py").read_text()
    (cases.path / "lamp.py").unlink()
    cases.makepyfile(
        test_lamp=case.replace("\ncase =", "\nfrom .helper import LAMP\ncase ="),
        helper="LAMP = 1",
        both_test=f"{case}\ndef test_own(): pass",
        many="from shaderlab import Case\ncases = []",
    )
    result = cases.runpytest_inprocess("-k", "not far")
    result.assert_outcomes(passed=3, deselected=2, warnings=1)
    result.stdout.fnmatch_lines(["*many.py takes Case but is no case: it assigns no `case`*"])


def test_a_wrong_case_file_is_one_message(cases: pytest.Pytester) -> None:
    file = cases.path / "lamp.py"
    file.write_text(file.read_text().replace("section=", "sektion="))
    result = cases.runpytest_inprocess()
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*lamp.py*sektion*"])
    result.stdout.no_fnmatch_line("*importlib*")


def test_a_case_is_really_drawn_and_judged(
    pytester: pytest.Pytester, case_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytester.runpytest_inprocess(case_folder).assert_outcomes(passed=2)
    monkeypatch.setenv("SHADERLAB_JOBS", "0")  # and without a worker as well
    shader = case_folder / "lamp.frag"
    shader.write_text(shader.read_text().replace("0.25", "0.26"))
    result = pytester.runpytest_inprocess(case_folder)
    result.assert_outcomes(failed=2)
    result.stdout.fnmatch_lines(["*FragColor (exact)"])


def test_a_case_given_by_its_file_is_not_imported_by_pytest(
    pytester: pytest.Pytester, case_folder: Path
) -> None:
    helper = "import sys\nassert '_pytest' not in sys.modules\n"
    (case_folder / "helper.py").write_text(helper)
    case = case_folder / "lamp.py"
    case.write_text(case.read_text().replace("\ncase =", "\nfrom . import helper\ncase ="))
    pytester.runpytest_inprocess(case).assert_outcomes(passed=2)


def broken(folder: Path, name: str, act: str, *, when: str = "draw") -> None:
    """A case like `lamp` that does `act` when it is drawn, or when it is imported."""
    if when == "draw":
        act = (
            "from shaderlab.drivers.opengl import drawing\nsubmit = drawing.submit\n"
            "def shot(vao, program, draw):\n"
            f"    if draw.draw.fragment == '{name}.frag': {act}\n"
            "    submit(vao, program, draw)\ndrawing.submit = shot"
        )
    text = (folder / "lamp.py").read_text().replace("lamp.frag", f"{name}.frag")
    (folder / f"{name}.py").write_text(
        text.replace("\ncase =", f"\nimport os, signal\n{act}\ncase =")
    )
    (folder / f"{name}.frag").write_text((folder / "lamp.frag").read_text())


def test_a_file_that_crashes_or_hangs_on_import_costs_only_itself(
    pytester: pytest.Pytester, case_folder: Path
) -> None:
    broken(case_folder, "dies", "os._exit(3)", when="import")
    broken(case_folder, "hangs", faulty.HANG, when="import")
    result = pytester.runpytest_inprocess(
        case_folder, "-o", "shaderlab_timeout=60", "--continue-on-collection-errors"
    )
    result.assert_outcomes(passed=2, errors=2)
    result.stdout.fnmatch_lines(
        ["*dies.py: importing the case file: *exit status 3*", "*hangs.py: *took longer than 60 s"]
    )


def test_a_limit_that_is_no_number_is_said(pytester: pytest.Pytester, case_folder: Path) -> None:
    for value in ("soon", "0", "-1", "nan", "inf"):
        result = pytester.runpytest_inprocess(case_folder, "-o", f"shaderlab_timeout={value}")
        assert result.ret != 0
        assert f"shaderlab_timeout is '{value}'" in result.stdout.str() + result.stderr.str()
