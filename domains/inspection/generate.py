"""INSPECTION with n boxes, of which the second stands in a bin; the panel stands beside it, or covers the bin."""

import kabo

NUMBERS = ("one_box", "two_boxes", "three_boxes")
POSITIONS = ((-0.1, 0.22), (-0.02, 0.0), (-0.1, -0.22))  # on the table [m]
UPRIGHT = "{frame: table, position: [-0.19, 0, 0.14], rpy: [0, -90 deg, 0]}"
COVER = "{frame: table, position: [-0.02, 0, 0.09]}"

PROBLEM = """\
problem: inspection_{name}
domain: {home}domain.yaml
scene: {home}scene.yaml
objects:
  robot: [arm]
  box: [{names}]
  panel: [panel]
  tray: [tray_of_screws, tray_of_nuts]
  spot: [aside]
bodies:
{bodies}
  panel: {{model: panel, pose: {pose}}}
initial:
  - add(Kf, empty_gripper(arm))
  - add(Kf, tray_for(screws) = tray_of_screws, tray_for(nuts) = tray_of_nuts)
goal:
  - forall(box b) K(sorted(b))
"""


def problem(n: int, home: str = "", covered: bool = False) -> str:
    """The text of a problem file with n boxes; `home` leads from its folder to this one.

    Raises:
        kabo.InputError: no box, or more than the table has room for.
    """
    if not 1 <= n <= len(POSITIONS):
        message = f"INSPECTION takes 1 to {len(POSITIONS)} boxes, not {n}"
        raise kabo.InputError([kabo.Diagnostic(__file__, 1, 1, message, None)])
    boxes = [f"box_{k}" for k in range(1, n + 1)]
    bodies = [
        f"  {name}: {{model: box, pose: {{frame: table, position: [{x:g}, {y:g}, 0.045]}}}}"
        for name, (x, y) in zip(boxes, POSITIONS, strict=False)
    ]
    name = NUMBERS[n - 1] + ("_covered" if covered else "")
    pose = COVER if covered else UPRIGHT
    return PROBLEM.format(name=name, home=home, names=", ".join(boxes), bodies="\n".join(bodies), pose=pose)
