"""Mutation: realistic mistakes made on purpose, to measure what a case's expectations notice."""

from shaderlab.mutation.campaign import Options, Watch, mutants_of_case, run
from shaderlab.mutation.mutants import Mutant, mutants_of
from shaderlab.mutation.results import CaseResult, Fate, Tried, as_json, score, summary_rows
from shaderlab.mutation.states import StateMutant, state_mutants

__all__ = [
    "CaseResult",
    "Fate",
    "Mutant",
    "Options",
    "StateMutant",
    "Tried",
    "Watch",
    "as_json",
    "mutants_of",
    "mutants_of_case",
    "run",
    "score",
    "state_mutants",
    "summary_rows",
]
