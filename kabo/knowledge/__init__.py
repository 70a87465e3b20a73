"""Knowledge: what the agent knows, as bits; queries, effects, sensing and grounding [K 3.3.1, PKS].

`ground(problem)` makes a `GroundedTask`: initial knowledge, ground actions, branchings and goal. A state is a Python
integer; there is no closed-world assumption. This room knows formula trees only: no geometry, no scene, no files.
"""

from kabo.knowledge.actions import Branching, GroundAction
from kabo.knowledge.completeness.gaps import Gap, Verdict, verdict_of
from kabo.knowledge.grounding.problem import ground
from kabo.knowledge.queries import GeometricOracle, Query, optimistic
from kabo.knowledge.reachability import Reach, relaxed_reach, unreachable_goals
from kabo.knowledge.task import GoalPart, GroundedTask

__all__ = [
    "Branching",
    "Gap",
    "GeometricOracle",
    "GoalPart",
    "GroundAction",
    "GroundedTask",
    "Query",
    "Reach",
    "Verdict",
    "ground",
    "optimistic",
    "relaxed_reach",
    "unreachable_goals",
    "verdict_of",
]
