"""How a plan is carried out: how often robots are looked at, and how far off and how late they may be."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from kabo.given import require_flag, require_number

MOST_RATE, LONGEST_DELAY = 1e5, 60.0  # Hz of setpoints and looks; s by which robots follow late


@dataclass(frozen=True)
class ExecutionSettings:
    """How a plan is carried out.

    Attributes:
        watch_rate: how often measurements are compared with the plan [Hz], 100 or more on hardware.
        tracking_error: how far any point of a robot may be off its path, as its maker says [m], or of each robot by
            name; a plan that has less proven clearance where this robot moves is refused.
        despite_margins: whether such a plan is carried out nevertheless.
        log_rate: how often a record `state` is added to the log [Hz]: where everything is; 0: never.
        delay: how late robots follow what is sent, as their maker says [s]; a tenth of a second more is no surprise.
        most_recoveries: how often a run goes on after a surprise.
    """

    watch_rate: float = 100.0
    tracking_error: float | Mapping[str, float] = 0.0
    despite_margins: bool = False
    log_rate: float = 0.0
    most_recoveries: int = 20
    delay: float = 0.0

    def __post_init__(self) -> None:
        """Checks the values.

        Raises:
            ArgumentError: one is no such number.
        """
        require_number("watch_rate", self.watch_rate, above=0.0, most=MOST_RATE, unit="Hz")
        stated = self.tracking_error
        for each in stated.values() if isinstance(stated, Mapping) else (stated,):
            require_number("tracking_error", each, 0.0, unit="m")
        require_flag("despite_margins", self.despite_margins)
        require_number("log_rate", self.log_rate, 0.0, MOST_RATE, unit="Hz")
        require_number("most_recoveries", self.most_recoveries, 0, whole=True)
        require_number("delay", self.delay, 0.0, LONGEST_DELAY, unit="s")

    def tracking_errors(self, robots: Iterable[str]) -> dict[str, float]:
        """The stated tracking error of each robot [m]."""
        stated = self.tracking_error
        if isinstance(stated, float | int):
            return dict.fromkeys(robots, float(stated)) if stated else {}
        return {name: float(stated.get(name, 0.0)) for name in robots}


USUAL = ExecutionSettings()
