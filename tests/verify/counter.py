"""A small world for the verifier: a gantry with a gripper, a cup, a tray, a thin plate, and a second robot.

Every joint but one is prismatic, so that motions can be written by hand: the tool stands where x, y, z say.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from kabo.language import Problem, load_problem, recorded_files
from kabo.plan import Grant, Node, ObjectPose, Plan, PlanBuilder, Segment, StateChange
from kabo.scene import load_scene

GANTRY = """<robot name="gantry">
  <link name="base"/>
  <link name="bridge"/>
  <link name="carriage"/>
  <link name="column"><collision><origin xyz="0 0 0.1"/>
    <geometry><box size="0.04 0.04 0.2"/></geometry></collision></link>
  <link name="palm"><collision><origin xyz="0 0 -0.03"/>
    <geometry><box size="0.04 0.14 0.04"/></geometry></collision></link>
  <link name="left"><collision><origin xyz="0 0.005 -0.04"/>
    <geometry><box size="0.02 0.01 0.08"/></geometry></collision></link>
  <link name="right"><collision><origin xyz="0 -0.005 -0.04"/>
    <geometry><box size="0.02 0.01 0.08"/></geometry></collision></link>
  <joint name="x" type="prismatic"><parent link="base"/><child link="bridge"/><axis xyz="1 0 0"/>
    <limit lower="-0.6" upper="0.6" velocity="1" effort="1"/></joint>
  <joint name="y" type="prismatic"><parent link="bridge"/><child link="carriage"/><axis xyz="0 1 0"/>
    <limit lower="-0.4" upper="0.4" velocity="1" effort="1"/></joint>
  <joint name="z" type="prismatic"><parent link="carriage"/><child link="column"/><axis xyz="0 0 1"/>
    <limit lower="-0.8" upper="0" velocity="1" effort="1"/></joint>
  <joint name="tilt" type="revolute"><parent link="column"/><child link="palm"/>
    <origin xyz="0 0 -0.05"/><axis xyz="1 0 0"/>
    <limit lower="-1.5" upper="1.5" velocity="2" effort="1"/></joint>
  <joint name="finger" type="prismatic"><parent link="palm"/><child link="left"/>
    <origin xyz="0 0 -0.06"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.05" velocity="0.1" effort="1"/></joint>
  <joint name="finger_2" type="prismatic"><parent link="palm"/><child link="right"/>
    <origin xyz="0 0 -0.06"/>
    <axis xyz="0 -1 0"/><limit lower="0" upper="0.05" velocity="0.1" effort="1"/><mimic joint="finger"/></joint>
</robot>
"""

BARRIER = """<robot name="barrier">
  <link name="post"/>
  <link name="bar"><collision><origin xyz="0.15 0 0"/>
    <geometry><box size="0.3 0.02 0.02"/></geometry></collision></link>
  <joint name="swing" type="revolute"><parent link="post"/><child link="bar"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
</robot>
"""

DOMAIN = """domain: serve
types: [robot, cup, spot]
predicates:
  hand_empty: [robot]
  holding: [robot, cup]
  full: [cup]
  sunny: [robot]
  at: [cup, spot]
actions:
  look:
    parameters: {r: robot}
    sense: sunny(r)
  swing:
    parameters: {r: robot}
    geometry: move(r)
  take:
    parameters: {r: robot, c: cup}
    preconditions:
      - K(hand_empty(r))
    geometry: pick(r, c)
    effects:
      - add(Kf, holding(r, c), not hand_empty(r))
  weigh:
    parameters: {r: robot, c: cup}
    preconditions:
      - K(holding(r, c))
    geometry: sense_weight(r, c)
    sense: full(c)
  put:
    parameters: {r: robot, c: cup, s: spot}
    preconditions:
      - K(holding(r, c))
      - K(not full(c))
    geometry: place(r, c, s)
    effects:
      - add(Kf, at(c, s), hand_empty(r), not holding(r, c))
  carry:
    parameters: {r: robot, c: cup, s: spot}
    preconditions:
      - K(holding(r, c))
      - K(full(c))
    geometry: transfer(r, c, s, keep = upright)
    effects:
      - add(Kf, at(c, s))
  let_go:
    parameters: {r: robot, c: cup, s: spot}
    preconditions:
      - K(at(c, s))
      - K(holding(r, c))
    geometry: release(r, c, s)
    effects:
      - add(Kf, hand_empty(r), not holding(r, c))
"""

PROBLEM = """problem: one_cup
scene: scene.yaml
objects:
  robot: [arm, gate]
  cup: [mug]
  spot: [tray]
initial:
  - add(Kf, hand_empty(arm), hand_empty(gate))
  - forall(robot r) add(Kf, not holding(r, mug))
goal:
  - K(at(mug, tray))
  - K(hand_empty(arm))
"""

SCENE = """scene: counter
epsilon: 0.01
robots:
  arm:
    urdf: gantry.urdf
    base: {position: [0, 0, 1]}
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
    configurations:
      home: [-0.3, 0, -0.2, 0]
      weigh: [-0.3, 0, -0.3, 0]
  gate:
    urdf: barrier.urdf
    base: {position: [0.3, 0.45, 0.5]}
objects:
  table: {box: [1.2, 1.2, 0.04], pose: {position: [0, 0, -0.02]}}
  plate: {box: [0.002, 0.3, 0.3], pose: {position: [0, 0, 0.15]}}
  bin: {box: [0.2, 0.2, 0.2], pose: {position: [-0.3, 0.3, 0.1]}}
  mug:
    box: [0.04, 0.04, 0.1]
    pose: {position: [-0.3, 0, 0.05]}
    movable: true
    grasps:
      top:
        constraints:
          - coincident(tool.tcp, this.center)
          - opposed(tool.approach, this.up)
          - parallel(tool.closing, this.y_axis)
        approach: {along: tool.approach, distance: [0.05, 0.1]}
        lift: {along: world.up, distance: [0.05, 0.1]}
        fingers: {finger: 0.02}
    placements:
      standing:
        constraints:
          - coincident(this.bottom, support.top)
          - aligned(this.up, world.up)
          - inside(this, region)
        retreat: {against: tool.approach, distance: [0.05, 0.5]}
regions:
  tray: {box: [0.12, 0.12, 0.3], pose: {position: [0.3, 0, 0.13]}, support: table}
motion_constraints:
  upright:
    - angle(this.up, world.up) <= 10 deg
allowed_contacts:
  - [plate, table]
  - [bin, table]
"""

ARM, HAND = ("x", "y", "z", "tilt"), ("finger",)
LOW, HIGH, OVER = -0.79, -0.7, -0.3  # z: the tool at the cup on the table, just lifted, above the plate
FINGERS = (("arm.left", "mug"), ("arm.right", "mug"))


def granting(contacts: tuple[tuple[str, str], ...]) -> tuple[Grant, ...]:
    """What grants contacts here: a finger's the grasp, the mug's with what it stands on the grasp's lift."""
    return tuple(Grant("grasp" if "." in pair[0] else "support", pair, "top") for pair in contacts)


def stretch(start: float, points: list[tuple[float, ...]], stage: str, procedure: str, **more: Any) -> Segment:
    """A segment through points of the arm (4 numbers) or the hand (1), at half of its speed."""
    joints, speed = (ARM, 0.5) if len(points[0]) == 4 else (HAND, 0.05)
    times = [start]
    for a, b in zip(points, points[1:], strict=False):
        times.append(round(times[-1] + max(0.01, max(abs(p - q) for p, q in zip(a, b, strict=True)) / speed), 6))
    points = [tuple(map(float, p)) for p in points]
    more = {"grants": granting(more.get("allowed_contacts", ()))} | more
    return Segment("arm", joints, tuple(points), tuple(times), procedure, stage, **more)


def motion(procedure: str, *stretches: tuple[list[tuple[float, ...]], str, dict[str, Any]]) -> tuple[Segment, ...]:
    """Segments one after the other."""
    result: list[Segment] = []
    for points, stage, more in stretches:
        result.append(stretch(result[-1].times[-1] if result else 0.0, points, stage, procedure, **more))
    return tuple(result)


def change(q: tuple[float, ...], finger: float, mug: ObjectPose | None = None) -> StateChange:
    """The arm's configuration, and where the mug is if that changes."""
    joints = dict(zip((*ARM, *HAND), (*q, finger), strict=True))
    return StateChange({"arm": joints}, {} if mug is None else {"mug": mug})


HOME, WEIGH = (-0.3, 0.0, -0.2, 0.0), (-0.3, 0.0, -0.3, 0.0)
STRAIGHT = (0.0, 0.0, 0.0, 1.0)
HELD = ObjectPose("arm.palm", (0.0, 0.0, -0.11), STRAIGHT)
SERVED = ObjectPose("world", (0.3, 0.0, 0.05), STRAIGHT)
MUG_TABLE = (("mug", "table"),)


def at(x: float, z: float, tilt: float = 0.0) -> tuple[float, ...]:
    """A point of the arm in the plane y = 0."""
    return (x, 0.0, z, tilt)


def take() -> tuple[Segment, ...]:
    """The motion of `take`."""
    return motion(
        "pick",
        ([HOME, at(-0.3, -0.7)], "reach", {}),
        ([at(-0.3, -0.7), at(-0.3, LOW)], "approach", {}),
        ([(0.045,), (0.02,)], "close", {"attach": (("mug", "arm.palm"),), "allowed_contacts": FINGERS}),
        ([at(-0.3, LOW), at(-0.3, HIGH)], "lift", {"allowed_contacts": FINGERS + MUG_TABLE}),
    )


def weigh() -> tuple[Segment, ...]:
    """The motion of `weigh`."""
    return motion("sense_weight", ([at(-0.3, HIGH), WEIGH], "weigh", {"allowed_contacts": FINGERS}))


def carry(procedure: str, constraint: str | None) -> tuple[Segment, ...]:
    """Over the plate and down into the tray."""
    both = {"allowed_contacts": FINGERS, "constraint": constraint}
    down = {"allowed_contacts": FINGERS + MUG_TABLE, "constraint": constraint}
    return motion(
        procedure,
        ([WEIGH, at(0.3, OVER), at(0.3, HIGH)], "transfer", both),
        ([at(0.3, HIGH), at(0.3, LOW)], "lower", down),
    )


def let_go(procedure: str, begin: tuple[Segment, ...] = ()) -> tuple[Segment, ...]:
    """Opens and retreats, after other segments."""
    start = begin[-1].times[-1] if begin else 0.0
    opening = {"detach": ("mug",), "allowed_contacts": FINGERS}
    first = stretch(start, [(0.02,), (0.045,)], "open", procedure, **opening)
    last = stretch(first.times[-1], [at(0.3, LOW), at(0.3, OVER)], "retreat", procedure)
    return (*begin, first, last)


@dataclass(frozen=True)
class Counter:
    """The problem, and a plan that is right: tests spoil a copy of it."""

    problem: Problem
    plan: Plan

    def node(self, action: str) -> str:
        """The id of the node with this action."""
        return next(name for name, node in self.plan.nodes.items() if node.action == action)

    def with_node(self, action: str, **changes: Any) -> Plan:
        """The plan with one node changed."""
        name = self.node(action)
        return replace(self.plan, nodes={**self.plan.nodes, name: replace(self.plan.nodes[name], **changes)})

    def with_segment(self, action: str, index: int, **changes: Any) -> Plan:
        """The plan with one segment of a node changed."""
        segments = list(self.plan.nodes[self.node(action)].motion)
        segments[index] = replace(segments[index], **changes)
        return self.with_node(action, motion=tuple(segments))


def build(problem: Problem) -> Plan:
    """The right plan: take, weigh; an empty mug is put down, a full one carried upright and let go."""
    assert problem.scene is not None
    scene = load_scene(problem.scene)
    builder, arguments = PlanBuilder(), {"r": "arm", "c": "mug"}
    there = {**arguments, "s": "tray"}
    goal = builder.goal()
    end = change(at(0.3, OVER), 0.045, SERVED)
    put = Node("action", "put", there, next=goal, motion=let_go("place", carry("place", None)), after=end)
    leave = builder.add(Node("action", "let_go", there, next=goal, motion=let_go("release"), after=end))
    upright = Node(
        "action", "carry", there, next=leave, motion=carry("transfer", "upright"), after=change(at(0.3, LOW), 0.02)
    )
    branches = {"true": builder.add(upright), "false": builder.add(put)}
    weighed = Node(
        "sense", "weigh", arguments, on="full(mug)", branches=branches, motion=weigh(), after=change(WEIGH, 0.02)
    )
    first = Node(
        "action",
        "take",
        arguments,
        next=builder.add(weighed),
        motion=take(),
        after=change(at(-0.3, HIGH), 0.02, HELD),
    )
    robots = {
        name: dict(zip(scene.robots[name].joint_names, q, strict=True)) for name, q in scene.start.robots.items()
    }
    objects = {n: ObjectPose(a.parent, a.position, a.quaternion) for n, a in scene.start.objects.items()}
    return builder.build(
        builder.add(first),
        problem=problem.name,
        files={**problem.files, **recorded_files(scene.files.items(), problem.path.parent)},
        options={"search": "by hand", "seed": 0, "epsilon": 0.01, "geometry": "bounding"},
        start=StateChange(robots, objects),
    )


def write_counter(folder: Path) -> Path:
    """Writes the files of the counter; returns the problem's path."""
    texts = {
        "domain.yaml": DOMAIN,
        "scene.yaml": SCENE,
        "gantry.urdf": GANTRY,
        "barrier.urdf": BARRIER,
        "one.yaml": PROBLEM,
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    return folder / "one.yaml"


def load(folder: Path) -> Counter:
    """The problem, written into a folder, and the right plan."""
    problem = load_problem(write_counter(folder))
    return Counter(problem, build(problem))
