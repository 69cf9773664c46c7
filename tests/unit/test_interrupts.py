"""An interrupt ends the command line with a word, whatever it does at that time."""

from __future__ import annotations

import _imp
import gc
import os
import pty
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import pytest

from shaderlab import __main__ as program, cli


@pytest.fixture(autouse=True)
def interruptible(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Interrupts are raised here, and what the program sets for its process is put back."""
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)
    before = {number: signal.signal(number, signal.SIG_DFL) for number in program._ENDING}
    signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    gc.enable()
    for number, handler in before.items():
        signal.signal(number, handler)


_command_line = cli.main


def _interrupted() -> None:
    raise KeyboardInterrupt


def _interrupted_in_a_class() -> None:
    class Part:
        def __set_name__(self, *_: object) -> None:
            raise KeyboardInterrupt

    type("Whole", (), {"part": Part()})


def _interrupted_before_the_command() -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cli.Commands, "parse_args", lambda *_: _interrupted())
        _command_line()


@pytest.mark.parametrize(
    "interrupted", [_interrupted, _interrupted_in_a_class, _interrupted_before_the_command]
)
def test_an_interrupt_while_modules_are_imported_is_said(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    interrupted: Callable[[], None],
) -> None:
    monkeypatch.setattr(cli, "main", interrupted)
    with pytest.raises(SystemExit) as ended:
        program.main()
    assert ended.value.code == cli.INTERRUPTED
    assert capsys.readouterr().err.strip() == "shaderlab: interrupted"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("status", [cli.INTERRUPTED, cli.OK, None])
def test_other_signals_end_it_as_an_interrupt_does(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    number: signal.Signals,
    status: int | None,
) -> None:
    """Also where the command ends as if all were well, as a watch does, or notices nothing."""

    def told() -> None:
        try:
            signal.raise_signal(number)
            time.sleep(20)
        except KeyboardInterrupt:
            if status is None:
                raise
            sys.exit(status)

    monkeypatch.setattr(cli, "main", told)
    with pytest.raises(SystemExit) as ended:
        program.main()
    assert ended.value.code == 128 + number
    said = "" if status else "\nshaderlab: interrupted\n"  # by the command itself
    assert capsys.readouterr().err == said


def test_what_is_printed_after_the_terminal_is_gone_is_no_error() -> None:
    """It would come before the report of a run that was ended by SIGHUP."""
    outer, inner = pty.openpty()
    kept = os.dup(1)
    try:
        os.dup2(inner, 1)
        os.close(inner)
        os.close(outer)  # hangs up
        with pytest.raises(OSError):
            os.write(1, b"x")
        program._leave_terminal()
        os.write(1, b"x")
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def test_interrupts_in_a_burst_are_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also those that come while what was begun is ended, and while the process ends."""

    def interrupted() -> None:
        try:
            signal.raise_signal(signal.SIGINT)
            time.sleep(20)  # until the first one
        finally:
            for _ in range(4):
                signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(cli, "main", interrupted)
    with pytest.raises(SystemExit) as ended:
        program.main()
    signal.raise_signal(signal.SIGINT)
    assert ended.value.code == cli.INTERRUPTED
    assert capsys.readouterr().err == "\nshaderlab: interrupted\n"


def test_an_interrupt_after_a_while_ends_what_an_earlier_one_did_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def interrupted_twice() -> None:
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
            time.sleep(20)
        monkeypatch.setattr(program, "REPEAT_SECONDS", 0.0)
        signal.raise_signal(signal.SIGINT)
        time.sleep(20)

    monkeypatch.setattr(cli, "main", interrupted_twice)
    with pytest.raises(SystemExit) as ended:
        program.main()
    assert ended.value.code == cli.INTERRUPTED


def test_the_package_is_imported_without_reading_its_stub() -> None:
    """Before the program starts, nothing says how an interrupt ends it: that time is Python's."""
    code = (
        "import sys, shaderlab.__main__; print(sorted({'ast', 'lazy_loader'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-S", "-c", code], capture_output=True, text=True,
                          env={"PYTHONPATH": os.pathsep.join(filter(None, sys.path))})  # fmt: skip
    assert done.stdout.strip() == "[]", done.stderr


def test_what_ignores_interrupts_goes_on_doing_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cli, "main", lambda: None)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # as a shell has it for what runs behind
    program.main()
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN


def test_an_interrupt_in_a_callback_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cli, "main", lambda: None)
    program.main()
    signal.signal(signal.SIGINT, signal.default_int_handler)

    class Callback:
        def __del__(self) -> None:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        Callback()
        time.sleep(20)


def test_an_interrupt_leaves_no_lock_of_imports_held(monkeypatch: pytest.MonkeyPatch) -> None:
    """A thread that imports something would wait for it forever."""

    def importing() -> None:
        _imp.acquire_lock()
        try:
            signal.raise_signal(signal.SIGINT)  # as between taking the lock and Python's `try`
        except KeyboardInterrupt:
            pytest.fail("raised while the lock is held")
        _imp.release_lock()
        time.sleep(20)

    monkeypatch.setattr(cli, "main", importing)
    began = time.monotonic()
    with pytest.raises(SystemExit) as ended:
        program.main()
    assert ended.value.code == cli.INTERRUPTED and time.monotonic() - began < 10


def test_other_errors_in_callbacks_are_printed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cli, "main", lambda: None)
    program.main()

    class Callback:
        def __del__(self) -> None:
            raise ValueError("so it is")

    Callback()
    assert "ValueError: so it is" in capsys.readouterr().err
