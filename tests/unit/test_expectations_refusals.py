"""What must be refused: every word is compared, for compilers and for the lab itself."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

import pytest

from shaderlab import Case, compile_fails, fullscreen, gl_call, inactive_uniforms, refused
from shaderlab.engine.expectations.base import Context
from shaderlab.engine.expectations.rejections import Place, Verdicts
from shaderlab.errors import CaseError, Diagnostic, ShaderError, Verdict
from shaderlab.model.expectation import Expectation
from shaderlab.model.frame import Frame, Reply
from shaderlab.model.records import Outcome

UNDECLARED = "'x' : undeclared identifier"
DRIVER = Verdict(
    target="driver",
    ok=False,
    diagnostics=(Diagnostic(file="a.frag", line=3, severity="error", message="no x"),),
)
LENIENT = Verdict(target="driver", ok=True)


def outcome(check: Expectation, answer: Any, vendor: str = "") -> Outcome:
    """The outcome of an expectation that asks one thing, and gets this answer."""
    case = Case(title="T", passes=fullscreen("a.frag"), expect=[check])
    scene = next(case.scenes())
    (need,) = check.needs(scene, {})
    frame = Frame(images={}, order=("main",), bindings={}, answers={need: answer}, vendor=vendor)
    return check.judge(scene, frame).outcome


def answer(*errors: tuple[str, int | None, str], **more: Any) -> Verdicts:
    return Verdicts(errors=errors, accepted=not errors, stages={"a.frag": "fragment"}, **more)


@pytest.mark.parametrize(
    "said",
    [
        answer(),
        answer(("a.frag", 4, UNDECLARED)),
        answer(("b.frag", 3, UNDECLARED)),
        answer(("a.frag", 3, UNDECLARED + "s")),
        answer(("a.frag", 3, UNDECLARED), ("a.frag", 5, UNDECLARED)),
        answer(("a.frag", 3, UNDECLARED), driver=LENIENT),
    ],
)
def test_another_answer_of_the_compiler_fails(said: Verdicts) -> None:
    check = compile_fails("a.frag", (3, UNDECLARED))
    right = outcome(check, answer(("a.frag", 3, UNDECLARED), driver=DRIVER))
    assert right.status == "pass"
    assert right.rows[0].label == "fragment a.frag:3"
    assert right.rows[1].expected == "rejected, in its own words"
    assert outcome(check, said).status == "fail"


def test_a_driver_may_be_let_off() -> None:
    said = answer(("a.frag", 3, UNDECLARED), driver=LENIENT)
    lenient = compile_fails("a.frag", (3, UNDECLARED), driver=False)
    assert outcome(lenient, said).status == "pass"


@pytest.mark.parametrize(
    ("vendor", "said", "status"),
    [
        ("NVIDIA Corporation", LENIENT, "pass"),
        ("NVIDIA Corporation", DRIVER, "pass"),
        ("Mesa", LENIENT, "fail"),
        ("", LENIENT, "fail"),
    ],
)
def test_a_driver_that_is_known_to_accept_it_passes_with_a_message(
    vendor: str, said: Verdict, status: str
) -> None:
    check = compile_fails("a.frag", (3, UNDECLARED), departs={"NVIDIA": "accepted"})
    judged = outcome(check, answer(("a.frag", 3, UNDECLARED), driver=said), vendor)
    assert judged.status == status
    known = status == "pass" and said is LENIENT
    assert ("a known departure of NVIDIA's driver" in judged.message) is known
    assert "accepts a.frag" in judged.message or said is DRIVER
    other = outcome(check, answer(("a.frag", 4, UNDECLARED), driver=said), vendor)
    assert other.status == "fail", "glslang's own verdict is no departure of the driver's"


@pytest.mark.parametrize(
    ("vendor", "raised", "status"),
    [
        ("NVIDIA Corporation", 0x502, "pass"),
        ("NVIDIA Corporation", 0, "fail"),
        ("NVIDIA Corporation", 0x501, "fail"),
        ("Mesa", 0x502, "fail"),
        ("Mesa", 0x500, "pass"),
    ],
)
def test_only_the_error_that_a_driver_is_known_for_passes(
    vendor: str, raised: int, status: str
) -> None:
    check = gl_call(
        "glEnable", "GL_FOG", raises="invalid_enum", departs={"NVIDIA": "GL_INVALID_OPERATION"}
    )
    reply = Reply(errors=(raised,) if raised else (), at=str(check.call))
    judged = outcome(check, reply, vendor)
    assert judged.status == status
    assert ("known departure" in judged.message) is (status == "pass" and raised != 0x500)


def test_messages_of_a_program_say_which_file() -> None:
    program = compile_fails(("a.vert", "a.frag"), ("a.frag", None, "no main"))
    assert program.shaders == ("a.vert", "a.frag")
    for wrong in ((3, "no main"), ("c.frag", 3, "no main")):
        with pytest.raises(CaseError, match=r"write \(file, line, text\)"):
            compile_fails(("a.vert", "a.frag"), wrong)


ERROR = ShaderError("the shader is empty", file="a.frag", line=2, remedy="fill it")


@pytest.mark.parametrize(
    "change", [{"message": "is empty"}, {"file": "b.frag"}, {"line": 3}, {"remedy": "delete it"}]
)
def test_every_part_of_the_lab_s_own_error_counts(change: dict[str, Any]) -> None:
    whole: dict[str, Any] = {"message": "the shader is empty", "line": 2, "remedy": "fill it"}
    assert outcome(refused("a.frag", **whole), ERROR).status == "pass"
    assert outcome(refused("a.frag", **(whole | change)), ERROR).status == "fail"
    taken = outcome(refused("a.frag", **whole), None)
    assert (taken.status, taken.message) == ("fail", "the lab accepts it, but should reject it")


def test_only_a_name_or_a_function_can_be_refused() -> None:
    with pytest.raises(CaseError, match="what is 3; expected str or function"):
        refused(3, message="no")  # type: ignore[arg-type]


@pytest.mark.parametrize("locations", [{"used": 0, "idle": 1}, {"used": -1, "idle": -1}])
def test_exactly_these_uniforms_must_be_inactive(locations: dict[str, int]) -> None:
    check = inactive_uniforms("idle")
    assert outcome(check, {"used": 0, "idle": -1}).status == "pass"
    assert outcome(check, locations).status == "fail"
    with pytest.raises(CaseError, match="did you mean idle"):
        outcome(inactive_uniforms("idel"), locations)


def test_folders_are_left_out_of_paths() -> None:
    case = Case(title="T", passes=fullscreen("a.frag"), expect=[refused("a.frag", message="no")])
    scene = next(replace(case, file="/lab/case.py").scenes())
    session: Any = SimpleNamespace(scene=scene)
    preparer: Any = SimpleNamespace(folders=(Path("/lab/shaders"),))
    context = Context(session, {}, preparer, lambda sources: DRIVER)
    said = "/lab/shaders/a.frag:3 includes /lab/b.glsl, not in /lab/shaders"
    assert context.shorten_paths(said) == "a.frag:3 includes b.glsl, not in shaders"


@pytest.mark.parametrize(
    ("places", "status"),
    [
        ((("a.frag", 3, "no x"), ("a.frag", 9, "more")), "pass"),
        ((("a.frag", 4, "no x"),), "fail"),
        ((("b.frag", 3, "no x"),), "fail"),
        ((), "fail"),
    ],
)
def test_the_place_that_the_driver_names(places: tuple[Place, ...], status: str) -> None:
    check = compile_fails("a.frag", (3, UNDECLARED), driver=("a.frag", 3))
    said = answer(("a.frag", 3, UNDECLARED), driver=DRIVER, driver_errors=places)
    found = outcome(check, said)
    assert found.status == status
    assert found.rows[1].expected == "rejected at a.frag:3"
    assert status == "pass" or "another line" in found.message


@pytest.mark.parametrize("file", ["cases/a.py", "{here}/cases/a.py"])
def test_a_case_s_folder_is_left_out_however_the_case_was_named(
    file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    here = tmp_path.resolve()
    case = SimpleNamespace(file=file.format(here=here))
    session: Any = SimpleNamespace(scene=SimpleNamespace(case=case))
    preparer: Any = SimpleNamespace(folders=(here / "shaders",))
    context = Context(session, {}, preparer, Mock())
    assert (
        context.shorten_paths(f"{here}/cases/b.obj:8, {here}/shaders/c.glsl") == "b.obj:8, c.glsl"
    )


def test_the_working_directory_as_a_folder_takes_no_dots(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    session: Any = SimpleNamespace(scene=SimpleNamespace(case=SimpleNamespace(file="a.py")))
    preparer: Any = SimpleNamespace(folders=())
    context = Context(session, {}, preparer, Mock())
    assert context.shorten_paths(f"{tmp_path.resolve()}/b.obj: 1.5") == "b.obj: 1.5"
