"""Teams: constraints over several robots and free bodies, with one joint vector [K Eq. 5.1].

Frames have names: `world`, `left.tool`, `left.<link>`, a body or a region. Objects attached to a robot of the
team, directly or through other bodies, move with it; everything else stands still.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from kabo.arrays import Array
from kabo.geometry_server.candidates import BATCH_SAMPLES, closed_form_of
from kabo.geometry_server.configurations import Candidate, joints_at
from kabo.geometry_server.frames import WORLD, Frame, Roles, has, rows, tool_frame
from kabo.kinematics import FREE_BODY, ClosedArm, JoinedTree, drawn_together, joined, sample
from kabo.language.scene_description import Constraint, Feature
from kabo.scene import Configuration, GeometricState, KinematicTree, Robot, Scene, world_T
from kabo.scene.transforms import transform, unflat
from kabo.streams import Key


@dataclass(frozen=True)
class Team:
    """Robots of a scene that share constraints, and `free` bodies that may be anywhere.

    A configuration of the team holds each robot's configuration, in their order, then six values for each free
    body.
    """

    scene: Scene
    robots: tuple[Robot, ...]
    free: tuple[str, ...] = ()

    @classmethod
    def of(cls, scene: Scene, robots: Iterable[str], free: Iterable[str] = ()) -> "Team":
        """The team of robots by name.

        Raises:
            ValueError: the scene has no such robot or body, a name is repeated, or no robot is named.
        """
        names, bodies = tuple(robots), tuple(free)
        for name, known in (*((n, scene.robots) for n in names), *((n, scene.bodies) for n in bodies)):
            if name not in known:
                raise ValueError(f"the scene has no {name!r}; it has {', '.join(known) or 'none'}")
        if len({*names, *bodies}) < len(names) + len(bodies) or not names + bodies:
            raise ValueError("a team has at least one member, each once")
        return cls(scene, tuple(scene.robots[name] for name in names), bodies)

    @cached_property
    def joined(self) -> JoinedTree:
        """The trees of all members as one."""
        return joined([*(robot.tree for robot in self.robots), *(FREE_BODY for _ in self.free)])

    @property
    def tree(self) -> KinematicTree:
        """The joined tree, which constraints of the team refer to."""
        return self.joined.tree

    @cached_property
    def members(self) -> tuple[str, ...]:
        """The names of robots and free bodies, in the order of the configuration."""
        return (*(robot.name for robot in self.robots), *self.free)

    @cached_property
    def moving(self) -> npt.NDArray[np.bool_]:
        """The mask (n,) of the values of a configuration that may change: all but the grippers'."""
        parts = [np.arange(robot.tree.size) < robot.planned for robot in self.robots]
        return np.concatenate([*parts, np.ones(FREE_BODY.size * len(self.free), np.bool_)])

    def frame(self, member: str, frame: Frame) -> Frame:
        """A frame of a robot's own tree (for example from `tool_frame`), as a frame of the team's tree."""
        return replace(frame, joint=self.joined.joint(self.members.index(member), frame.joint))

    def named(self, name: str, state: GeometricState) -> Frame:
        """The frame of the thing called `name`, with things at their poses in `state`.

        Raises:
            ValueError: the scene has nothing of this name.
        """
        if name == "world":
            return WORLD
        if name in self.scene.bodies:
            return self._body(name, state, self.scene.bodies[name].features)
        robot, dot, link = name.partition(".")
        if dot and robot in self.scene.robots:
            own = _own_frame(self.scene.robots[robot], link)
            if robot in self.members:
                return self.frame(robot, own)
            at = joints_at(self.scene.robots[robot].tree, np.array(state.robots[robot]))[own.joint]
            return Frame(0, unflat(at) @ own.joint_T_frame, own.features)
        if name in self.scene.regions:
            return Frame(0, self.scene.regions[name].world_T_region, {})
        raise ValueError(
            f"nothing is called {name!r}: name a body, a region, `world`, `robot.tool` or `robot.link`"
        )

    def roles(
        self, state: GeometricState, constraints: Iterable[Constraint], names: Mapping[str, str] | None = None
    ) -> Roles:
        """The frame of every owner in the constraints: a role in `names` {role: thing}, or a thing itself.

        `tool` needs no name in a team of one robot.

        Raises:
            ValueError: a thing or a feature does not exist.
        """
        known = dict(names or {})
        if len(self.robots) == 1:
            known.setdefault("tool", f"{self.robots[0].name}.tool")
        features = [f for c in constraints if c.kind != "inside" for f in (c.first, c.second)]
        found = {
            owner: self.named(known.get(owner, owner), state) for owner in dict.fromkeys(f.owner for f in features)
        }
        for name in features:
            if not has(found, name):
                raise ValueError(
                    f"{name.owner} has no feature {name.feature!r}; it has {_listed(found[name.owner])}"
                )
        return found

    def configurations(self, q: Sequence[float] | Array) -> dict[str, Configuration]:
        """Each robot's configuration, by name, taken from a team's configuration (n,) and rounded as in states."""
        parts = zip(self.robots, self.joined.values, strict=False)
        return {robot.name: tuple(round(float(v), 9) + 0.0 for v in q[place]) for robot, place in parts}

    def poses(self, at: Candidate) -> dict[str, Array]:
        """The poses world_T_body (4, 4) of the free bodies at a candidate."""
        return {name: at.pose(self.frame(name, Frame(FREE_BODY.size, np.eye(4), {}))) for name in self.free}

    def base(self, state: GeometricState) -> Array:
        """The team's configuration (n,) in a state, with zeros for free bodies; source of the values that stay fixed."""
        parts = [np.array(state.robots[robot.name]) for robot in self.robots]
        return np.concatenate([*parts, np.zeros(FREE_BODY.size * len(self.free))])

    def _body(self, name: str, state: GeometricState, features: Mapping[str, Feature]) -> Frame:
        body_T_part, at = np.eye(4), name
        while at not in self.free and at in state.objects:
            held = state.objects[at]
            body_T_part = transform(held.position, held.quaternion) @ body_T_part
            at = held.parent
        if at in self.free:
            return self.frame(at, Frame(FREE_BODY.size, body_T_part, features))
        robot, dot, link = at.partition(".")
        if dot and robot in self.members:
            own = _link_frame(self.scene.robots[robot], link)
            return self.frame(robot, Frame(own.joint, own.joint_T_frame @ body_T_part, features))
        return Frame(0, world_T(self.scene, state, name), features)


@dataclass(frozen=True)
class TeamStream:
    """Configurations of a team that fulfil constraint rows, in an order determined by the stream's `key`.

    `base` (n,) holds the values that stay fixed, namely the grippers' values.
    """

    team: Team
    rows: Array
    key: Key
    base: Array

    @classmethod
    def of(
        cls,
        team: Team,
        constraints: Sequence[Constraint],
        state: GeometricState,
        key: Key,
        names: Mapping[str, str] | None = None,
    ) -> "TeamStream":
        """The stream for constraints between the frames that `Team.roles` finds, with everything else as in `state`.

        Raises:
            ValueError: a name or a feature does not exist, or a constraint has no meaning for its features.
        """
        roles = team.roles(state, constraints, names)
        return cls(team, rows(constraints, roles), key, team.base(state))

    def batch(self, number: int, size: int = BATCH_SAMPLES) -> list[Candidate]:
        """The valid samples of batch `number`, which has `size` samples, in order of their index."""
        return self.samples(number * size, size)

    def samples(self, first: int, count: int) -> list[Candidate]:
        """The valid ones of `count` samples from index `first` on, in order, from one kernel call.

        Two arms with closed forms are drawn pose first where the rows allow; samples that find none so are projected.
        """
        tree, arms = self.team.tree, self._arms
        made = drawn_together(arms, self.team.joined, self.rows, self.key, first, count) if arms else None
        if made is not None and made[1].all():
            return [self.candidate(q) for q in made[0]]
        found, valid = sample(
            tree, self.rows, self.key, first, count, tree.lower, tree.upper, self.team.moving, base=self.base
        )
        if made is not None:
            found, valid = np.where(made[1][:, None], made[0], found), made[1] | valid
        return [self.candidate(q) for q in found[valid]]

    @cached_property
    def _arms(self) -> tuple[ClosedArm, ...]:
        """The robots as arms with closed forms; empty if one has none or drives, or a body is free."""
        forms = [closed_form_of(robot) if robot.drive is None else None for robot in self.team.robots]
        places = self.team.joined.values
        arms = [
            ClosedArm(robot.tree, form, np.ascontiguousarray(self.base[place]))
            for robot, form, place in zip(self.team.robots, forms, places, strict=False)
            if form is not None
        ]
        return tuple(arms) if len(arms) == len(self.team.members) else ()

    def candidate(self, q: Sequence[float] | Array) -> Candidate:
        """The candidate of a configuration (n,) of the team, rounded as in states."""
        rounded = np.array(np.round(q, 9) + 0.0, np.float64)
        return Candidate(rounded, self.team.tree)


def _listed(frame: Frame) -> str:
    return ", ".join(frame.features) or "none"


def _own_frame(robot: Robot, name: str) -> Frame:
    return tool_frame(robot) if name == "tool" and robot.tool is not None else _link_frame(robot, name)


def _link_frame(robot: Robot, link: str) -> Frame:
    if link not in robot.links:
        raise ValueError(f"robot {robot.name} has no link {link!r}")
    found = robot.links[link]
    return Frame(found.joint, found.joint_T_link, {})
