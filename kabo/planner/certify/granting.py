"""Adds to every segment of a plan the reasons for its contacts: names of grasp families, supports and mates.

It uses only the plan as it will be written, as the verifier does. Each grant is a claim: the verifier checks with
the scene whether the named family or mate really allows the contact of these bodies at this place.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from kabo.geometry_server import HOLD_TOLERANCE, Frame, family_of_hold, fits, rows, standing_frame, tool_frame
from kabo.kinematics import satisfied
from kabo.language.scene_description import Constraint
from kabo.plan import Grant, Node, Plan, Segment, topological_order
from kabo.planner.certify.component_values import ComponentValues
from kabo.planner.certify.motion_situation import MotionSituation
from kabo.planner.certify.motion_stretches import stretches
from kabo.scene import Scene

Frames = dict[str, Frame]


def granted(plan: Plan, scene: Scene) -> Plan:
    """The plan, with a grant (the reason why it is allowed) for each contact of its segments.

    Args:
        plan: the plan as it will be written, still without grants.
        scene: the scene of the plan.

    Raises:
        ValueError: the plan moves something that may be in several places.
    """
    order = topological_order(plan)
    if order is None or plan.start is None:
        return plan
    values = ComponentValues(plan, scene, order)
    nodes = dict(plan.nodes)
    for name in order:
        if any(segment.allowed_contacts for segment in nodes[name].motion):
            nodes[name] = _Granting(name, nodes[name], scene, values).made()
    return replace(plan, nodes=nodes)


@dataclass
class _Granting:
    """Adds grants to the segments of one node, in the order of time, tracking what is held."""

    name: str
    node: Node
    scene: Scene
    values: ComponentValues
    families: dict[tuple[str, str], str | None] = field(default_factory=dict)  # (robot, object) -> as last held

    def made(self) -> Node:
        """The node with the grants of its segments."""
        motion = self.node.motion
        moving = list(dict.fromkeys(segment.robot for segment in motion))
        situation = MotionSituation.at(self.name, self.values, self.scene, moving)
        begun: dict[int, dict[str, tuple[str, str | None]]] = {}
        mates: dict[frozenset[str], str | None] = {}
        for stretch in stretches(motion, dict(self.scene.robots), situation.q):
            for i in stretch.segments:
                if i not in begun:
                    begun[i] = self._held(situation)
            for i in stretch.ending:
                for pair in motion[i].attach:
                    if "." not in pair[1]:
                        mates[frozenset(pair)] = self._mate(situation, *pair)
                    self.families.pop((pair[1].partition(".")[0], pair[0]), None)  # taken anew
                situation.end(motion[i])
                self._held(situation)
        segments = [replace(s, grants=self._grants(s, begun[i], mates)) for i, s in enumerate(motion)]
        return replace(self.node, motion=tuple(segments))

    def _held(self, situation: MotionSituation) -> dict[str, tuple[str, str | None]]:
        """What is held: object -> robot and family."""
        found: dict[str, tuple[str, str | None]] = {}
        for name in situation.hung:
            root = situation.root(name)
            robot, dot, _ = situation.hung[root][0].partition(".")
            if dot and robot in {segment.robot for segment in self.node.motion}:
                if (robot, root) not in self.families:
                    self.families[robot, root] = self._family(situation, robot, root)
                found[name] = robot, self.families[robot, root]
        return found

    def _family(self, situation: MotionSituation, robot: str, name: str) -> str | None:
        """The grasp family that declares how a robot holds an object now, or None."""
        chosen, body = self.scene.robots[robot], self.scene.bodies[name]
        roles = {"this": standing_frame(body, situation.pose(name))}
        if chosen.tool is None:
            return None
        roles["tool"] = tool_frame(chosen)
        family = family_of_hold(chosen, body, roles, np.asarray(situation.q[robot]))
        return None if family is None else family.name

    def _holds(
        self, constraints: Sequence[Constraint], roles: Frames, situation: MotionSituation, robot: str
    ) -> bool:
        if not fits(constraints, roles):
            return False
        wanted = rows(constraints, roles)
        tree = self.scene.robots[robot].tree
        return bool(satisfied(wanted, np.asarray(situation.q[robot]), tree, HOLD_TOLERANCE))

    def _mate(self, situation: MotionSituation, name: str, to: str) -> str | None:
        """The mate as which two bodies are put together; the first that holds, or that their models have."""
        found = []
        for mate, moving, fixed in self.scene.mates_between(name, to):
            frames = {
                "moving": standing_frame(self.scene.bodies[moving], situation.pose(moving)),
                "fixed": standing_frame(self.scene.bodies[fixed], situation.pose(fixed)),
            }
            robot = next(iter(situation.q))
            found.append((not self._holds(mate.constraints, frames, situation, robot), mate.name))
        return min(found)[1] if found else None

    def _grants(
        self,
        segment: Segment,
        held: Mapping[str, tuple[str, str | None]],
        mates: Mapping[frozenset[str], str | None],
    ) -> tuple[Grant, ...]:
        """What grants the contacts of a segment; those that the scene permits anyway need nothing."""
        found: list[Grant] = []
        for pair in segment.allowed_contacts:
            first, second = sorted(pair, key=lambda name: "." not in name)
            if "." in first:
                robot = first.partition(".")[0]
                if (robot, second) in self.families:
                    found.append(Grant("grasp", (first, second), self.families[robot, second]))
            elif frozenset(pair) in mates:
                found.append(self._mated(pair, mates[frozenset(pair)]))
            else:
                carried = [name for name in pair if name in held and held[name][0] == segment.robot]
                if len(carried) == 1:
                    other = pair[1] if pair[0] == carried[0] else pair[0]
                    found.append(Grant("support", (carried[0], other), held[carried[0]][1]))
        return tuple(found)

    def _mated(self, pair: tuple[str, str], mate: str | None) -> Grant:
        roles = ((moving, fixed) for each, moving, fixed in self.scene.mates_between(*pair) if each.name == mate)
        return Grant("mate", next(roles, (pair[0], pair[1])), mate)
