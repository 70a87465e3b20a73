"""The figures about a plan's trajectories that the report tells: the greatest share of each limit, and of deviations."""

from dataclasses import dataclass, field

from kabo.verify.trajectory_report import GreatestDeviation, LimitUse, TrajectoryReport


@dataclass
class TrajectoryFigures:
    """The greatest shares and deviations so far, and how many segments have a trajectory."""

    uses: dict[str, LimitUse] = field(default_factory=dict)
    deviation: GreatestDeviation | None = None
    followed: int = 0
    without: int = 0

    def share(self, kind: str) -> float:
        """The greatest share of a kind of limit so far; 0 if none is known."""
        return self.uses[kind].share if kind in self.uses else 0.0

    def use(self, use: LimitUse) -> None:
        """Keeps a use of a limit if it is the greatest of its kind."""
        if use.share > self.share(use.kind):
            self.uses[use.kind] = use

    def deviate(self, found: GreatestDeviation) -> None:
        """Keeps a deviation if it is the greatest."""
        if self.deviation is None or found.value > self.deviation.value:
            self.deviation = found

    def notes(self) -> list[str]:
        """A note if no segment has a trajectory, so that velocities jump at way points."""
        if self.followed or not self.without:
            return []
        return [
            "the plan has no trajectories (format kabo-plan/1): between way points velocities were taken as constant, "
            "which no controller follows exactly; `kabo solve` makes plans with trajectories"
        ]

    def report(self) -> TrajectoryReport | None:
        """The report; None if no segment has a trajectory."""
        if not self.followed:
            return None
        return TrajectoryReport(self.followed, tuple(self.uses.values()), self.deviation)
