"""The budget of epsilon: how the promised accuracy is divided among sources of error [K Def. 1, Table 4.1].

Both sides of the collision predicate, for two bodies whose enclosing parts stick out by e_a, e_b <= `geometry`:

- "free" is said when the parts (or the parts' swept volumes) are proven farther apart than `clearance`.
- "hit" at a configuration is said when the parts are at most `clearance` + `numeric` apart, hence the bodies at most
  e_a + e_b + clearance + numeric < epsilon.
- "hit" on a segment is said when a pose brings the parts to epsilon - e_a - e_b or nearer, or when two hulls of
  swept parts, whose points lie within `spread` of the true swept parts, are not proven apart and
  spread + clearance + numeric + e_a + e_b <= epsilon; `sweep` is what remains for `spread` in the worst case.
"""

from dataclasses import dataclass

from kabo.options import LARGEST_EPSILON as LARGEST
from kabo.options import SMALLEST_EPSILON as SMALLEST

# [m] of `numeric`: rounding of a gap (at most 2e-10, asserted at load) and of world vertices
LOWER_NUMERIC = 4e-10


@dataclass(frozen=True)
class Budget:
    """The shares of epsilon [m]."""

    geometry: float  # how far the enclosing parts of ONE body may stick out; counts twice, for two bodies
    sweep: float  # how far the hulls of moving parts may stick out of their swept volumes, both together
    clearance: float  # the distance of the enclosing parts that "free" guarantees
    numeric: float = 1e-9  # rounding, and where the search for an axis stops, with a safety factor
    shared: float | None = None  # the epsilon whose shares these are; their sum is another float than 0.005

    @property
    def epsilon(self) -> float:
        """The promised accuracy [m]: bodies at least this far apart are reported free."""
        if self.shared is not None:
            return self.shared
        return 2 * self.geometry + self.sweep + self.clearance + self.numeric

    @property
    def margin(self) -> float:
        """The value that a computed gap must exceed before "free" is reported [m]."""
        return self.clearance + LOWER_NUMERIC

    @classmethod
    def share(cls, epsilon: float) -> "Budget":
        """The default budget of an epsilon: 0.4 of it for each body, a tenth for sweeps, a tenth as clearance.

        Sweeps get little, since the adaptive check makes a small share almost free, while a larger share for
        geometry saves vertices.

        Raises:
            ValueError: `epsilon` is not between a micrometre and 0.3 m.
        """
        if not SMALLEST <= epsilon <= LARGEST:
            raise ValueError(f"epsilon must lie between {SMALLEST:g} and {LARGEST:g} m, but is {epsilon:g} m")
        numeric = 1e-9
        return cls(0.4 * epsilon, 0.1 * epsilon, 0.1 * epsilon - numeric, numeric, shared=epsilon)
