"""What `kabo robot` found, for people, in a few lines."""

from collections.abc import Iterator

from kabo.displays import counted
from kabo.geometry_server.robot_models.model import RobotModel

MAX_TOLD = 4  # joints of a hand, pairs that touch: a hand of five fingers has dozens; the scene lists them all


def robot_summary(model: RobotModel) -> Iterator[str]:
    """The lines that tell what was found, and what the user should look at."""
    robot, gripper = model.robot, model.gripper
    shaped = [link for link in robot.links.values() if link.elements]
    visual = f", of {counted(len(model.visual), 'link')} the visual one" if model.visual else ""
    yield f"{model.name}: {counted(len(shaped), 'link')} with geometry{visual}"
    yield f"  plans {counted(len(model.hand.arm), 'joint')}: {', '.join(model.hand.arm)}"
    if gripper is None:
        yield f"  no gripper (a scene can mount one); tool frame {model.hand.tool}: check that its z axis points out"
    elif gripper.opening is None:
        joints = ", ".join(model.hand.joints[:MAX_TOLD]) + (", …" if len(model.hand.joints) > MAX_TOLD else "")
        yield f"  gripper {joints}: not measured, {gripper.unmeasured}"
    else:
        opened, closed = (f"{round(1000.0 * gap, 1) + 0.0:g}" for gap in gripper.opening)
        yield f"  gripper {', '.join(model.hand.joints)}: {closed} to {opened} mm; tool frame {model.hand.tool}"
    if model.home is None:
        yield "  home: none found without self-collision"
    else:
        yield f"  home: free of itself, {1000.0 * model.margin:.3g} mm and more between links"
    for pair in model.always[:MAX_TOLD]:
        yield f"  {pair.first} and {pair.second} touch {pair.when}: allowed"
    if len(model.always) > MAX_TOLD:
        more = counted(len(model.always) - MAX_TOLD, "more pair")
        yield f"  {more} may touch; all are in `allowed_contacts` of the scene"
    for (first, second), share in list(model.often.items())[:MAX_TOLD]:
        yield f"  {first} and {second} touch at {share:.0%} of configurations: if only their shapes do, allow it"
    for why, links in model.hull_reasons.items():
        yield f"  taken as {counted(len(links), 'hull')}, {why}: {', '.join(links)}"
    if model.others:
        yield f"  other arms stand still; choose one by --tip: {', '.join(each.tool for each in model.others)}"
