"""BIMANUAL CIRCULAR REARRANGE with n objects in a row: each goes to where the next one stands [K Table 6.1].

The row has room for six; more objects make a problem without a scene, for the search alone.
"""

import kabo

MOST = 6
FIRST, LAST = 0.64, -0.64  # where the row begins and ends, along the table [m]
ACROSS = (0.16, 0.30)  # in turns, so that hands find room between neighbours [m]
HALF_THICKNESS = 0.02
PLACE = "box: [0.10, 0.10, 0.4]"

PROBLEM = """\
problem: circular_rearrange_n{n}
domain: {home}domain.yaml
{scene}objects:
  robot: [left, right]
  item: [{items}]
  location: [{locations}]
{bodies}initial:
  - add(Kf, hand_empty(left), hand_empty(right))
  - forall(item o) add(Kf, not grasped(o))
  - add(Kf, {start})
goal:
{goal}
"""


def problem(n: int, home: str = "") -> str:
    """The text of a problem file with n objects; `home` leads from its folder to this one.

    Raises:
        kabo.InputError: fewer than two objects.
    """
    if n < 2:
        text = f"CIRCULAR REARRANGE takes 2 objects or more, not {n}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, text, None)])
    numbers = range(1, n + 1)
    return PROBLEM.format(
        n=n,
        home=home,
        scene=f"scene: {home}scene.yaml\n" if n <= MOST else "",
        items=", ".join(f"o{k}" for k in numbers),
        locations=", ".join(f"loc_{k}" for k in numbers),
        bodies=_things(n) if n <= MOST else "",
        start=", ".join(f"at_location(o{k}, loc_{k})" for k in numbers),
        goal="\n".join(f"  - K(at_location(o{k}, loc_{k % n + 1}))" for k in numbers),
    )


def _things(n: int) -> str:
    """The objects, and the places where they stand at first."""
    places = [(ACROSS[k % 2], FIRST + (LAST - FIRST) * k / (n - 1)) for k in range(n)]
    bodies = [
        f"  o{k}: {{model: bottle, pose: {{frame: table, position: [{x:.3f}, {y:.3f}, {HALF_THICKNESS}]}}}}"
        for k, (x, y) in enumerate(places, 1)
    ]
    regions = [
        f"  loc_{k}: {{{PLACE}, pose: {{frame: table, position: [{x:.3f}, {y:.3f}, 0.19]}}, support: table}}"
        for k, (x, y) in enumerate(places, 1)
    ]
    return "\n".join(["bodies:", *bodies, "regions:", *regions, ""])
