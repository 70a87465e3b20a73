"""What verification found out about the trajectories of a plan: how much of each limit they use, how far they deviate."""

from dataclasses import asdict, dataclass
from typing import Any

EXACT = 1e-9  # [rad or m] rounding in plan files


@dataclass(frozen=True)
class LimitUse:
    """The greatest share of one kind of limit that any trajectory uses, and where.

    `kind` is `velocity`, `acceleration`, `jerk`, or `grip` (the force on what is held); `what` is `robot.joint`, or
    the object that is held; `value` and `limit` are in rad or m and s, or in newtons.
    """

    kind: str
    share: float
    value: float
    limit: float
    what: str
    node: str
    time: float

    def __str__(self) -> str:
        """`jerk 99.2 % (left.elbow, n3 at 1.250 s)`."""
        return f"{self.kind} {100 * self.share:.4g} % ({self.what}, {self.node} at {self.time:.3f} s)"


@dataclass(frozen=True)
class GreatestDeviation:
    """The greatest distance of a joint from its proven path [rad or m], and where."""

    value: float
    joint: str
    node: str
    time: float


@dataclass(frozen=True)
class TrajectoryReport:
    """The number of trajectories, the greatest use of each kind of limit, and the greatest deviation."""

    segments: int
    uses: tuple[LimitUse, ...]
    deviation: GreatestDeviation | None = None

    def lines(self) -> list[str]:
        """The lines of the report."""
        lines = [f"limits used at most: {', '.join(map(str, self.uses))}"] if self.uses else []
        if self.deviation is not None:
            own = self.deviation
            if own.value <= EXACT:
                return [*lines, "the trajectories follow the proven paths exactly"]
            where = f"{own.joint}, {own.node} at {own.time:.3f} s"
            lines.append(f"greatest deviation from the proven paths: {own.value:.3g} rad or m ({where})")
        return lines

    def to_dict(self) -> dict[str, Any]:
        """The figures as JSON values."""
        return {
            "segments": self.segments,
            "limits_used": {use.kind: asdict(use) for use in self.uses},
            "deviation": None if self.deviation is None else asdict(self.deviation),
        }
