"""When bodies were seen last: one that is not seen for some time while somebody looks may be anywhere.

While nobody looks, as when a sensor measures or a plan is made, robots' clocks go on; of such a time only the beginning
counts. So looks count that are few because the machine is busy, and a body that they do not see is gone in the end.
"""

from collections.abc import Iterable, Iterator

GONE_AFTER = 1.0  # [s] after which a body that is not seen may be anywhere
LOST_PICTURES = 3.0  # of a camera that is slower: so many are waited for
WATCH_RATE = 100.0  # [Hz], how often is looked
MISSED_LOOKS = 10.0  # the most that count in a row


class Sightings:
    """When each body was seen last, on the clock of robots; it is kept from one plan to the next.

    Args:
        bodies: all that a camera should see. A sensor that has never seen anything is no camera: then nothing is gone.
        rate: how often is looked while somebody does [Hz].
        picture: the time between two pictures of the camera [s].
    """

    def __init__(self, bodies: Iterable[str] = (), rate: float = WATCH_RATE, picture: float = 0.0) -> None:
        self._gone_after = max(GONE_AFTER, LOST_PICTURES * picture)  # [s]
        self._bodies, self._pause = tuple(bodies), MISSED_LOOKS / rate  # [s]
        self._seen_at: dict[str, float] = {}  # [s]
        self._looked: float | None = None  # the last look [s]

    def __iter__(self) -> Iterator[str]:
        """The bodies that a camera should see."""
        return iter(self._seen_at)

    def saw(self, seen: Iterable[str], time: float) -> None:
        """Takes a look into account: the bodies that are seen at a time [s]."""
        pause = 0.0 if self._looked is None else time - self._looked
        if pause > self._pause:
            self._seen_at = {name: last + pause - self._pause for name, last in self._seen_at.items()}
        self._looked, found = time, dict.fromkeys(seen, time)
        if found and not self._seen_at:
            self._seen_at = dict.fromkeys(self._bodies, time)
        self._seen_at.update(found)

    def gone(self, time: float) -> tuple[str, float] | None:
        """The first body that has not been seen for too long, and for how long somebody has looked [s]."""
        unseen = ((name, time - last) for name, last in self._seen_at.items() if time - last > self._gone_after)
        return next(unseen, None)
