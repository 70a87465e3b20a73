"""Budgets of a run in seconds, memory and samples, and the flag that says that one of them is spent.

A budget only cuts a run off: what was decided before does not depend on the clock or on the memory.
"""

import os
from collections.abc import Callable
from math import inf
from pathlib import Path
from time import clock_gettime, perf_counter
from typing import Literal

from kabo.errors import CutOff

Spent = Literal["expansions", "samples", "time", "memory"]

DEFAULT_SHARE = 0.5  # of the memory of the machine, or of its control group
LEAST_DEFAULT = 1 << 30  # bytes
MEMORY_POLL_S = 0.05  # between two looks at the memory, which take longer than those at the clock
TOLD_EVERY_S = 0.1  # at least, between two calls of `told`
CLOCK_BOOTTIME = 7  # of Linux: the clock of the times at which processes started
_GROUPS = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")


class StopFlag:
    """A flag that is set once a run must stop, and then stays set; `spent` names the budget that was spent first.

    Args:
        seconds: the time limit, counted from the creation of the flag [s]; may be infinite.
        memory: the bytes that this process may hold; may be infinite.
        cancelled: called at each check; if it returns true, the run ends as if its time were spent.
    """

    def __init__(
        self, seconds: float = inf, memory: float = inf, cancelled: Callable[[], bool] | None = None
    ) -> None:
        self.began = perf_counter()
        self.seconds, self.memory, self.cancelled = seconds, memory, cancelled
        self.reserve = 0.0  # of the seconds, at their end: for what is to be said if nothing was found
        self.samples: Callable[[], bool] | None = None  # whether too many were drawn; None before any can be drawn
        self.told: Callable[[], None] | None = None  # called at a look, at most ten times a second
        self.spent: Spent | None = None
        self.interrupted = False  # somebody asked to stop
        self._look = self._tell = self.began

    def __call__(self) -> bool:
        """Whether to stop."""
        if self.spent is None:
            now = perf_counter()
            if self.told is not None and now >= self._tell:
                self._tell = now + TOLD_EVERY_S
                self.told()
            if self.cancelled is not None and self.cancelled():
                self.spent, self.interrupted = "time", True
            elif now - self.began > self.seconds - self.reserve:
                self.spent = "time"
            elif self.samples is not None and self.samples():
                self.spent = "samples"
            elif self.memory < inf and now >= self._look:
                self._look = now + MEMORY_POLL_S
                self.spent = "memory" if resident_bytes() > self.memory else None
        return self.spent is not None

    def seconds_left(self) -> float | None:
        """The seconds that are left; None without a limit."""
        return None if self.seconds == inf else max(0.0, self.seconds - (perf_counter() - self.began))

    def timely(self) -> "StopFlag":
        """A new flag with the same time and memory limits and start, but no reserve, and no limit on samples."""
        flag = StopFlag(self.seconds, self.memory, self.cancelled)
        flag.began, flag.told = self.began, self.told
        return flag

    def look(self) -> None:
        """Checks that the run may go on.

        Raises:
            CutOff: the run must stop.
        """
        if self():
            raise CutOff


def process_began() -> float:
    """The start of this process on the clock of `perf_counter` [s]; the time now if that is unknown."""
    now = perf_counter()
    try:
        ticks = int(Path("/proc/self/stat").read_text().rpartition(")")[2].split()[19])
        lived = clock_gettime(CLOCK_BOOTTIME) - ticks / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError, IndexError):
        return now
    return now - max(0.0, lived)


def resident_bytes(process: int | None = None) -> int:
    """The memory of a process (None: this one) [bytes]; 0 if it has ended, or the system does not report it."""
    try:
        pages = Path(f"/proc/{process or 'self'}/statm").read_text().split()[1]
    except (OSError, IndexError):
        return 0
    return int(pages) * os.sysconf("SC_PAGE_SIZE")


def held_bytes(process: int, enough: float) -> float:
    """The memory of a process and its children together [bytes], with shared memory counted once.

    Counting shared memory takes a while, so it is done only if the plain sum is above `enough`.
    """
    processes = [process]
    for each in processes:  # grows while it is read
        try:
            processes += map(int, Path(f"/proc/{each}/task/{each}/children").read_text().split())
        except (OSError, ValueError):
            continue
    total = sum(map(resident_bytes, processes))
    return total if total <= enough or len(processes) == 1 else sum(map(_proportional_bytes, processes))


def _proportional_bytes(process: int) -> int:
    """The memory of a process, of shared memory its part only [bytes]."""
    try:
        lines = Path(f"/proc/{process}/smaps_rollup").read_text().splitlines()
        return sum(1024 * int(line.split()[1]) for line in lines if line.startswith("Pss:"))
    except (OSError, ValueError, IndexError):
        return 0


def default_memory() -> float:
    """The default memory limit [bytes]: half the memory of the machine or control group; infinite if unknown."""
    found = [] if (machine := _machine_bytes()) is None else [machine]
    for path in _GROUPS:
        try:
            found.append(int(Path(path).read_text()))
        except (OSError, ValueError):  # no such group, or it has no limit
            continue
    return max(LEAST_DEFAULT, DEFAULT_SHARE * min(found)) if found else inf


def _machine_bytes() -> int | None:
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError):
        return None
