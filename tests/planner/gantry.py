"""A gantry with a gripper above a table, all of boxes: what it reaches and what blocks it can be told by hand.

The tool points down. It reaches every x and y from -0.5 m to 0.5 m about its base, and any height above the table.
The fingers open along x by 0.035 m to each side of the tool, and are 0.01 m thick and 0.02 m wide.
"""

from pathlib import Path

from kabo.language import Problem, load_problem

ROBOT = """<robot name="gantry">
  <link name="base"/><link name="along"/><link name="across"/>
  <link name="mast"><collision><origin xyz="0 0 0.25"/><geometry><box size="0.03 0.03 0.4"/></geometry></collision></link>
  <link name="hand"><collision><origin xyz="0 0 0.03"/><geometry><box size="0.11 0.03 0.02"/></geometry></collision></link>
  <link name="left"><collision><geometry><box size="0.01 0.02 0.07"/></geometry></collision></link>
  <link name="right"><collision><geometry><box size="0.01 0.02 0.07"/></geometry></collision></link>
  <joint name="x" type="prismatic"><parent link="base"/><child link="along"/><axis xyz="1 0 0"/>
    <limit lower="-0.5" upper="0.5" velocity="1" effort="1"/></joint>
  <joint name="y" type="prismatic"><parent link="along"/><child link="across"/><axis xyz="0 1 0"/>
    <limit lower="-0.5" upper="0.5" velocity="1" effort="1"/></joint>
  <joint name="z" type="prismatic"><parent link="across"/><child link="mast"/><axis xyz="0 0 1"/>
    <limit lower="-0.95" upper="-0.3" velocity="1" effort="1"/></joint>
  <joint name="yaw" type="revolute"><parent link="mast"/><child link="hand"/><axis xyz="0 0 1"/>
    <limit lower="-1.6" upper="1.6" velocity="1" effort="1"/></joint>
  <joint name="finger" type="prismatic"><parent link="hand"/><child link="left"/><origin xyz="0.005 0 -0.025"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.04" velocity="0.1" effort="1"/></joint>
  <joint name="other_finger" type="prismatic"><parent link="hand"/><child link="right"/><origin xyz="-0.005 0 -0.025"/>
    <axis xyz="-1 0 0"/><limit lower="0" upper="0.04" velocity="0.1" effort="1"/><mimic joint="finger"/></joint>
</robot>
"""

SCENE = """scene: gantry
epsilon: {epsilon}
robots:
  gantry:
    urdf: gantry.urdf
    base: {{position: [0, 0, 1.0]}}
    joints: [x, y, z, yaw]
    gripper:
      joints: [finger]
      open: {{finger: 0.035}}
      closed: {{finger: 0.0}}
      touch_links: [left, right]
    tool:
      frame: hand
      features:
        tcp: {{point: [0, 0, -0.05]}}
        approach: {{line: {{through: [0, 0, -0.05], along: [0, 0, -1]}}}}
        closing: {{line: {{through: [0, 0, -0.05], along: [1, 0, 0]}}}}
    configurations: {{home: [0, 0, -0.5, 0]}}
models:
  cube:
    box: [0.04, 0.04, 0.04]
    features:
      center: {{point: [0, 0, 0]}}
      axis: {{line: {{through: [0, 0, 0], along: [0, 0, 1]}}}}
      x_axis: {{line: {{through: [0, 0, 0], along: [1, 0, 0]}}}}
      bottom: {{plane: {{through: [0, 0, -0.02], normal: [0, 0, 1]}}}}
    grasps:
      from_above:
        constraints:
          - coincident(tool.tcp, this.center)
          - opposed(tool.approach, this.axis)
          - parallel(tool.closing, this.x_axis)
        {robots}
        approach: {{along: tool.approach, distance: [0.05, 0.08]}}
        lift: {{along: world.up, distance: [0.05, 0.08]}}
        fingers: {{finger: 0.02}}
    placements:
      standing:
        constraints:
          - coincident(this.bottom, support.top)
          - aligned(this.axis, world.up)
          - inside(this, region)
        retreat: {{against: tool.approach, distance: [0.05, 0.08]}}
objects:
  table: {{box: [3, 3, 0.1], pose: {{position: [0, 0, -0.05]}}}}
regions:
  shelf:
    box: [0.2, 0.2, 0.2]
    pose: {{position: [-0.3, 0, 0.09]}}
    support: table
{more}
"""

DOMAIN = """domain: gantry
types: [robot, thing, location]
constants: {location: [shelf]}
predicates:
  held: [thing]
  free: [robot]
  at: [thing, location]
  dusty: [thing]
actions:
  take:
    parameters: {r: robot, o: thing}
    preconditions: [K(free(r)), K(not held(o))]
    geometry: pick(r, o)
    effects:
      - add(Kf, held(o), not free(r))
      - forall(location l) add(Kf, not at(o, l))
  put:
    parameters: {r: robot, o: thing, l: location}
    preconditions: [K(held(o))]
    geometry: place(r, o, l)
    effects: ["add(Kf, not held(o), free(r), at(o, l))"]
"""

PROBLEM = """problem: gantry
domain: domain.yaml
scene: scene.yaml
objects: {{robot: [gantry], thing: [{things}]}}
bodies: {{{bodies}}}
initial:
  - add(Kf, free(gantry))
  - forall(thing o) add(Kf, not held(o))
goal: ["{goal}"]
"""


def gantry(
    folder: Path,
    *,
    things: dict[str, tuple[float, float, float]] | None = None,
    walls: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] | None = None,
    goal: str = "K(at(cube, shelf))",
    epsilon: float = 0.01,
    robots: str = "",
) -> Path:
    """The problem file of a gantry that shall bring cubes to the shelf.

    Args:
        folder: where the files are written.
        things: where the middles of cubes are; `cube` only, in the middle of the table, by default.
        walls: boxes beside them, (size, position).
        goal: of the problem; `dusty(cube)` is what nobody can find out.
        epsilon: of the scene.
        robots: a line that says which robots the one grasp family is for.
    """
    cubes = things or {"cube": (0.2, 0.0, 0.02)}
    bodies = [f"{name}: {{model: cube, pose: {{position: {list(at)}}}}}" for name, at in cubes.items()]
    bodies += [
        f"{name}: {{box: {list(size)}, pose: {{position: {list(at)}}}}}"
        for name, (size, at) in (walls or {}).items()
    ]
    (folder / "gantry.urdf").write_text(ROBOT)
    (folder / "scene.yaml").write_text(SCENE.format(epsilon=epsilon, robots=robots, more=""))
    (folder / "domain.yaml").write_text(DOMAIN)
    path = folder / "problem.yaml"
    path.write_text(PROBLEM.format(things=", ".join(cubes), bodies=", ".join(bodies), goal=goal))
    return path


def gantry_problem(folder: Path, **given: object) -> Problem:
    """The same, read."""
    return load_problem(gantry(folder, **given))  # type: ignore[arg-type]
