"""What a command does now, as the waiting are told it: made of phases, of a planner's progress, of preparations."""

from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING

from kabo.phases import Phase

if TYPE_CHECKING:  # they are other rooms' classes, which only some commands load
    from kabo.cli import rooms


@dataclass(frozen=True)
class Doing:
    """What is done now.

    Attributes:
        step: two or three words, such as `searching`; estimates begin anew where it changes.
        text: the whole sentence, with counts.
        fraction: the share that is done, or spent of a budget; None if there is no bound.
        of_budget: whether `fraction` is of a budget, which the work may end long before.
        ends: when the budget of time is spent, on the clock of `perf_counter` [s], which processes share; None: never.
    """

    step: str
    text: str
    fraction: float | None = None
    of_budget: bool = False
    ends: float | None = None

    def share(self, began: float, now: float) -> float | None:
        """The share that is done; of budgets, of that which is spent most, that of time included."""
        if self.ends is None or self.fraction is None:
            return self.fraction
        return min(1.0, max(self.fraction, (now - began) / max(1e-3, self.ends - began)))

    @property
    def said(self) -> str:
        """What was cut off, if it is now: with what is done, if that says how much is not."""
        return self.step if self.fraction is None or self.of_budget else self.text


RESTING = Doing("", "")  # nothing is shown of it


def of_phase(phase: Phase) -> Doing:
    """What a phase says: `checking motions: 34 of 120 motions`."""
    unit = f" {phase.unit}" if phase.unit else ""
    if phase.total:
        text = f"{phase.doing}: {phase.done} of {phase.total}{unit}"
        return Doing(phase.doing, text, min(1.0, phase.done / phase.total))
    return Doing(phase.doing, f"{phase.doing}: {phase.done}{unit}" if phase.done else phase.doing)


def of_progress(progress: "rooms.Progress") -> Doing:
    """What the planner says: `searching: 120 nodes expanded, 12 procedure calls; pick(arm, cup) refused 80 times`."""
    if progress.fraction is not None:
        return Doing("preparing geometry", progress.doing, progress.fraction)
    counts = {"nodes expanded": progress.expanded, "procedure calls": progress.procedure_calls}
    said = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    text = f"{progress.doing}: {said}" if said else progress.doing
    text += f"; {progress.refused}" if progress.refused else ""
    ends = None if progress.seconds_left is None else perf_counter() + progress.seconds_left
    return Doing(progress.doing, text, progress.spent, of_budget=progress.spent is not None, ends=ends)


def of_preparing(state: "rooms.Preparing") -> Doing:
    """What a preparation says: `preparing geometry: 3 of 12 done, not yet r.link5`."""
    return Doing("preparing geometry", str(state), state.fraction)
