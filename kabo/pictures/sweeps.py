"""What a motion of a plan sweeps, as convex polyhedra that are proven to contain it: glass over the bodies."""

import re
from dataclasses import replace

import numpy as np

from kabo.errors import Diagnostic, InputError
from kabo.geometry import MovingGroup, SweptVolume
from kabo.pictures.drawing import Drawing, Glass, Solid
from kabo.pictures.film import Film
from kabo.pictures.plans import require_node
from kabo.pictures.scenes import GLASS, poses_in, scene_drawing
from kabo.plan import Plan, Segment, branch_of
from kabo.scene import GeometricState, Scene
from kabo.scene.transforms import unflat
from kabo.viewer.content.plan.off_path import farthest_off

VOLUME_OPACITY, GHOST_OPACITY = 0.38, 0.55
GHOST = "#8fb8de"


def sweep_drawing(plan: Plan, scene: Scene, wanted: str, tolerance: float, file: str) -> tuple[Drawing, str]:
    """The scene before a motion of a plan with what the motion sweeps, and a line of figures.

    Args:
        plan: the plan. scene: its scene. wanted: a node, such as `n4`, or one of its segments, `n4:2`, counted from 1.
        tolerance: how far the polyhedra may be from what is swept [m]. file: the plan's name in errors.

    Raises:
        InputError: there is no such node or segment, or it does not move.
    """
    name, segments = _chosen(plan, wanted, file)
    film = Film(plan, scene, branch_of(plan, name, file))
    moving = sorted(segments, key=lambda segment: segment.times[0])
    before = film.at(name, moving[0].times[0]) if moving[0].times[0] > 0.0 else film.before(name)
    solids: list[Solid] = []
    parts, farthest = 0, 0.0
    for segment in moving:
        volume = _volume(
            scene, film.at(name, segment.times[0]) if segment.times[0] > 0.0 else before, segment, tolerance
        )
        vertices, faces = volume.mesh()
        solids.append(Solid(f"swept {len(solids)}", np.asarray(vertices), np.asarray(faces), GLASS, smooth=False))
        parts, farthest = parts + len(volume.parts), max(farthest, volume.deviation)
    drawing = scene_drawing(scene, before)
    after = drawing.moved(poses_in(scene, film.at(name, moving[-1].times[-1])))
    ghosts = tuple(
        Solid(f"end of {new.name}", new.vertices, new.faces, GHOST, new.pose, 0.0)
        for old, new in zip(drawing.solids, after.solids, strict=True)
        if not np.allclose(old.pose, new.pose)
    )
    glass = (Glass(ghosts, GHOST_OPACITY), Glass(tuple(solids), VOLUME_OPACITY))
    shown = Drawing(drawing.solids, glass, labels=tuple(each for each in drawing.labels if each.about))
    return shown, f"{parts} polyhedra, none farther than {1e3 * farthest:.1f} mm from what is swept"


def _chosen(plan: Plan, wanted: str, file: str) -> tuple[str, tuple[Segment, ...]]:
    name, colon, text = wanted.partition(":")
    require_node(plan, name, file)
    motion = plan.nodes[name].motion
    if not motion:
        moving = [other for other, node in plan.nodes.items() if node.motion]
        hint = f"these do: {', '.join(moving[:8])}" if moving else "the plan was made without motions"
        raise InputError([Diagnostic(file, 1, 1, f"{name} does not move anything", hint)])
    if not colon:
        return name, motion
    if not re.fullmatch(r"\d{1,6}", text) or not 1 <= int(text) <= len(motion):
        hint = f"it has {len(motion)}: {name}:1 to {name}:{len(motion)}"
        raise InputError([Diagnostic(file, 1, 1, f'{name} has no segment "{text}"', hint)])
    return name, (motion[int(text) - 1],)


def _volume(scene: Scene, state: GeometricState, segment: Segment, tolerance: float) -> SweptVolume:
    from kabo.geometry_server import GeometryServer  # compiles kernels: only this picture needs them

    robot, start = scene.robots[segment.robot], np.array(state.robots[segment.robot])
    columns = robot.columns(segment.joints)
    waypoints = np.tile(start, (len(segment.waypoints), 1))
    waypoints[:, columns] = segment.waypoints
    predicates = GeometryServer(scene).predicates(state)
    motion = predicates.motion(segment.robot, waypoints.tolist())
    if segment.trajectory is None:
        return predicates.swept_volume(motion, tolerance)
    deviations = np.zeros(robot.tree.size)
    deviations[columns] = segment.trajectory.deviation
    off = max(farthest_off(robot.tree, each.joint, _radius(each), deviations) for each in motion.bodies)
    volume = predicates.swept_volume(motion, tolerance)
    hulls = (replace(h, growth=h.growth + off, deviation=h.deviation + off) for h in volume.hulls)
    return SweptVolume(tuple(hulls))


def _radius(body: MovingGroup) -> float:
    """The distance of a body's farthest vertex from the origin of the joint that carries it [m]."""
    if body.mesh is None:
        return 0.0
    pose, vertices = unflat(body.joint_T_group), body.mesh[0]
    return float(np.linalg.norm(vertices @ pose[:3, :3].T + pose[:3, 3], axis=1).max())
