"""Two gantries of which one gives a bar to the other: only the one reaches it, and only the other one its goal."""

from pathlib import Path

from kabo.language import Problem, load_problem
from tests.planner.gantry import ROBOT, SCENE

APART = 0.5  # [m] along x between the two bases

BAR = """\
  bar:
    box: [0.04, 0.3, 0.04]
    mass: 0.2
    features:
      center: {point: [0, 0, 0]}
      one_end: {point: [0, -0.1, 0]}
      other_end: {point: [0, 0.1, 0]}
      axis: {line: {through: [0, 0, 0], along: [0, 0, 1]}}
      x_axis: {line: {through: [0, 0, 0], along: [1, 0, 0]}}
      bottom: {plane: {through: [0, 0, -0.02], normal: [0, 0, 1]}}
    grasps:
"""
GRASP = """\
      {name}:
        robots: [{robot}]
        constraints:
          - coincident(tool.tcp, this.{end})
          - opposed(tool.approach, this.axis)
          - parallel(tool.closing, this.x_axis)
        approach: {{along: tool.approach, distance: [0.05, 0.08]}}
        lift: {{along: world.up, distance: [0.05, 0.08]}}
        fingers: {{finger: 0.02}}
"""
DOMAIN = """domain: giving
types: [robot, thing, location]
constants: {location: [shelf]}
predicates: {holds: [robot, thing], free: [robot], lies: [thing], at: [thing, location]}
events:
  lost:
    parameters: {r: robot, o: thing}
    effects: ["add(Kf, not holds(r, o), free(r), lies(o))"]
actions:
  take:
    parameters: {r: robot, o: thing}
    preconditions: ["K(free(r))", "K(lies(o))"]
    geometry: pick(r, o)
    effects: ["add(Kf, holds(r, o), not free(r), not lies(o))"]
  give:
    parameters: {r: robot, o: thing, s: robot}
    preconditions: ["K(r != s)", "K(holds(r, o))", "K(free(s))"]
    geometry: hand_over(r, o, s)
    effects: ["add(Kf, not holds(r, o), holds(s, o), free(r), not free(s))"]
  put:
    parameters: {r: robot, o: thing, l: location}
    preconditions: ["K(holds(r, o))"]
    geometry: place(r, o, l)
    effects: ["add(Kf, not holds(r, o), free(r), lies(o), at(o, l))"]
"""
PROBLEM = """problem: giving
domain: domain.yaml
scene: scene.yaml
objects: {robot: [gantry, other], thing: [rod]}
bodies: {rod: {model: bar, pose: {position: [-0.35, 0, 0.02]}}}
initial:
  - add(Kf, free(gantry), free(other), lies(rod))
  - forall(robot r) add(Kf, not holds(r, rod))
goal: ["K(at(rod, shelf))"]
"""


def giving_gantries(folder: Path) -> Problem:
    """The problem in which `gantry` takes `rod`, gives it to `other`, and that puts it onto a shelf.

    Args:
        folder: where the files are written.
    """
    scene = SCENE.format(epsilon=0.01, robots="", more="")
    first = scene[scene.index("  gantry:\n") : scene.index("models:\n")]
    other = first.replace("  gantry:\n", "  other:\n", 1).replace("[0, 0, 1.0]", f"[{APART}, 0, 1.0]")
    models = scene[scene.index("    placements:\n") : scene.index("objects:\n")]
    grasps = "".join(
        GRASP.format(name=f"by_{robot}", robot=robot, end=end)
        for robot, end in (("gantry", "one_end"), ("other", "other_end"))
    )
    rest = scene[scene.index("objects:\n") :].replace("[-0.3, 0, 0.09]", f"[{APART + 0.3}, 0, 0.09]")
    rest = rest.replace("box: [0.2, 0.2, 0.2]", "box: [0.2, 0.5, 0.2]")
    text = scene[: scene.index("robots:\n")] + "robots:\n" + first + other + "models:\n" + BAR + grasps + models
    (folder / "gantry.urdf").write_text(ROBOT)
    (folder / "scene.yaml").write_text(text + rest)
    (folder / "domain.yaml").write_text(DOMAIN)
    path = folder / "problem.yaml"
    path.write_text(PROBLEM)
    return load_problem(path)
