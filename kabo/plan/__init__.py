"""The plan room: a plan as data, its canonical file, its statistics, and its views as policy, as tree and as text.

It depends only on the format `kabo-plan/2` (docs/reference/plans.md): not on how a plan was made, nor on whether it is
valid. Searches build plans with `PlanBuilder`, which merges nodes with equal content and continuation.
"""

from kabo.plan.branches import Step, branch_of
from kabo.plan.builder import PlanBuilder
from kabo.plan.certificate import BodyParts, Certificate, Clearance, PairProof, ProvenGap, StretchProof
from kabo.plan.description import describe, described_validity
from kabo.plan.graphviz import plan_to_dot
from kabo.plan.plan import (
    Done,
    Grant,
    Learned,
    Node,
    ObjectPose,
    Plan,
    Segment,
    StateChange,
    ValueOf,
)
from kabo.plan.policies import Decision, Observation, Policy, policy
from kabo.plan.reading import load_plan, plan_from_json
from kabo.plan.schema import schema
from kabo.plan.state import History, State, load_state, state_after
from kabo.plan.statistics import PlanStatistics, plan_statistics, topological_order
from kabo.plan.trajectory_json import trajectory_from_json, trajectory_to_json
from kabo.plan.unfolding import unfold
from kabo.plan.writing import (
    READABLE_FORMATS,
    learned_json,
    node_to_json,
    plan_hash,
    plan_to_json,
    write_plan,
)

__all__ = [
    "READABLE_FORMATS",
    "BodyParts",
    "Certificate",
    "Clearance",
    "Decision",
    "Done",
    "Grant",
    "History",
    "Learned",
    "Node",
    "ObjectPose",
    "Observation",
    "PairProof",
    "ProvenGap",
    "Plan",
    "PlanBuilder",
    "PlanStatistics",
    "Policy",
    "Segment",
    "State",
    "StateChange",
    "Step",
    "StretchProof",
    "ValueOf",
    "branch_of",
    "describe",
    "described_validity",
    "learned_json",
    "load_plan",
    "load_state",
    "node_to_json",
    "plan_from_json",
    "plan_hash",
    "plan_statistics",
    "plan_to_dot",
    "plan_to_json",
    "policy",
    "schema",
    "state_after",
    "topological_order",
    "trajectory_from_json",
    "trajectory_to_json",
    "unfold",
    "write_plan",
]
