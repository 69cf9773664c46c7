"""Errors: what they show, and that they survive the way between processes."""

from __future__ import annotations

import pickle

from shaderlab.errors import CaseError, ShaderlabError, suggest


def test_an_error_shows_place_message_and_remedy() -> None:
    error = CaseError("no such thing", file="a/b.py", line=7, remedy="write it")
    assert str(error) == "a/b.py:7: no such thing\n  → write it"
    assert isinstance(error, ShaderlabError)


def test_an_error_keeps_everything_when_it_is_pickled() -> None:
    error = CaseError("no such thing", file="a.py", line=7, remedy="write it")
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is CaseError
    assert (copy.message, copy.file, copy.line, copy.remedy) == (
        error.message,
        error.file,
        error.line,
        error.remedy,
    )


def test_notes_survive_pickling() -> None:
    error = CaseError("no such thing", file="a.py")
    error.add_note("where it was raised")
    assert pickle.loads(pickle.dumps(error)).__notes__ == ["where it was raised"]


def test_nearest_names_close_words_first_and_all_of_few() -> None:
    assert suggest("texture", ["textures", "state"]) == "did you mean textures?"
    assert suggest("zzz", ["textures", "state"]) == "there is: textures, state"
    assert suggest("zzz", []) == "there are none to choose from"
