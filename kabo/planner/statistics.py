"""The figures of a run, typed, as `Result.statistics` has them (docs/reference/plans.md#the-result)."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, TypedDict, cast

from kabo.plan import Plan, plan_statistics


class ProcedureFigures(TypedDict):
    """How often a procedure was called, and how often it failed, by reason."""

    calls: int
    failures: dict[str, int]


class _Always(TypedDict):
    """What every result has."""

    total_s: float  # everything [s]
    load_s: float  # loading compiled code [s]
    symbolic_s: float  # grounding and search [s]
    geometric_s: float  # geometry [s]
    collision_s: float  # collision checks, a part of geometry [s]
    inverse_kinematics_s: float  # samples, a part of geometry [s]
    expanded: int  # states of knowledge
    generated: int  # states of knowledge
    geometric_states: int
    inverse_kinematics_calls: int  # samples that were drawn and projected onto constraints
    collision_checks: int
    positive_collision_checks: int  # checks that said "collision"
    pair_checks: int  # pairs of bodies that were looked at closely
    procedures: dict[str, ProcedureFigures]
    plan_actions: int | None  # action and sense nodes on the longest branch; these four are None without a plan
    plan_nodes: int | None
    plan_leaves: int | None  # branches from root to goal, without unfolding
    waypoints: int | None


class Statistics(_Always, total=False):
    """The figures of a run by name; those of refining and of the certificate only where these were made."""

    path_length_found: float  # of the motion as it was found [rad or m]
    path_length: float  # of the refined motion [rad or m]
    duration_found: float  # of the longest branch as it was found [s]
    duration: float  # of the longest branch [s]
    overlap: float  # by which motions begin early [s]
    refine_s: float  # refining [s]
    certificate_s: float  # the certificate [s]
    certificate_gaps: list[str]  # the motions that the certificate cannot prove


# A figure that nobody counted is zero.
COUNTS = (
    "collision_checks",
    "expanded",
    "generated",
    "geometric_states",
    "inverse_kinematics_calls",
    "pair_checks",
    "positive_collision_checks",
)
SECONDS = ("collision_s", "geometric_s", "inverse_kinematics_s", "load_s", "symbolic_s", "total_s")
PLAN_FIGURES = ("plan_actions", "plan_leaves", "plan_nodes", "waypoints")
REFINED = ("path_length_found", "path_length", "duration_found", "duration", "overlap", "refine_s")
PYTHON_ONLY = ("inverse_kinematics_s",)  # not in the JSON of a result


def completed(figures: Mapping[str, Any], plan: Plan | None = None) -> Statistics:
    """The figures with those of the plan, and zero for what nobody counted."""
    counted: dict[str, Any] = dict(figures)
    counted |= {name: int(figures.get(name, 0)) for name in COUNTS}
    counted |= {name: float(figures.get(name, 0.0)) for name in SECONDS}
    counted |= {"procedures": dict(figures.get("procedures", {}))}
    counted |= dict.fromkeys(PLAN_FIGURES) if plan is None else asdict(plan_statistics(plan))
    return cast(Statistics, counted)
