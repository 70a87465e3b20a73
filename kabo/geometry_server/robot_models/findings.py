"""Findings in the robots of a scene: meshes that enclose nothing, words of SRDF files, configurations in collision."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from kabo.arrays import Array
from kabo.children import never
from kabo.errors import About, Diagnostic, InputError, MeshError
from kabo.geometry import Budget, FixedGroup, MovingGroup
from kabo.geometry_server.answers import GeometryStatistics
from kabo.geometry_server.predicates import ScenePredicates
from kabo.geometry_server.preparation.remedies import Failure
from kabo.geometry_server.preparation.remedies import findings as open_findings
from kabo.geometry_server.robot_models.covers import CoverSurroundings
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.language.formulas import Place
from kabo.language.scene_description import RobotDescription, SceneDescription
from kabo.meshes import Mesh, require_closed
from kabo.scene import Robot, Scene, link_poses, load_scene
from kabo.scene.mimic_limits import MAX_VELOCITY
from kabo.scene.semantics import findings as semantic_findings
from kabo.scene.semantics import spelled
from kabo.scene.transforms import flat

SMALL_EXTENT = 5e-4  # [m]: links are larger, unless metres were taken for millimetres
SHOWN_JOINTS = 6  # joints without a velocity limit that are named
SHOWN_PAIRS = 6  # pairs in collision that are told of one configuration


def robot_findings(
    description: SceneDescription,
    look: Callable[[], None] = never,
    *,
    scene: Scene | None = None,
    configurations: bool = True,
) -> list[Diagnostic]:
    """The findings in the robots of a scene that loads; the errors of loading it, if it does not.

    Covered: each link's meshes, the SRDF files, and, with `configurations`, whether the robot's named configurations are
    free of the robot itself and of all that stands, for which convex parts are made. `look` is called now and then, and
    may raise. `scene` is the loaded scene; None loads it.
    """
    try:
        scene = scene or load_scene(description, look)
    except InputError as error:
        return list(error.diagnostics)
    found = [each for name in scene.robots for each in _mesh_findings(scene, description, name)]
    for name, robot in scene.robots.items():
        found += [*_semantic(robot, description.robots[name]), *_without_speed(robot, description.robots[name])]
    if not configurations or any(each.severity == "error" for each in found):
        return found
    checked = _Configurations(scene, description, look)
    return [*found, *(each for name in scene.robots for each in checked.findings(name))]


def _mesh_findings(scene: Scene, description: SceneDescription, name: str) -> Iterator[Diagnostic]:
    """Errors of links whose meshes are open, each with remedies that were tried; warnings about tiny ones."""
    robot, described = scene.robots[name], description.robots[name]
    failures: list[Failure] = []
    for link in robot.links.values():
        for element in link.elements:
            if element.kind != "mesh" or link.name in robot.hulls:
                continue
            try:
                require_closed(element.mesh, element.place)
            except MeshError as error:
                failures.append(Failure(f"{name}.{link.name}", element, error))
            if (extent := _extent(element.mesh)) < SMALL_EXTENT:
                told = _tiny(link.name, name, extent, element.place or described.place)
                yield replace(told, about=About((f"{name}.{link.name}",)))
    yield from open_findings(scene, failures)


def _extent(mesh: Mesh) -> float:
    low, high = mesh.bounds
    return float((high - low).max())


def _tiny(link: str, robot: str, extent: float, place: Place | None) -> Diagnostic:
    at = place or Place("scene", 1, 1)
    said = f'link "{link}" of robot "{robot}" is {1000 * extent:.3g} mm large: is it scaled twice?'
    return Diagnostic(at.file, at.line, at.column, said, "lengths of a URDF are metres", at.length, "warning")


def _semantic(robot: Robot, described: RobotDescription) -> list[Diagnostic]:
    if described.semantics is None:
        return []
    bounds = zip(robot.tree.lower.tolist(), robot.tree.upper.tolist(), strict=True)
    limits = dict(zip(robot.joint_names, bounds, strict=True))
    return semantic_findings(described.semantics, robot.groups.joints, tuple(robot.links), limits)


def _without_speed(robot: Robot, described: RobotDescription) -> Iterator[Diagnostic]:
    """A warning about planned joints whose velocity limit kabo chooses, as the URDF gives none that a joint can have."""
    limits = {name: float(robot.model.velocityLimit[robot.model.joints[j].idx_v]) for j, name in _moving(robot)}
    given = described.velocity.joints if described.velocity.every is None else limits
    chosen = [name for name, limit in limits.items() if not 0.0 < limit < MAX_VELOCITY and name not in given]
    if chosen:
        at = described.place or Place("scene", 1, 1)
        more = f" and {len(chosen) - SHOWN_JOINTS} more" if len(chosen) > SHOWN_JOINTS else ""
        between = f"above 0 and below {MAX_VELOCITY:g}"
        said = f'the URDF of robot "{robot.name}" has no velocity limit {between} for {", ".join(chosen[:SHOWN_JOINTS])}'
        hint = (
            'motions take pi rad/s (m/s where it slides): write <limit velocity="…"/>, or `velocity` in the scene'
        )
        about = About((robot.name,))
        yield Diagnostic(at.file, at.line, at.column, f"{said}{more}", hint, at.length, "warning", about=about)


def _moving(robot: Robot) -> Iterator[tuple[int, str]]:
    """The planned joints, with their numbers in pinocchio's model."""
    names = list(robot.model.names)
    return ((names.index(name), name) for name in robot.planned_joints[robot.base_values :])


class _Configurations:
    """The named configurations of a scene's robots, checked on covers first, then on the links' enclosures."""

    def __init__(self, scene: Scene, description: SceneDescription, look: Callable[[], None]) -> None:
        self.scene, self.description = scene, description
        self.covers = CoverSurroundings(scene, scene.epsilon)
        self.fine = SceneSurroundings(scene, Budget.share(scene.epsilon), False, GeometryStatistics())
        self.covers.look = self.fine.look = look
        self.look = look

    def findings(self, name: str) -> Iterator[Diagnostic]:
        """The findings in the configurations of a robot; a mesh that has no enclosure ends them."""
        robot, described = self.scene.robots[name], self.description.robots[name]
        start = self.scene.start.robots[name]
        named = {"home": start[: robot.planned], **robot.configurations}
        seen: set[tuple[float, ...]] = set()
        for word, values in named.items():
            if tuple(values) in seen:
                continue
            seen.add(tuple(values))
            told = word if word in robot.configurations else "the start (joints at zero, within their limits)"
            q = (*values, *start[robot.planned :])
            try:
                yield from self._configuration(robot, described, told, q)
            except InputError as error:
                yield from error.diagnostics
                return

    def _configuration(
        self, robot: Robot, described: RobotDescription, named: str, q: Sequence[float]
    ) -> Iterator[Diagnostic]:
        poses = {f"{robot.name}.{link}": pose for link, pose in link_poses(robot, q).items()}
        poses.update(self.scene.fixed_poses)
        met = [pair for pair in self._pairs(robot) if self._touch(robot, pair, poses, q)]
        at = _place_of(robot, described, named)
        for pair in met[:SHOWN_PAIRS]:
            yield self._finding(robot, named, pair, at, q)
        if len(met) > SHOWN_PAIRS:
            said = f'configuration "{named}" of robot "{robot.name}": {len(met) - SHOWN_PAIRS} more pairs overlap'
            yield Diagnostic(at.file, at.line, at.column, said, None, at.length, "warning")

    def _pairs(self, robot: Robot) -> list[tuple[str, str]]:
        """The pairs of one robot's links, and of its links and the bodies that stand, that are checked."""
        links = [f"{robot.name}.{link.name}" for link in robot.links.values() if link.elements]
        others = [*links, *self.scene.fixed_poses]
        apart = self.scene.never_collide
        return [(a, b) for i, a in enumerate(links) for b in others[i + 1 :] if not apart(a, b)]

    def _touch(self, robot: Robot, pair: tuple[str, str], poses: Mapping[str, Array], q: Sequence[float]) -> bool:
        """Whether two things may touch, as a planner asks: of covers, then of enclosures."""
        if not _near(self.scene, pair, poses, self.scene.epsilon):
            return False
        return all(self._hit(each, robot, pair, poses, q) for each in (self.covers, self.fine))

    def _hit(
        self,
        surroundings: SceneSurroundings,
        robot: Robot,
        pair: tuple[str, str],
        poses: Mapping[str, Array],
        q: Sequence[float],
    ) -> bool:
        self.look()
        moving, fixed = [], []
        for name in pair:
            link = robot.links[name.partition(".")[2]] if name.startswith(f"{robot.name}.") else None
            if link is None or robot.stands(link.name):
                fixed.append(FixedGroup(flat(poses[name]), surroundings.enclosure(name)))
            else:
                moving.append(MovingGroup(link.joint, flat(link.joint_T_link), surroundings.enclosure(name)))
        if not moving:
            return surroundings.touch(*fixed)
        checker = surroundings.checker(robot.tree, moving, fixed, np.array([[0, 1]]))
        return checker.configuration_hit(np.asarray(q, np.float64)) >= 0

    def _finding(
        self, robot: Robot, named: str, pair: tuple[str, str], at: Place, q: Sequence[float]
    ) -> Diagnostic:
        state = replace(self.scene.start, robots={**self.scene.start.robots, robot.name: tuple(q)})
        bounds = ScenePredicates(self.fine, state).distance(*pair)
        first, second = pair
        names = f'"{first}" and "{second}"'
        if bounds.upper < 0.0:
            depth = f"overlap by at least {-1000 * bounds.upper:.3g} mm"
        else:
            depth = f"are not proven {1000 * self.scene.epsilon:.3g} mm apart (epsilon)"
        what = named if named.startswith("the start") else f'configuration "{named}"'
        own = [name.partition(".")[2] for name in pair if name.startswith(robot.name + ".")]
        hint = f"write another one, or move the body; or allow it: allowed_contacts: [[{first}, {second}]]"
        if len(own) == 2:
            hint = (
                f"`kabo robot` finds a free one; or allow it in the robot: allowed_contacts: [[{', '.join(own)}]]"
            )
        start = named == "home" or named.startswith("the start")
        severity: Literal["error", "warning"] = "error" if start and bounds.upper < 0.0 else "warning"
        said = f'{what} of robot "{robot.name}": {names} {depth}'
        about = About(pair, bounds.upper if bounds.upper < 0.0 else max(0.0, bounds.lower), (robot.name, tuple(q)))
        return Diagnostic(at.file, at.line, at.column, said, hint, at.length, severity, about=about)


def _place_of(robot: Robot, described: RobotDescription, named: str) -> Place:
    """Where a configuration is written: in the SRDF, or with the robot in the scene."""
    states = () if described.semantics is None else described.semantics.states
    if named not in described.configurations:
        for state in states:
            if spelled(state.name) == named and state.place is not None:
                return state.place
    return described.place or Place("scene", 1, 1)


def _near(scene: Scene, pair: tuple[str, str], poses: Mapping[str, Array], margin: float) -> bool:
    """Whether the balls around two things come within a margin [m]."""
    balls = []
    for name in pair:
        robot, dot, link = name.partition(".")
        mesh = scene.robots[robot].links[link].mesh if dot else scene.bodies[name].mesh
        if mesh is None or not len(mesh.vertices):
            return False
        low, high = mesh.bounds
        middle = poses[name][:3, :3] @ (0.5 * (low + high)) + poses[name][:3, 3]
        balls.append((middle, 0.5 * float(np.linalg.norm(high - low))))
    (first, r), (second, s) = balls
    return float(np.linalg.norm(first - second)) <= r + s + margin
