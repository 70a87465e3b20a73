"""A UR5 of example-robot-data with jaws of boxes that open 110 mm, cups and a shelf: scenes without a plan.

Convex hulls stand for the links, so that each scene is ready in about a second. A cup is a cylinder, 68 mm wide.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

JAWS = """<robot name="jaws">
  <link name="palm"><collision><origin xyz="0 0 0.03"/><geometry><box size="0.05 0.16 0.04"/></geometry></collision></link>
  <link name="left_jaw"><collision><geometry><box size="0.02 0.01 0.10"/></geometry></collision></link>
  <link name="right_jaw"><collision><geometry><box size="0.02 0.01 0.10"/></geometry></collision></link>
  <joint name="jaw" type="prismatic"><parent link="palm"/><child link="left_jaw"/><origin xyz="0 0.005 0.10"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="0.055" velocity="0.1" effort="1"/></joint>
  <joint name="other_jaw" type="prismatic"><parent link="palm"/><child link="right_jaw"/><origin xyz="0 -0.005 0.10"/>
    <axis xyz="0 -1 0"/><limit lower="0" upper="0.055" velocity="0.1" effort="1"/><mimic joint="jaw"/></joint>
</robot>
"""

SCENE = """scene: ur5
epsilon: {epsilon}
packages: {{example-robot-data: installed}}
robot_models:
  ur5:
    urdf: package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf
    joints: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint, wrist_2_joint, wrist_3_joint]
    hulls: [base_link, shoulder_link, upper_arm_link, forearm_link, wrist_1_link, wrist_2_link, wrist_3_link]
    {limits}
    gripper:
      urdf: jaws.urdf
      mount: tool0
      open: {{jaw: 0.055}}
      closed: {{jaw: 0.0}}
      touch_links: [left_jaw, right_jaw]
    tool:
      frame: tool0
      features:
        tcp: {{point: [0, 0, 0.13]}}
        approach: {{line: {{through: [0, 0, 0.13], along: [0, 0, 1]}}}}
        closing: {{line: {{through: [0, 0, 0.13], along: [0, 1, 0]}}}}
    configurations: {{home: [0, -90 deg, 90 deg, -90 deg, -90 deg, 0]}}
    allowed_contacts: [[palm, ee_link], [palm, "wrist_?_link"]]
robots:
{robots}
models:
  cup:
    cylinder: {{radius: {radius}, height: 0.1}}
    features:
      base: {{plane: {{through: [0, 0, -0.05], normal: [0, 0, 1]}}}}
    grasps:
      above:
        constraints:
          - coincident(tool.tcp, this.axis)
          - opposed(tool.approach, this.axis)
          - height(tool.tcp, this.base) in [0.06, 0.08]
        approach: {{along: tool.approach, distance: [0.06, 0.1]}}
        lift: {{along: world.up, distance: [0.05, 0.1]}}
        fingers: {{jaw: {fingers}}}
    placements:
      standing:
        constraints:
          - coincident(this.base, support.top)
          - aligned(this.axis, world.up)
          - inside(this, region)
        retreat: {{against: tool.approach, distance: [0.06, 0.1]}}
objects:
  table: {{box: [1.2, 2.8, 0.1], pose: {{position: [0.5, 0, -0.05]}}}}
  plinth: {{box: [0.3, 2.8, 0.1], pose: {{position: [0, 0, -0.05]}}}}
regions:
  anywhere: {{box: [0.8, 2.6, 0.2], pose: {{position: [0.45, 0, 0.1]}}, support: table}}
  shelf: {{box: {box}, pose: {{position: [0.45, {side}, 0.1]}}, support: table}}
allowed_contacts: [{contacts}, [table, plinth]]
"""

DOMAIN = """domain: cups
types: [robot, thing, place]
constants: {place: [shelf, anywhere]}
predicates: {empty: [robot], holds: [robot, thing], held: [thing], at: [thing, place]}
actions:
  move:
    parameters: {r: robot}
    geometry: move(r)
  grasp:
    parameters: {r: robot, o: thing}
    preconditions: [K(empty(r)), K(not held(o))]
    geometry: pick(r, o)
    effects:
      - add(Kf, held(o), holds(r, o), not empty(r))
      - forall(place l) add(Kf, not at(o, l))
  put:
    parameters: {r: robot, o: thing, l: place}
    preconditions: ["K(holds(r, o))"]
    geometry: place(r, o, l)
    effects: ["add(Kf, not held(o), not holds(r, o), empty(r), at(o, l))"]
"""

PROBLEM = """problem: cups
domain: domain.yaml
scene: scene.yaml
objects: {{robot: [{robots}], thing: [{cups}]}}
bodies:
{bodies}
initial:
  - forall(robot r) add(Kf, empty(r))
  - forall(thing o) add(Kf, not held(o))
goal:
{goal}
"""
Position = Sequence[float]
AT, CUP = (0.5, -0.25, 0.05), "cup"
TWO_ARMS = {"right": (0.0, -0.55, 0.0), "left": (0.0, 0.55, 0.0)}


def cups(
    folder: Path,
    *,
    at: Mapping[str, Position] | None = None,
    walls: Mapping[str, tuple[Position, Position]] | None = None,
    robots: Mapping[str, Position] | None = None,
    radius: float = 0.034,
    box: Position = (0.2, 0.2, 0.2),
    side: float = 0.3,
    limits: str = "",
    epsilon: float = 0.01,
    goal: str = "K(at(cup, shelf))",
) -> Path:
    """The problem file of cups that shall go to the shelf; there is a plan if nothing else is said.

    Args:
        folder: where the files are written.
        at: where the middles of the cups are, by name [m].
        walls: boxes beside them that nobody moves, (size, position) [m].
        robots: where the bases of the arms are [m].
        radius: of the cups [m].
        box: the size of the shelf's region [m], `side` its y.
        side: as said.
        limits: a line of the robot's model with limits of joints.
        epsilon: of the scene [m].
        goal: one or several conjuncts, between lines.
    """
    arms, things = robots or {"arm": (0.0, 0.0, 0.0)}, at or {CUP: AT}
    bodies = [f"  {name}: {{model: cup, pose: {{position: {list(where)}}}}}" for name, where in things.items()]
    bodies += [
        f"  {name}: {{box: {list(size)}, pose: {{position: {list(where)}}}, movable: false}}"
        for name, (size, where) in (walls or {}).items()
    ]
    standing = [
        f"  {name}: {{model: ur5, base: {{position: {[float(v) for v in base]}}}}}" for name, base in arms.items()
    ]
    contacts = ", ".join(f"[{name}.base_link, {other}]" for name in arms for other in ("plinth", "table"))
    scene = SCENE.format(
        epsilon=epsilon,
        limits=limits,
        robots="\n".join(standing),
        radius=radius,
        fingers=min(radius, 0.055),
        box=list(box),
        side=side,
        contacts=contacts,
    )
    wanted = "\n".join(f"  - {each}" for each in goal.splitlines())
    problem = PROBLEM.format(robots=", ".join(arms), cups=", ".join(things), bodies="\n".join(bodies), goal=wanted)
    for name, text in (("jaws.urdf", JAWS), ("scene.yaml", scene), ("domain.yaml", DOMAIN)):
        (folder / name).write_text(text)
    path = folder / "problem.yaml"
    path.write_text(problem)
    return path
