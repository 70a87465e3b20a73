"""WAITER with n cups on the guests' table, of which nobody knows whether they are empty.

The table has room for four; more cups make a problem without a scene, for the search alone.
"""

import kabo

NUMBERS = ("one", "two", "three", "four")
POSITIONS = ((0.10, 0.20), (-0.10, -0.25), (-0.10, 0.25), (0.10, -0.15))  # on the table [m]
HEIGHT = 0.4

PROBLEM = """\
problem: waiter_{number}_cups
domain: {home}domain.yaml
{scene}objects:
  robot: [waiter]
  cup: [{names}]
{bodies}initial:
  - add(Kf, hand_empty(waiter))
  - forall(cup o) add(Kf, at_location(o, guests))
goal:
  - forall(cup o) Kw(empty_cup(o))
  - >
    forall(cup o) ((K(at_location(o, counter)) and K(empty_cup(o)))
                   xor (K(at_location(o, guests)) and K(not empty_cup(o))))
"""


def problem(n: int, home: str = "") -> str:
    """The text of a problem file with n cups; `home` leads from its folder to this one.

    Raises:
        kabo.InputError: no cup.
    """
    if n < 1:
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, f"WAITER takes 1 cup or more, not {n}", None)])
    cups = [f"cup_{k}" for k in range(1, n + 1)]
    standing = n <= len(POSITIONS)
    bodies = "".join(f"{_body(name, *at)}\n" for name, at in zip(cups, POSITIONS, strict=False))
    return PROBLEM.format(
        number=NUMBERS[n - 1] if standing else n,
        home=home,
        scene=f"scene: {home}scene.yaml\n" if standing else "",
        names=", ".join(cups),
        bodies=f"bodies:\n{bodies}" if standing else "",
    )


def _body(name: str, x: float, y: float) -> str:
    return f"  {name}: {{model: cup, pose: {{frame: guests_table, position: [{x:.2f}, {y:.2f}, {HEIGHT}]}}}}"
