"""Two gantries over a bench, a peg, and a socket on a pedestal: motions of two hands, written by hand.

The left hand comes from above, the right one from the side. The peg's mate stands on the socket, a full block: without
a grant that is a collision.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from kabo.language import Problem, load_problem, recorded_files
from kabo.plan import Grant, Node, ObjectPose, Plan, PlanBuilder, Segment, StateChange
from kabo.scene import load_scene
from tests.verify.counter import GANTRY

DOMAIN = """domain: joining
types: [robot, part]
predicates:
  done: [part]
actions:
  take:
    parameters: {r: robot, o: part}
    geometry: pick(r, o)
  give:
    parameters: {r: robot, o: part, to: robot}
    geometry: hand_over(r, o, to)
    effects: ['add(Kf, done(o))']
  join:
    parameters: {r: robot, o: part, other: part}
    geometry: insert(r, o, other, mate = seated)
    effects: ['add(Kf, done(o))']
  join_both:
    parameters: {r: robot, o: part, r2: robot, other: part}
    geometry: insert_bimanual(r, o, r2, other, mate = seated)
    effects: ['add(Kf, done(o))']
  wave:
    parameters: {r: robot, r2: robot}
    geometry: dance(r, r2)
  raise:
    parameters: {r: robot, o: part, r2: robot, other: part}
    geometry: heave(r, o, r2, other)
  shove:
    parameters: {r: robot, o: part}
    geometry: stir(r, o)
"""

PROBLEM = """problem: bench
scene: scene.yaml
objects:
  robot: [left, right]
  part: [peg, socket]
initial: ['add(Kf, not done(peg))']
goal: ['K(done(peg))']
"""

TASKS = {
    "hand_over": "robot: {type: robot}, object: {type: body}, receiver: {type: robot}",
    "insert": "robot: {type: robot}, object: {type: body}, other: {type: body}, mate: {type: name, default: any}",
    "insert_bimanual": "robot: {type: robot}, object: {type: body}, other_robot: {type: robot}, "
    "other: {type: body}, mate: {type: name, default: any}",
    "heave": "robot: {type: robot}, object: {type: body}, other_robot: {type: robot}, other: {type: body}",
    "dance": "first: {type: robot}, second: {type: robot}",
    "stir": "spoon: {type: robot}, pot: {type: body}",
}
TASK = """name: %s
properties: {%s}
stages:
  - name: start
    stage: CurrentState
"""

SCENE = """scene: bench
epsilon: 0.01
robot_models:
  gantry:
    urdf: gantry.urdf
    gripper:
      joints: [finger]
      open: {finger: 0.045}
      closed: {finger: 0}
      touch_links: [left, right]
    tool:
      frame: palm
      features:
        tcp: {point: [0, 0, -0.11]}
        approach: {line: {through: [0, 0, -0.11], along: [0, 0, -1]}}
        closing: {line: {through: [0, 0, -0.11], along: [0, 1, 0]}}
robots:
  left:
    model: gantry
    base: {position: [0, 0, 1]}
    configurations: {home: [-0.3, 0, -0.2, 0]}
  right:
    model: gantry
    base: {position: [0.3, 0, 1], rpy: [0, 0, 90 deg]}
    configurations: {home: [0, -0.3, -0.3, 90 deg]}
models:
  peg:
    box: [0.04, 0.04, 0.06]
    features: {grip: {point: [0, 0, 0.015]}}
    grasps:
      top:
        constraints:
          - coincident(tool.tcp, this.grip)
          - opposed(tool.approach, this.up)
          - parallel(tool.closing, this.y_axis)
        robots: [left]
        lift: {along: world.up, distance: [0.05, 0.2]}
        fingers: {finger: 0.02}
      side:
        constraints:
          - coincident(tool.tcp, this.center)
          - parallel(tool.closing, this.up)
        robots: [right]
        fingers: {finger: 0.03}
  socket:
    box: [0.08, 0.08, 0.04]
    features: {edge: {point: [0.04, 0, 0]}, seat: {point: [-0.02, 0, 0.02]}}
    grasps:
      side:
        constraints:
          - coincident(tool.tcp, this.edge)
          - parallel(tool.closing, this.up)
        fingers: {finger: 0.02}
objects:
  table: {box: [1.4, 1.2, 0.04], pose: {position: [0, 0, -0.02]}}
  pedestal: {box: [0.01, 0.01, 0.18], pose: {position: [0.3, 0, 0.09]}}
  peg: {model: peg, movable: true, pose: {position: [-0.3, 0, 0.03]}}
  socket: {model: socket, movable: true, pose: {position: [0.3, 0, 0.2]}}
mates:
  seated:
    moving: peg
    fixed: socket
    constraints:
      - distance(moving.center, fixed.seat) in [0.0299, 0.0301]
      - aligned(moving.up, fixed.up)
      - height(moving.center, fixed.top) in [0.0299, 0.0301]
      - parallel(moving.y_axis, fixed.y_axis)
    insertion: {against: fixed.up, distance: [0.02, 0.05]}
allowed_contacts:
  - [pedestal, table]
"""

ARM, HAND = ("x", "y", "z", "tilt"), ("finger",)
SIDE = math.pi / 2
STRAIGHT = (0.0, 0.0, 0.0, 1.0)
PEG, SOCKET = (-0.3, 0.0, 0.03), (0.3, 0.0, 0.2)
HOME = {"left": (-0.3, 0.0, -0.2, 0.0), "right": (0.0, -0.3, -0.3, SIDE)}
MATED = ("peg", "socket")


def above(x: float, y: float, z: float) -> tuple[float, ...]:
    """The left arm with its tool's point here."""
    return (x, y, z + 0.11 + 0.05 - 1.0, 0.0)


def beside(x: float, y: float, z: float) -> tuple[float, ...]:
    """The right arm with its tool's point here, pointing along -x."""
    return (y, 0.3 - (x + 0.11), z + 0.05 - 1.0, SIDE)


def fingers(robot: str, part: str) -> tuple[tuple[str, str], ...]:
    """The contacts of a hand and what it holds."""
    return ((f"{robot}.left", part), (f"{robot}.right", part))


def granting(contacts: tuple[tuple[str, str], ...]) -> tuple[Grant, ...]:
    """What grants contacts here: the grasp, its lift, or the mate."""
    made = []
    for first, second in contacts:
        by = "top" if first.startswith("left.") or (first, second) == ("peg", "table") else "side"
        kind = "grasp" if "." in first else "mate" if (first, second) == MATED else "support"
        made.append(Grant(kind, (first, second), "seated" if kind == "mate" else by))
    return tuple(made)


def stretch(robot: str, start: float, points: list[tuple[float, ...]], **more: Any) -> Segment:
    """A segment of an arm (4 numbers) or a hand (1), at half of its speed."""
    joints, speed = (ARM, 0.5) if len(points[0]) == 4 else (HAND, 0.05)
    times = [start]
    for a, b in zip(points, points[1:], strict=False):
        times.append(round(times[-1] + max(0.01, max(abs(p - q) for p, q in zip(a, b, strict=True)) / speed), 6))
    rounded = tuple(tuple(round(float(v), 9) for v in p) for p in points)
    more = {"grants": granting(more.get("allowed_contacts", ()))} | more
    return Segment(robot, joints, rounded, tuple(times), "by hand", None, **more)


def one_after_the_other(*parts: tuple[str, list[tuple[float, ...]], dict[str, Any]]) -> tuple[Segment, ...]:
    """Segments, each when the one before has ended."""
    result: list[Segment] = []
    for robot, points, more in parts:
        result.append(stretch(robot, result[-1].times[-1] if result else 0.0, points, **more))
    return tuple(result)


def after(q: dict[str, tuple[float, ...]], finger: dict[str, float], **objects: ObjectPose) -> StateChange:
    """The configurations of the robots, and where objects hang."""
    robots = {r: dict(zip((*ARM, *HAND), (*q[r], finger[r]), strict=True)) for r in q}
    rounded = {r: {j: round(v, 9) for j, v in joints.items()} for r, joints in robots.items()}
    return StateChange(rounded, objects)


ON_LEFT = ObjectPose("left.palm", (0.0, 0.0, -0.125), STRAIGHT)
H = math.sqrt(0.5)


def take_peg() -> Node:
    """Left picks the peg from above."""
    x, y, z = PEG
    grip, up = above(x, y, z + 0.015), above(x, y, z + 0.115)
    lifting = {"allowed_contacts": (*fingers("left", "peg"), ("peg", "table"))}
    closing = {"attach": (("peg", "left.palm"),), "allowed_contacts": fingers("left", "peg")}
    motion = one_after_the_other(
        ("left", [HOME["left"], up, grip], {}),
        ("left", [(0.045,), (0.02,)], closing),
        ("left", [grip, up], lifting),
    )
    change = after({"left": up}, {"left": 0.02}, peg=ON_LEFT)
    return Node("action", "take", {"r": "left", "o": "peg"}, motion=motion, after=change)


UP = above(PEG[0], PEG[1], PEG[2] + 0.115)
MEET = (-0.05, 0.0, 0.4)  # the peg's middle when the hands meet
GIVEN = above(MEET[0], MEET[1], MEET[2] + 0.015)


def peg_on_right() -> ObjectPose:
    """The peg in the right hand: its tool looks along -x, its own y upward or downward."""
    # palm: yaw by 90 deg, then tilt by 90 deg about its x; its inverse turns the peg
    return ObjectPose("right.palm", (0.0, 0.0, -0.11), (-0.5, -0.5, -0.5, 0.5))


def hand_over() -> Node:
    """Left carries the peg to where right takes it from the side."""
    near, there = beside(MEET[0] + 0.15, MEET[1], MEET[2]), beside(*MEET)
    gone = (GIVEN[0], GIVEN[1], GIVEN[2] + 0.15, 0.0)
    held = fingers("left", "peg")
    taking = {"attach": (("peg", "right.palm"),), "allowed_contacts": fingers("right", "peg")}
    motion = one_after_the_other(
        ("left", [UP, (*UP[:2], GIVEN[2], 0.0), GIVEN], {"allowed_contacts": held}),
        ("right", [HOME["right"], near, there], {}),
        ("right", [(0.045,), (0.03,)], taking),
        ("left", [(0.02,), (0.045,)], {"allowed_contacts": held}),
        ("left", [GIVEN, gone], {}),
    )
    change = after({"left": gone, "right": there}, {"left": 0.045, "right": 0.03}, peg=peg_on_right())
    return Node("action", "give", {"r": "left", "o": "peg", "to": "right"}, motion=motion, after=change)


def seat(socket: tuple[float, float, float], height: float = 0.0) -> tuple[float, ...]:
    """The left arm when the peg that it holds sits in the socket, or so high above."""
    return above(socket[0] - 0.02, socket[1], socket[2] + 0.05 + 0.015 + height)


SEATED = ObjectPose("socket", (-0.02, 0.0, 0.05), STRAIGHT)


def insert(**changes: Any) -> Node:
    """Left puts the peg into the socket on its pedestal."""
    high, over, low = seat(SOCKET, 0.2), seat(SOCKET, 0.04), seat(SOCKET)
    held = fingers("left", "peg")
    joining = {"allowed_contacts": (*held, MATED), "attach": (("peg", "socket"),)} | changes
    motion = one_after_the_other(
        ("left", [UP, (*UP[:2], high[2], 0.0), high, over], {"allowed_contacts": held}),
        ("left", [over, low], joining),
        ("left", [(0.02,), (0.045,)], {"allowed_contacts": held}),
        ("left", [low, high], {}),
    )
    change = after({"left": high}, {"left": 0.045}, peg=SEATED)
    return Node("action", "join", {"r": "left", "o": "peg", "other": "socket"}, motion=motion, after=change)


LIFTED = (SOCKET[0], SOCKET[1], SOCKET[2] + 0.1)


def take_socket(*carried: str) -> Node:
    """Right picks the socket from the side."""
    grip = beside(SOCKET[0] + 0.04, SOCKET[1], SOCKET[2])
    near, up = beside(SOCKET[0] + 0.14, SOCKET[1], SOCKET[2]), beside(LIFTED[0] + 0.04, LIFTED[1], LIFTED[2])
    lifting = {"allowed_contacts": (*fingers("right", "socket"), ("socket", "pedestal"))}
    closing = {"attach": (("socket", "right.palm"),), "allowed_contacts": fingers("right", "socket")}
    motion = one_after_the_other(
        ("right", [HOME["right"], (*near[:2], *HOME["right"][2:]), near, grip], {}),
        ("right", [(0.045,), (0.02,)], closing),
        ("right", [grip, up], lifting),
    )
    change = after({"right": up}, {"right": 0.02}, socket=SOCKET_ON_RIGHT)
    return Node("action", "take", {"r": "right", "o": "socket"}, motion=motion, after=change)


SOCKET_ON_RIGHT = ObjectPose("right.palm", (0.0, 0.0, -0.15), (-0.5, -0.5, -0.5, 0.5))


def insert_bimanual(*, together: bool = True, delay: float = 0.0) -> Node:
    """Left lowers the peg while right raises the socket: both move at once for the last stretch."""
    raised = (LIFTED[0], LIFTED[1], LIFTED[2] + 0.02)
    right_from, right_to = (beside(x + 0.04, y, z) for x, y, z in (LIFTED, raised))
    high, over, low = seat(LIFTED, 0.2), seat(LIFTED, 0.045), seat(raised)
    held, both = fingers("left", "peg"), fingers("right", "socket")
    first = stretch("left", 0.0, [UP, (*UP[:2], high[2], 0.0), high, over], allowed_contacts=held)
    start = first.times[-1]
    ends = (start, start + 0.5)
    meeting = (*held, MATED) if together else held
    down = replace(stretch("left", start, [over, low], allowed_contacts=meeting), times=ends)
    begins = ends if together else (ends[1], ends[1] + 0.5)
    rise = replace(
        stretch("right", start, [right_from, right_to], allowed_contacts=(*both, MATED)),
        times=tuple(t + delay for t in begins),
        attach=(("peg", "socket"),),
    )
    last = one_after_the_other(
        ("left", [(0.02,), (0.045,)], {"allowed_contacts": held}),
        ("left", [low, (*low[:2], low[2] + 0.15, 0.0)], {}),
    )
    moved = tuple(replace(s, times=tuple(round(t + rise.times[-1], 6) for t in s.times)) for s in last)
    change = after(
        {"left": (*low[:2], low[2] + 0.15, 0.0), "right": right_to}, {"left": 0.045, "right": 0.02}, peg=SEATED
    )
    arguments = {"r": "left", "o": "peg", "r2": "right", "other": "socket"}
    return Node("action", "join_both", arguments, motion=(first, down, rise, *moved), after=change)


def lift_both(*, delay: float = 0.0) -> Node:
    """Each hand takes its part; then both arms lift at once, the right one so much later."""
    (*mine, up), (*theirs, rise) = take_peg().motion, take_socket().motion
    begin = mine[-1].times[-1]
    theirs = [replace(s, times=tuple(round(t + begin, 6) for t in s.times)) for s in theirs]
    start = theirs[-1].times[-1]
    up, rise = (replace(s, times=(start + late, start + late + 0.5)) for s, late in ((up, 0.0), (rise, delay)))
    change = after(
        {"left": up.waypoints[-1], "right": rise.waypoints[-1]},
        {"left": 0.02, "right": 0.02},
        peg=ON_LEFT,
        socket=SOCKET_ON_RIGHT,
    )
    arguments = {"r": "left", "o": "peg", "r2": "right", "other": "socket"}
    return Node("action", "raise", arguments, motion=(*mine, *theirs, up, rise), after=change)


@dataclass(frozen=True)
class Bench:
    """The problem; plans are chains of nodes."""

    problem: Problem

    def plan(self, *nodes: Node) -> Plan:
        """The nodes one after the other, then the goal."""
        assert self.problem.scene is not None
        scene, builder = load_scene(self.problem.scene), PlanBuilder()
        following = builder.goal()
        for node in reversed(nodes):
            following = builder.add(replace(node, next=following))
        robots = {
            name: dict(zip(scene.robots[name].joint_names, q, strict=True))
            for name, q in scene.start.robots.items()
        }
        objects = {n: ObjectPose(a.parent, a.position, a.quaternion) for n, a in scene.start.objects.items()}
        return builder.build(
            following,
            problem=self.problem.name,
            files={**self.problem.files, **recorded_files(scene.files.items(), self.problem.path.parent)},
            options={"search": "by hand", "seed": 0, "epsilon": 0.01, "geometry": "bounding"},
            start=StateChange(robots, objects),
        )


def load(folder: Path, **replacements: str) -> Bench:
    """The problem, written into a folder; `scene` and `domain` replace the texts of these files."""
    texts = {"domain.yaml": DOMAIN, "scene.yaml": SCENE, "bench.yaml": PROBLEM}
    texts |= {f"{name}.yaml": text for name, text in replacements.items()}
    texts["gantry.urdf"] = GANTRY.replace('lower="-1.5" upper="1.5"', 'lower="-1.6" upper="1.6"')
    (folder / "tasks").mkdir(exist_ok=True)
    texts |= {f"tasks/{name}.yaml": TASK % (name, properties) for name, properties in TASKS.items()}
    for name, text in texts.items():
        (folder / name).write_text(text)
    return Bench(load_problem(folder / "bench.yaml"))
