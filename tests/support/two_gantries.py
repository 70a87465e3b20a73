"""Two gantries side by side, each with a table half, a cube and a shelf of its own: their actions may overlap."""

from pathlib import Path

from kabo.language import Problem, load_problem
from tests.planner.gantry import DOMAIN, PROBLEM, ROBOT, SCENE

APART = 1.2  # [m] along x between the two bases

SECOND_SHELF = f"""\
  other_shelf:
    box: [0.2, 0.2, 0.2]
    pose: {{position: [{-0.3 + APART}, 0, 0.09]}}
    support: table
"""
EVENTS = """\
events:
  lost: {parameters: {r: robot, o: thing}, effects: ["add(Kf, not held(o), free(r))"]}
  moved: {parameters: {o: thing}, effects: ["forall(location l) del(Kf, at(o, l))"]}
"""


def two_gantries(folder: Path, *, events: bool = False) -> Problem:
    """The problem of two gantries that shall bring `cube` and `second` to a shelf each.

    Args:
        folder: where the files are written.
        events: whether the domain says what is known of bodies that have left their hand or their shelf.
    """
    scene = SCENE.format(epsilon=0.01, robots="", more=SECOND_SHELF)
    first = scene[scene.index("  gantry:\n") : scene.index("models:\n")]
    other = first.replace("  gantry:\n", "  other:\n", 1).replace("[0, 0, 1.0]", f"[{APART}, 0, 1.0]")
    (folder / "gantry.urdf").write_text(ROBOT)
    (folder / "scene.yaml").write_text(scene.replace(first, first + other))
    domain = DOMAIN.replace("[shelf]}", "[shelf, other_shelf]}") + (EVENTS if events else "")
    (folder / "domain.yaml").write_text(domain)
    at = {"cube": [0.2, 0.0, 0.02], "second": [0.2 + APART, 0.0, 0.02]}
    bodies = ", ".join(f"{name}: {{model: cube, pose: {{position: {place}}}}}" for name, place in at.items())
    goal = "K(at(cube, shelf)) and K(at(second, other_shelf))"
    text = PROBLEM.format(things="cube, second", bodies=bodies, goal=goal)
    text = text.replace("robot: [gantry]", "robot: [gantry, other]")
    text = text.replace("add(Kf, free(gantry))", "add(Kf, free(gantry), free(other))")
    path = folder / "problem.yaml"
    path.write_text(text)
    return load_problem(path)
