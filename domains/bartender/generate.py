"""BARTENDER with n bottles: the first two out of reach of `right`, the others where it can take them.

The dishwasher has room for four; more bottles make a problem without a scene, for the search alone.
"""

import kabo

NUMBERS = ("one", "two", "three", "four")
POSITIONS = ((0.20, 0.62), (0.28, 0.44), (0.20, 0.02), (0.10, -0.30))  # on the table [m]
MIDDLE_OF_TABLE = (0.025, -0.07)
HALF_THICKNESS = 0.02

PROBLEM = """\
problem: bartender_{number}_bottles
domain: {home}domain.yaml
{scene}objects:
  robot: [left, right]
  bottle: [{names}]
{bodies}initial:
  - add(Kf, hand_empty(left), hand_empty(right))
  - forall(bottle o) add(Kf, not grasped(o))
goal:
  - forall(bottle o) Kw(empty_bottle(o))        # or a bottle that nobody looked at might be washed with the others
  - >
    forall(bottle o) ((K(at_location(o, dishwasher)) and K(not grasped(o)))
                      xor K(not empty_bottle(o)))
"""


def problem(n: int, home: str = "") -> str:
    """The text of a problem file with n bottles; `home` leads from its folder to this one.

    Raises:
        kabo.InputError: no bottle.
    """
    if n < 1:
        raise kabo.InputError(
            [kabo.Diagnostic(__file__, 1, 1, f"BARTENDER takes 1 bottle or more, not {n}", None)]
        )
    bottles = [f"bottle_{k}" for k in range(1, n + 1)]
    standing = n <= len(POSITIONS)
    bodies = "".join(f"{_body(name, *at)}\n" for name, at in zip(bottles, POSITIONS, strict=False))
    return PROBLEM.format(
        number=NUMBERS[n - 1] if standing else n,
        home=home,
        scene=f"scene: {home}scene.yaml\n" if standing else "",
        names=", ".join(bottles),
        bodies=f"bodies:\n{bodies}" if standing else "",
    )


def _body(name: str, x: float, y: float) -> str:
    position = f"[{x - MIDDLE_OF_TABLE[0]:.3f}, {y - MIDDLE_OF_TABLE[1]:.3f}, {HALF_THICKNESS}]"
    return f"  {name}: {{model: bottle, pose: {{frame: table, position: {position}}}}}"
