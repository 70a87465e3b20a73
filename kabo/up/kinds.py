"""What kabo plans for among the kinds of problems of unified-planning, and why not for the others.

unified-planning names the features of a problem (`problem.kind`); an engine says which of them it supports.
"""

from unified_planning.model import ProblemKind
from unified_planning.model.problem_kind import FEATURES
from unified_planning.model.problem_kind_versioning import LATEST_PROBLEM_KIND_VERSION

SUPPORTED = (
    ("ACTION_BASED", "CONTINGENT")
    + ("FLAT_TYPING", "HIERARCHICAL_TYPING")
    + ("NEGATIVE_CONDITIONS", "DISJUNCTIVE_CONDITIONS", "EQUALITIES")
    + ("EXISTENTIAL_CONDITIONS", "UNIVERSAL_CONDITIONS")
    + ("CONDITIONAL_EFFECTS", "FORALL_EFFECTS", "INCREASE_EFFECTS", "DECREASE_EFFECTS")
    + ("STATIC_FLUENTS_IN_BOOLEAN_ASSIGNMENTS", "FLUENTS_IN_BOOLEAN_ASSIGNMENTS")
    + ("STATIC_FLUENTS_IN_NUMERIC_ASSIGNMENTS", "FLUENTS_IN_NUMERIC_ASSIGNMENTS")
    + ("STATIC_FLUENTS_IN_OBJECT_ASSIGNMENTS", "FLUENTS_IN_OBJECT_ASSIGNMENTS")
    + ("OBJECT_FLUENTS", "INT_FLUENTS", "REAL_FLUENTS", "BOUNDED_TYPES")
    + ("SIMPLE_NUMERIC_PLANNING", "GENERAL_NUMERIC_PLANNING")
    + ("STATE_INVARIANTS", "PLAN_LENGTH", "ACTIONS_COST", "STATIC_FLUENTS_IN_ACTIONS_COST")
    + ("INT_NUMBERS_IN_ACTIONS_COST", "REAL_NUMBERS_IN_ACTIONS_COST")
)

_TIME = "kabo's actions have no times, and nothing changes by itself"
_NOT_OBJECTS = "parameters are objects in kabo"
_REASONS = {
    "HIERARCHICAL": "kabo does not decompose tasks by methods",
    "ACTION_BASED_MULTI_AGENT": "kabo plans for one agent, who may have several robots",
    "TAMP": "kabo takes geometry from its own scenes",
    "SIMULATED_ENTITIES": "kabo must know what an action does, and cannot look into a function",
    "MULTI_AGENT": "kabo plans for one agent, who may have several robots",
    "TRAJECTORY_CONSTRAINTS": "of constraints on the whole plan, kabo knows only `Always`",
    "FINAL_VALUE": "costs are those of actions",
    "OVERSUBSCRIPTION": "kabo reaches all goals, or says that it cannot",
    "OVERSUBSCRIPTION_KIND": "kabo reaches all goals, or says that it cannot",
    "FLUENTS_IN_ACTIONS_COST": "what an action costs must not depend on the state",
    "INITIAL_STATE": "every fluent must be given at the start, or hidden (ContingentProblem)",
    "PARAMETERS": _NOT_OBJECTS,
}


def supported_kind() -> ProblemKind:
    """The features that kabo supports."""
    return ProblemKind(SUPPORTED, version=LATEST_PROBLEM_KIND_VERSION)


def refusals(kind: ProblemKind) -> list[str]:
    """A sentence for each reason why kabo does not support a problem, with the features that it is about."""
    found: dict[str, list[str]] = {}
    for feature in sorted(kind.features):
        if not ProblemKind([feature]) <= supported_kind():
            found.setdefault(_reason(feature), []).append(feature)
    return [f"{reason} ({', '.join(features)})" for reason, features in found.items()]


def _reason(feature: str) -> str:
    """Why kabo does not support a feature: by its own name, else by that of its kind."""
    group = next((group for group, features in FEATURES.items() if feature in features), "")
    return _REASONS.get(feature) or _REASONS.get(group) or _TIME
