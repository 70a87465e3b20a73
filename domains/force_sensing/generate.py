"""FORCE SENSING with n containers in two rows on one table, and room for n and little more on the other."""

import kabo

MOST = 10
CELL = 0.15  # what a cup of 0.068 m and the fingers around it need [m]
SINGLE = 0.13  # a region for one: less than twice as wide as the cup [m]
ROWS = (-0.07, 0.08)  # of cups on the source table, towards the arm and away from it [m]
TABLE_HEIGHT = 0.4

PROBLEM = """\
problem: force_sensing_n{n}
domain: {home}domain.yaml
scene: {home}scene.yaml

objects:
  robot: [arm]
  container: [{names}]

bodies:
{bodies}

regions:
  target:                                      # room for {n}, and the fingers that put them there
    box: [{depth:.2f}, {width:.2f}, 0.3]
    pose: {{frame: target_table, position: [0, 0, 0.52]}}
    support: target_table

initial:
  - add(Kf, empty_gripper(arm))
  - forall(container o) add(Kf, not removed(o), not grasped(arm, o))

goal:
  - K(empty_gripper(arm))
  - forall(container o) K(removed(o))
"""


def problem(n: int, home: str = "") -> str:
    """The text of a problem file with n cups; `home` leads from its folder to this one.

    Raises:
        kabo.InputError: more cups than the tables have room for.
    """
    if not 1 <= n <= MOST:
        message = f"FORCE SENSING takes 1 to {MOST} containers, not {n}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, "the tables have room for ten")])
    cups = [f"cup_{k}" for k in range(1, n + 1)]
    bodies = "\n".join(_body(name, index) for index, name in enumerate(cups))
    depth, width = _room(n)
    return PROBLEM.format(n=n, home=home, names=", ".join(cups), bodies=bodies, depth=depth, width=width)


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
