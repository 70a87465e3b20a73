"""Whether two bodies are mated as the scene says, and which contact their insertion permits."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kabo.language.scene_description import Mate
from kabo.verify.calls import Call
from kabo.verify.constraints import WORLD, Role
from kabo.verify.contacts import RAISED
from kabo.verify.families import why_not
from kabo.verify.report import Finding
from kabo.verify.surfaces import inverse
from kabo.verify.world import World

Array = npt.NDArray[np.float64]

ASIDE = 2e-3  # [m] how far from the straight way of its insertion a body may be, and beyond its length
TURNED = 0.02  # [rad] how far it may be turned there


@dataclass(frozen=True)
class Fitting:
    """A mate of the scene and the bodies that play its roles."""

    mate: Mate
    moving: str
    fixed: str


def fittings(call: Call, world: World, first: str, second: str) -> list[Fitting]:
    """The mates that two bodies can have, either as the moving one; only the one that the call names, if it does."""
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
    node: str, time: float, call: Call, world: World, pair: tuple[str, str], pose: Callable[[str], Array]
) -> Iterator[Finding]:
    """Two bodies are where one of their mates wants them; `pose` says where a body is, world_T (4, 4)."""
    failures = []
    for fit in fittings(call, world, *pair):
        roles = {
            "moving": world.role(fit.moving, pose(fit.moving)),
            "fixed": world.role(fit.fixed, pose(fit.fixed)),
        }
        reason = why_not(fit.mate.constraints, roles)
        if reason is None:
            return
        failures.append(f"{fit.mate.name}: {reason}")
    text = f"{pair[0]} and {pair[1]} are not put together as any of their mates says"
    yield Finding(node, f"{text} ({'; '.join(failures) or 'none fits'})", time, pair)


def inserting(
    call: Call,
    world: World,
    pair: tuple[str, str],
    places: Sequence[Callable[[str], Array]],
    mated: Callable[[str], Array],
) -> bool:
    """Whether two bodies, wherever they are along a path, are on the straight last way into one of their mates.

    Args:
        call: the call.
        world: the scene.
        pair: the two bodies.
        places: for every way point of the path, where a body is then.
        mated: where a body is when the two are put together.
    """
    return any(
        all(_on_its_way(fit, world, place, mated) for place in places) for fit in fittings(call, world, *pair)
    )


def _on_its_way(fit: Fitting, world: World, now: Callable[[str], Array], mated: Callable[[str], Array]) -> bool:
    fixed_T_now = inverse(now(fit.fixed)) @ now(fit.moving)
    fixed_T_mated = inverse(mated(fit.fixed)) @ mated(fit.moving)
    between = fixed_T_now[:3, 3] - fixed_T_mated[:3, 3]
    cosine = (np.trace(fixed_T_now[:3, :3].T @ fixed_T_mated[:3, :3]) - 1) / 2
    if np.arccos(np.clip(cosine, -1.0, 1.0)) > TURNED:
        return False
    stroke = fit.mate.insertion
    length = float(np.linalg.norm(between))
    if stroke is None:
        return length <= RAISED
    direction = _direction(fit, world, mated)
    aside = between if direction is None else between - (between @ direction) * direction
    return length <= stroke.maximum + ASIDE and float(np.linalg.norm(aside)) <= ASIDE


def _direction(fit: Fitting, world: World, mated: Callable[[str], Array]) -> Array | None:
    """The direction of the insertion (3,) in the frame of the fixed body; None: its feature does not exist."""
    stroke = fit.mate.insertion
    assert stroke is not None
    names = {"moving": fit.moving, "fixed": fit.fixed}
    owner = stroke.along.owner
    role: Role = WORLD if owner not in names else world.role(names[owner], mated(names[owner]))
    found = role.features.get(stroke.along.feature or "")
    if found is None or found.direction is None:
        return None
    result: Array = mated(fit.fixed)[:3, :3].T @ role.world_T[:3, :3] @ np.asarray(found.direction)
    return result / float(np.linalg.norm(result))
