"""Problems that have no plan, each for one reason, made of the shipped domains: what is told of them can be measured.

Each function writes files into a folder and gives the problem's path. Lengths that a test wants are arguments.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

DOMAINS = Path(__file__).resolve().parents[2] / "domains"
Changes = Sequence[tuple[str, str]]


def write(folder: Path, domain: str, problem: str, *, scene: Changes = (), rules: Changes = ()) -> Path:
    """Writes copies of a shipped domain and of its scene with some text replaced, and a problem beside them.

    Raises:
        ValueError: the text to be replaced is not there.
    """
    meshes = DOMAINS.parent / "meshes"
    for name, changes in (("scene.yaml", scene), ("domain.yaml", rules)):
        text = (DOMAINS / domain / name).read_text().replace("../../meshes", str(meshes))
        for old, new in changes:
            if old not in text:
                raise ValueError(f"{name} has no {old!r}")
            text = text.replace(old, new)
        (folder / name).write_text(text)
    path = folder / "problem.yaml"
    path.write_text(problem)
    return path


# --------------------------------------------------------------------------------------------------- stacked blocks
STACKED = """problem: stacked
domain: domain.yaml
scene: scene.yaml
objects: {{robot: [mobile], block: [o1], stack: [stack_1, stack_2, stack_3]}}
bodies:
  o1: {{model: block, pose: {{frame: stack_2, position: [0, 0, {height}]}}}}
{more}
initial:
  - add(Kf, highest(o1), highest(stack_1), highest(stack_3))
  - add(Kf, one_below(o1) = stack_2)
goal:
{goal}
"""
TO_STACK_1 = "  - K(one_below(o1) = stack_1)"
PAD_1 = "stack_1: {model: pad, pose: {position: [0.432, 0.18, 0.005]}}"


def stacked(
    folder: Path, *, more: str = "", goal: str = TO_STACK_1, height: float = 0.025, scene: Changes = ()
) -> Path:
    """A block on one pad that shall stand on another."""
    return write(folder, "stacked", STACKED.format(more=more, goal=goal, height=height), scene=scene)


def too_far(folder: Path, x: float = 1.0) -> Path:
    """The pad stands `x` metres in front of the arm."""
    pad = f"stack_1: {{model: pad, pose: {{position: [{x}, 0.18, 0.005]}}}}"
    return stacked(folder, scene=[(PAD_1, pad)])


def roof(folder: Path) -> Path:
    """A board hangs over the block."""
    return stacked(folder, more="  board: {box: [0.2, 0.2, 0.01], pose: {position: [0.48, 0, 0.15]}}")


def joint_limit(folder: Path, joint: str = "arm_joint_4", degrees: float = 5.0) -> Path:
    """A joint may turn by a few degrees only."""
    limits = f"limits: {{{joint}: [-{degrees} deg, {degrees} deg]}}\n    inverse_kinematics: projection"
    home = [("home: [0, -20 deg, 110 deg, 90 deg, 0]", "home: [0, -20 deg, 110 deg, 0, 0]")]
    return stacked(folder, scene=[("inverse_kinematics: projection", limits), *home])


def floating(folder: Path, gap: float = 0.3) -> Path:
    """The block hangs in the air, above its pad."""
    return stacked(folder, height=0.025 + gap)


FINGERS_REACH = 0.047  # [m] along x to each side of a block that the open hand is about to grasp


def slot(folder: Path, gap: float = 0.0025, epsilon: float = 0.03) -> Path:
    """Two posts leave a gap on the outside of each open finger: wide enough for them, but narrower than epsilon."""
    x = FINGERS_REACH + gap + 0.01
    posts = (
        f"  post_{i}: {{box: [0.02, 0.06, 0.05], pose: {{position: [{0.48 + s * x}, 0, 0.025]}}}}"
        for i, s in ((1, 1), (2, -1))
    )
    return stacked(folder, more="\n".join(posts), scene=[("epsilon: 0.01", f"epsilon: {epsilon}")])


def contradiction(folder: Path) -> Path:
    """The goal wants a block in two places."""
    return stacked(folder, goal="  - K(one_below(o1) = stack_1)\n  - K(one_below(o1) = stack_3)")


# --------------------------------------------------------------------------------------------------------- cups
CUPS = """problem: cups
domain: domain.yaml
scene: scene.yaml
objects:
  robot: [arm]
  container: [{names}]
bodies:
{bodies}
regions:
  target:
    box: {box}
    pose: {{frame: target_table, position: {at}}}
    support: target_table
initial:
  - add(Kf, empty_gripper(arm))
  - forall(container o) add(Kf, not removed(o), not grasped(arm, o){known})
goal:
  - K(empty_gripper(arm))
  - forall(container o) K(removed(o))
"""
ON_TABLE = "{model: cup, pose: {frame: source_table, position: [-0.07, 0.00, 0.4]}}"


def cups(
    folder: Path,
    *,
    bodies: Mapping[str, str] | None = None,
    more: str = "",
    box: Sequence[float] = (0.15, 0.30, 0.3),
    at: Sequence[float] = (0.0, 0.0, 0.52),
    known: str = ", not spillable(o)",
    scene: Changes = (),
    rules: Changes = (),
) -> Path:
    """Cups that shall go from one table to the other."""
    chosen = bodies or {"cup_1": ON_TABLE}
    lines = "\n".join([*(f"  {name}: {text}" for name, text in chosen.items()), *([f"  {more}"] if more else [])])
    text = CUPS.format(names=", ".join(chosen), bodies=lines, box=list(box), at=list(at), known=known)
    return write(folder, "force_sensing", text, scene=scene, rules=rules)


def too_wide_for_the_gripper(folder: Path, scale: float = 1.8) -> Path:
    """A cup that is wider than the gripper opens."""
    return cups(
        folder,
        bodies={
            "cup_1": f"{{model: cup, scale: {scale}, pose: {{frame: source_table, position: [-0.07, 0, 0.4]}}}}"
        },
    )


def region_too_narrow(folder: Path, width: float = 0.05) -> Path:
    """A region that is narrower than the cup."""
    return cups(folder, box=(width, 0.30, 0.3))


def region_too_low(folder: Path, height: float = 0.082) -> Path:
    """A region on the table that is lower than the cup."""
    return cups(folder, box=(0.15, 0.30, height), at=(0.0, 0.0, 0.4 + height / 2))


def flush_region(folder: Path) -> Path:
    """A region that begins where its support ends: there is a plan."""
    return cups(folder, box=(0.15, 0.30, 0.3), at=(0.0, 0.0, 0.55))


def inside_the_plinth(folder: Path) -> Path:
    """The frame of the cup's pose is forgotten: it begins inside the plinth."""
    return cups(folder, bodies={"cup_1": "{model: cup, pose: {position: [0.02, 0.01, 0.25]}}"})


def cup_in_cup(folder: Path) -> Path:
    """Two cups begin in the same place."""
    return cups(folder, bodies={"cup_1": ON_TABLE, "cup_2": ON_TABLE.replace("-0.07, 0.00", "-0.055, 0.01")})


def no_sensing(folder: Path) -> Path:
    """Nobody can find out whether a cup may spill."""
    return cups(
        folder, known="", rules=[("    sense: spillable(o)\n    effects:\n      - add(Kw, spillable(o))\n", "")]
    )


def never_sensed(folder: Path) -> Path:
    """The action that would find out whether a cup may spill is never possible."""
    return cups(folder, known="", rules=[("      - not Kw(spillable(o))\n", "      - K(spillable(o))\n")])


# ------------------------------------------------------------------------------------------------------ bottles
BOTTLES = """problem: bottles
domain: domain.yaml
scene: scene.yaml
objects: {{robot: [left, right], bottle: [{names}]}}
bodies:
{bodies}
initial:
  - add(Kf, hand_empty(left), hand_empty(right))
  - forall(bottle o) add(Kf, not grasped(o))
goal:
  - forall(bottle o) (K(at_location(o, dishwasher)) and K(not grasped(o)))
"""


def bottles(folder: Path, bodies: Mapping[str, str], *, more: str = "", scene: Changes = ()) -> Path:
    """Bottles that shall go into the dishwasher."""
    lines = "\n".join([*(f"  {name}: {text}" for name, text in bodies.items()), *([f"  {more}"] if more else [])])
    return write(folder, "bartender", BOTTLES.format(names=", ".join(bodies), bodies=lines), scene=scene)


def wall_between_arms(folder: Path) -> Path:
    """A wall stands where one arm would hand bottles over to the other."""
    near = "{model: bottle, pose: {frame: table, position: [0.175, 0.690, 0.02]}}"
    far = "{model: bottle, pose: {frame: table, position: [0.075, -0.230, 0.02]}}"
    wall = "wall: {box: [1.6, 0.03, 2.4], pose: {position: [0.0, 0.15, 0.9]}, movable: false}"
    return bottles(folder, {"bottle_1": near, "bottle_4": far}, more=wall)


def bottle_in_bottle(folder: Path) -> Path:
    """Two bottles begin in the same place."""
    first = "{model: bottle, pose: {frame: table, position: [0.075, -0.230, 0.02]}}"
    return bottles(folder, {"bottle_1": first, "bottle_2": first.replace("0.075", "0.105")})
