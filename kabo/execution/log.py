"""The log of a run: one JSON object a line, in the order in which things happened; nothing is left out.

Every record has a `time` [s] on the robots' clock and an `event`; docs/how-to/carry_out.md lists the events. What nothing
limits, a number that is infinite, is null.
"""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import isinf
from typing import Any, TextIO

DECIMALS = 6  # of times, lengths and angles


@dataclass
class Log:
    """The records so far; each is also written to a `file`, at once, if there is one, and told to a `listener`."""

    file: TextIO | None = None
    listener: Callable[[dict[str, Any]], None] | None = None
    records: list[dict[str, Any]] = field(default_factory=list)

    def add(self, time: float, event: str, **more: object) -> None:
        """Adds a record."""
        record = {
            "time": round(time, DECIMALS),
            "event": event,
            **{key: _plain(value) for key, value in more.items()},
        }
        self.records.append(record)
        if self.file is not None:
            self.file.write(json.dumps(record, allow_nan=False) + "\n")
            self.file.flush()
        if self.listener is not None:
            self.listener(record)

    def of(self, event: str) -> Iterator[dict[str, Any]]:
        """The records of one kind of event."""
        return (record for record in self.records if record["event"] == event)


def _plain(value: object) -> object:
    if isinstance(value, float):
        return None if isinf(value) else round(value, DECIMALS) + 0.0
    if isinstance(value, dict):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple, frozenset, set)):
        items = sorted(value) if isinstance(value, (frozenset, set)) else value
        return [_plain(each) for each in items]
    return value
