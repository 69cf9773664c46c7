"""The process that judges mutants: questions on standard input, answers on standard output.

A mutant may loop for ever or take the driver down, so it never runs in the process that asks.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from shaderlab.catalogue import load_case
from shaderlab.errors import ShaderlabError
from shaderlab.evaluation import Lab
from shaderlab.mutation.judging import Judge
from shaderlab.mutation.mutants import Mutant
from shaderlab.mutation.results import Fate
from shaderlab.mutation.states import StateMutant


@dataclass(frozen=True, kw_only=True)
class Opening:
    """Load a case, run it as it is, and keep it for the mutants to come."""

    case_file: str
    variants: tuple[str, ...] = ()


Question = Opening | Mutant | StateMutant
Answer = Fate | str
"""A mutant's fate (or "" for an opening), or what is wrong with the case."""


def answers(questions: BinaryIO, replies: BinaryIO) -> None:
    """Answer one question after the other until there are no more."""
    with contextlib.ExitStack() as stack:
        lab: Lab | None = None
        judge: Judge | None = None
        while True:
            try:
                question: Question = pickle.load(questions)
            except EOFError:
                return
            answer: Answer
            try:
                if isinstance(question, Opening):
                    lab = lab or stack.enter_context(Lab())
                    judge = Judge(lab, load_case(Path(question.case_file)), question.variants)
                    answer = ""
                else:
                    assert judge is not None
                    answer = judge.fate(question)
            except ShaderlabError as error:
                answer = str(error)
            except Exception as error:
                answer = f"unforeseen {type(error).__name__}: {error}"
            pickle.dump(answer, replies)
            replies.flush()


def main() -> None:
    """Be such a process."""
    replies = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever a case or a driver prints must not get between the answers
    answers(sys.stdin.buffer, replies)
