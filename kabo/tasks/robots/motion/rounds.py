"""Paths along a route with rounds of some shares of the greatest, and what is not proven of them."""

import numpy as np

from kabo.arrays import Array
from kabo.motion import Timed, rounded_path
from kabo.tasks.robots.motion.routes import Refused, Route


class Rounds:
    """Judges paths by the shares (m,) of their rounds; of the last ones it keeps the path, and what a look at it said.

    Args:
        route: its corners are rounded.
        within: how far the path may pass by its corners [rad, L2].
        chord: how far chords of a round may be from it [rad, L2].
    """

    def __init__(self, route: Route, within: float, chord: float) -> None:
        self._route, self._within, self._chord = route, within, chord
        self._shares: Array | None = None
        self._looked: tuple[Refused | None] | None = None

    def _path(self, shares: Array) -> tuple[Timed, Array]:
        if self._shares is None or not np.array_equal(shares, self._shares):
            self._shares, self._looked = shares, None
            self._made = rounded_path(
                self._route.corners,
                deviation=self._within,
                shares=shares,
                chord=self._chord,
                slopes=self._route.slopes,
            )
        return self._made

    def looked_at(self, shares: Array) -> Refused | None:
        """What is surely not proven, by a cheap look."""
        path = self._path(shares)[0]
        if self._looked is None:
            self._looked = (self._route.looked_at(path),)
        return self._looked[0]

    def judged(self, shares: Array) -> Refused | None:
        """What is not proven."""
        found = self.looked_at(shares) or self._route.proven(self._path(shares)[0])
        return found if isinstance(found, Refused) else None

    def bending(self, shares: Array, refused: Refused) -> list[int]:
        """The corners whose rounds bend the path most where it is refused."""
        path, trims = self._path(shares)
        return self._route.bending(path, trims, refused.spans)
