"""Self-collisions of a robot: pairs of links that always touch, and configurations in which none does.

Covers answer first, in microseconds; only pairs and configurations that they leave open are asked of the links'
enclosures, which may take seconds to make.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from kabo.arrays import Array
from kabo.children import never
from kabo.errors import MeshError
from kabo.geometry import Budget
from kabo.geometry_server.answers import GeometryStatistics
from kabo.geometry_server.preparation.enclosures import SceneEnclosures
from kabo.geometry_server.preparation.preparing import Preparing, prepare
from kabo.geometry_server.robot_models.covers import CoverSurroundings
from kabo.geometry_server.robot_models.link_pairs import LinkPair, LinkPairs
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.scene import Scene

DECIMALS = 4  # of joint values that are written [rad or m]
SAMPLES = 2000  # configurations at which a pair must touch before it counts as always touching
FIRST_SAMPLES = 16  # of them, tried first: most pairs are free in one of these
HOME_SAMPLES = 4000  # configurations that are tried as a home
HOME_MARGINS = (0.05, 0.02, 0.01)  # [m] between links of a home, the widest first; then epsilon
OFTEN = 0.1  # share of configurations at which covers meet: for such pairs enclosures are worth their time
TOLD_SAMPLES = 100  # configurations at which links are tried that touch often
TOLD_SHARE = 0.4  # of them at which they touch, and are told: what is left is too little for most tasks
TOLD_JOINTS = 3  # between links that are told; what more joints bring together is seldom a fault of their shapes
FINE_TRIES = 60  # configurations that are tried on the links' enclosures


def rounded_within(values: Array, lower: Array, upper: Array) -> Array:
    """Joint values (…, n), rounded as they are written, within limits (n,)."""
    unit = 10.0**-DECIMALS
    low, high = np.ceil(lower / unit) * unit, np.floor(upper / unit) * unit
    rounded = np.round(np.clip(values, low, high), DECIMALS)
    return np.asarray(np.where(low <= high, rounded, lower))


class UnenclosedError(Exception):
    """Links that have no enclosure, each with the reason."""

    def __init__(self, links: Mapping[str, str]) -> None:
        super().__init__(", ".join(links))
        self.links = dict(links)


class _Chosen(SceneEnclosures):
    """The enclosures of some links alone."""

    def __init__(self, scene: Scene, tolerance: float, chosen: Sequence[str]) -> None:
        super().__init__(scene, tolerance)
        self.chosen = list(chosen)

    @property
    def things(self) -> list[str]:
        """The chosen links."""
        return self.chosen


@dataclass
class SelfContacts:
    """A robot of a scene by itself, asked about its own links; `look` is called now and then, and may raise."""

    scene: Scene
    name: str
    epsilon: float
    look: Callable[[], None] = never
    told: Callable[[Preparing], None] | None = None
    _coarse: dict[float, LinkPairs] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.robot = self.scene.robots[self.name]
        surroundings = SceneSurroundings(self.scene, Budget.share(self.epsilon), False, GeometryStatistics())
        surroundings.look = self.look
        self.fine = LinkPairs(surroundings, self.robot, self.look)

    def coarse(self, clearance: float) -> LinkPairs:
        """The links' covers, free beyond a clearance [m]; from epsilon on their "free" holds for all enclosures."""
        if clearance not in self._coarse:
            self._coarse[clearance] = LinkPairs(CoverSurroundings(self.scene, clearance), self.robot, self.look)
        return self._coarse[clearance]

    def meeting(self, q: Sequence[float], pairs: Sequence[LinkPair] | None = None) -> list[LinkPair]:
        """The pairs of links that may touch at a configuration, of those given or of all."""
        open_pairs = self.coarse(self.epsilon).meeting(q, pairs)
        return [pair for pair in open_pairs if self.fine.meets(pair, q)]

    def _prepare(self, pairs: Iterable[LinkPair]) -> None:
        """Makes the enclosures of the links of pairs, in parallel.

        Raises:
            UnenclosedError: some links have none.
        """
        wanted = dict.fromkeys(f"{self.name}.{link}" for pair in pairs for link in pair)
        chosen = _Chosen(self.scene, self.fine.surroundings.budget.geometry, tuple(wanted))
        chosen.look = self.look
        try:
            prepare(chosen, told=self.told)
        except MeshError as error:
            failed = {}
            for name in wanted:
                link = name.partition(".")[2]
                own = [each for each in error.diagnostics if f'"{link}"' in each.message]
                if own and not all(chosen.known(each) for each in chosen.elements(name)):
                    failed[link] = own[0].message.rpartition('": ')[2]
            if not failed:
                raise
            raise UnenclosedError(failed) from None

    def samples(self, count: int, seed: int = 0) -> Array:
        """Configurations (count, n) between the joints' limits, with the gripper's joints as well."""
        tree = self.robot.tree
        shares = np.random.default_rng(seed).random((count, tree.size))
        return np.asarray(tree.lower + shares * (tree.upper - tree.lower))

    def always(self) -> list[LinkPair]:
        """The pairs that may touch at every one of `SAMPLES` configurations."""
        configurations = self.samples(SAMPLES)
        candidates = self._always_on_covers(configurations)
        self._prepare(candidates)
        return [pair for pair in candidates if self._touches(self.fine, pair, configurations)]

    def _always_on_covers(self, configurations: Array) -> list[LinkPair]:
        covers = self.coarse(self.epsilon)
        candidates = covers.meeting(configurations[0].tolist())
        return [pair for pair in candidates if self._touches(covers, pair, configurations)]

    def often(self, allowed: Iterable[LinkPair]) -> dict[LinkPair, float]:
        """The pairs of links near each other that touch at many configurations, not always, with the share of these.

        Links that touch so often in truth would be of no use: mostly their shapes are too wide, as cylinders on wrists are.
        """
        configurations, covers = self.samples(TOLD_SAMPLES), self.coarse(self.epsilon)
        planned, known = self.robot.planned, {frozenset(pair) for pair in allowed}
        near = [
            pair
            for pair in covers.pairs
            if frozenset(pair) not in known
            and len(between := self.robot.values_between(*pair)) <= TOLD_JOINTS
            and min(between, default=planned) < planned
            and covers.meets_at(pair, configurations).mean() >= TOLD_SHARE
        ]
        self._prepare(near)
        shares = {pair: float(self.fine.meets_at(pair, configurations).mean()) for pair in near}
        return {pair: share for pair, share in shares.items() if share >= TOLD_SHARE}

    def inside_hand(self, configurations: Array) -> list[LinkPair]:
        """The pairs that may touch at one of some configurations (N, n), and that only joints of the gripper move."""
        planned, covers = self.robot.planned, self.coarse(self.epsilon)
        own = [
            pair
            for pair in covers.pairs
            if min(self.robot.values_between(*pair), default=planned) >= planned
            and covers.meets_at(pair, configurations).any()
        ]
        self._prepare(own)
        return [pair for pair in own if self.fine.meets_at(pair, configurations).any()]

    @staticmethod
    def _touches(links: LinkPairs, pair: LinkPair, configurations: Array) -> bool:
        first = links.meets_at(pair, configurations[:FIRST_SAMPLES])
        return bool(first.all()) and bool(links.meets_at(pair, configurations[FIRST_SAMPLES:]).all())

    def free_configuration(
        self, candidates: Iterable[Array], pairs: Sequence[LinkPair], home: Array
    ) -> tuple[Array, float] | None:
        """A configuration without self-collision, and the clearance that its links are proven to have [m]; None if none.

        Args:
            candidates: configurations (n,) that are tried first, in their order.
            pairs: the pairs that are checked.
            home: the middle (n,) about which further ones are sampled, the nearest first.
        """
        given = [np.asarray(each, np.float64) for each in candidates]
        tried = np.concatenate([np.array(given).reshape(-1, self.robot.tree.size), self._around(home)])
        tried = rounded_within(tried, self.robot.tree.lower, self.robot.tree.upper)
        outer = [pair for pair in pairs if not self._in_hand(pair)]
        inner = [pair for pair in pairs if self._in_hand(pair)]
        still = ~self.coarse(self.epsilon).any_meeting(tried, inner)
        for margin in (*HOME_MARGINS, self.epsilon):
            if margin < self.epsilon:
                continue
            free = np.flatnonzero(still & ~self.coarse(margin).any_meeting(tried, outer))
            if len(free):
                return tried[free[0]], margin
        return self._fine_free(tried, pairs)

    def _in_hand(self, pair: LinkPair) -> bool:
        """Whether both links belong to the gripper: no wide margin fits between them."""
        gripper = self.robot.gripper
        own = () if gripper is None else [name.partition(".")[2] for name in gripper.touch_links]
        return pair[0] in own and pair[1] in own

    def _fine_free(self, tried: Array, pairs: Sequence[LinkPair]) -> tuple[Array, float] | None:
        """The first configuration that is free on enclosures: first of the pairs alone whose covers meet often."""
        covers, clearance = self.coarse(self.epsilon), self.fine.surroundings.budget.clearance
        often: dict[LinkPair, int] = {}
        every = tried[:: max(1, len(tried) // FINE_TRIES)]
        for q in every:
            for pair in covers.meeting(q.tolist(), pairs):
                often[pair] = often.get(pair, 0) + 1
        stubborn = [pair for pair, count in often.items() if count > OFTEN * len(every)]
        others = [pair for pair in pairs if pair not in stubborn]
        self._prepare(stubborn)
        apart = ~covers.any_meeting(tried, others)
        for group in (tried[apart], tried[:FINE_TRIES]):
            free = np.flatnonzero(~self.fine.any_meeting(group, stubborn)) if len(group) else ()
            for q in group[free][:FINE_TRIES] if len(group) else ():
                self._prepare(covers.meeting(q.tolist(), pairs))
                if not self.meeting(q.tolist(), pairs):
                    return q, clearance
        return None

    def _around(self, home: Array) -> Array:
        """Configurations (N, n) about a middle, within limits; the later ones farther away, the gripper as it is there."""
        tree, count = self.robot.tree, HOME_SAMPLES
        shares = np.linspace(0.02, 1.0, count)[:, None] ** 0.5
        spread = (self.samples(count, seed=1) - home) * shares
        spread[:, self.robot.planned :] = 0.0
        return np.asarray(np.clip(home + spread, tree.lower, tree.upper))
