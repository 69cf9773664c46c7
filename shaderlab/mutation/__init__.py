"""Mutation: realistic mistakes made on purpose, to measure what a case's expectations notice."""

from shaderlab.mutation.campaign import (
    CaseTarget as CaseTarget,
    MutationPlan as MutationPlan,
    MutationRun as MutationRun,
    MutationTarget as MutationTarget,
    make_mutants as make_mutants,
)
from shaderlab.mutation.mutants import (
    CaseResult as CaseResult,
    MutantResult as MutantResult,
    MutantRun as MutantRun,
    results_to_json as results_to_json,
    score as score,
)
from shaderlab.mutation.shader_mutants import (
    ShaderMutant as ShaderMutant,
    mutate_case as mutate_case,
)
