"""Mutation: realistic mistakes made on purpose, to measure what a case's expectations notice."""

from shaderlab.mutation.api_mutants import ApiMutant as ApiMutant, api_mutants as api_mutants
from shaderlab.mutation.campaign import (
    Campaign as Campaign,
    CaseSubject as CaseSubject,
    Subject as Subject,
)
from shaderlab.mutation.mutants import (
    Mutant as Mutant,
    ShaderMutant as ShaderMutant,
    mutants_of as mutants_of,
)
from shaderlab.mutation.requests import (
    MutationPlan as MutationPlan,
    chosen as chosen,
    mutants_of_case as mutants_of_case,
)
from shaderlab.mutation.results import (
    CaseResult as CaseResult,
    Fate as Fate,
    Tried as Tried,
    as_json as as_json,
    score as score,
)
from shaderlab.mutation.states import StateMutant as StateMutant, state_mutants as state_mutants
from shaderlab.mutation.subjects import glsl_mutants as glsl_mutants
