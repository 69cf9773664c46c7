"""Mutation: realistic mistakes made on purpose, to measure what a case's expectations notice."""

from shaderlab.mutation.campaign import Campaign
from shaderlab.mutation.mutants import Mutant, mutants_of
from shaderlab.mutation.requests import MutationPlan, mutants_of_case
from shaderlab.mutation.results import CaseResult, Fate, Tried, as_json, score, summary_rows
from shaderlab.mutation.states import StateMutant, state_mutants

__all__ = [
    "Campaign",
    "CaseResult",
    "Fate",
    "Mutant",
    "MutationPlan",
    "StateMutant",
    "Tried",
    "as_json",
    "mutants_of",
    "mutants_of_case",
    "score",
    "state_mutants",
    "summary_rows",
]
