"""Checks that two bodies are joined as a mate of the scene requires."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from kabo.arrays import Array
from kabo.language.scene_description import Mate
from kabo.verify.motion.calls import Call
from kabo.verify.motion.contacts.families import why_not
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.report import Finding


@dataclass(frozen=True)
class Fitting:
    """A mate of the scene, and the two bodies in its roles."""

    mate: Mate
    moving: str
    fixed: str


def fittings(call: Call, world: SceneModel, first: str, second: str) -> list[Fitting]:
    """The mates of the scene that can join two bodies, in either assignment of the bodies to the mate's roles.

    If the call names a mate, only that one is considered.
    """
    models = world.models.get(first), world.models.get(second)
    result = []
    for mate in world.scene.mates.values():
        if call.mate not in (None, mate.name):
            continue
        if models == (mate.moving, mate.fixed):
            result.append(Fitting(mate, first, second))
        if models == (mate.fixed, mate.moving):
            result.append(Fitting(mate, second, first))
    return result


def check_mate(
    node: str, time: float, call: Call, world: SceneModel, pair: tuple[str, str], pose: Callable[[str], Array]
) -> Iterator[Finding]:
    """A finding unless two bodies fulfil one of their mates; `pose` gives the pose world_T (4, 4) of a body."""
    failures = []
    for fit in fittings(call, world, *pair):
        roles = {
            "moving": world.role(fit.moving, pose(fit.moving)),
            "fixed": world.role(fit.fixed, pose(fit.fixed)),
        }
        reason = why_not(fit.mate.constraints, roles, fit.mate.tolerance)
        if reason is None:
            return
        failures.append(f"{fit.mate.name}: {reason}")
    text = f"{pair[0]} and {pair[1]} are not put together as any of their mates says"
    yield Finding(node, f"{text} ({'; '.join(failures) or 'none fits'})", time, pair)
