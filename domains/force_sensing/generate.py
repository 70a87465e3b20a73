"""FORCE SENSING with n containers in two rows on one table, and room for n and little more on the other.

The tables have room for ten; more containers make a problem without a scene, for the search alone.
"""

import kabo

MOST = 10
CELL = 0.15  # what a cup of 0.068 m and the fingers around it need [m]
SINGLE = 0.13  # a region for one: less than twice as wide as the cup [m]
ROWS = (-0.07, 0.08)  # of cups on the source table, towards the arm and away from it [m]
TABLE_HEIGHT = 0.4

PROBLEM = """\
problem: force_sensing_n{n}
domain: {home}domain.yaml
{scene}
objects:
  robot: [arm]
  container: [{names}]

{bodies}initial:
  - add(Kf, empty_gripper(arm))
  - forall(container o) add(Kf, not removed(o), not grasped(arm, o))

goal:
  - K(empty_gripper(arm))
  - forall(container o) K(removed(o))
"""
BODIES = """\
bodies:
{bodies}

regions:
  target:                                      # room for {n}, and the fingers that put them there
    box: [{depth:.2f}, {width:.2f}, 0.3]
    pose: {{frame: target_table, position: [0, 0, 0.52]}}
    support: target_table

"""


def problem(n: int, home: str = "") -> str:
    """The text of a problem file with n cups; `home` leads from its folder to this one.

    Raises:
        kabo.InputError: no cup.
    """
    if n < 1:
        message = f"FORCE SENSING takes 1 container or more, not {n}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, None)])
    cups = [f"cup_{k}" for k in range(1, n + 1)]
    if n > MOST:
        return PROBLEM.format(n=n, home=home, scene="", names=", ".join(cups), bodies="")
    scene = f"scene: {home}scene.yaml\n"
    return PROBLEM.format(n=n, home=home, scene=scene, names=", ".join(cups), bodies=_bodies(n, cups))


def _bodies(n: int, cups: list[str]) -> str:
    depth, width = _room(n)
    lines = "\n".join(_body(name, index) for index, name in enumerate(cups))
    return BODIES.format(n=n, bodies=lines, depth=depth, width=width)


def _room(n: int) -> tuple[float, float]:
    """Depth and width of the region for n cups [m]: one row of cells for two, two rows for more."""
    if n == 1:
        return SINGLE, SINGLE
    rows = 1 if n == 2 else 2
    return rows * CELL, -(-n // rows) * CELL


def _body(name: str, index: int) -> str:
    row, column = index % 2, index // 2
    across = (0.0, -1.0, 1.0, -2.0, 2.0)[column] * CELL
    return (
        f"  {name}: {{model: cup, pose: {{frame: source_table, "
        f"position: [{ROWS[row]}, {across:.2f}, {TABLE_HEIGHT}]}}}}"
    )
