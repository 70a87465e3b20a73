"""Whether the changes of the scene in a report say what its segments do: programs may carry out the one or the other."""

from collections import Counter
from collections.abc import Iterator

from kabo.tasks.files.report_form import ChangeReport, MotionReport, SegmentReport

TIME_TOLERANCE_S = 1e-6  # between the time of a change and the end of its segment
# Attach or detach, the object, and the link or body that takes it or the robot that lets it go.
Event = tuple[str, str, str]


def contradiction(motion: MotionReport) -> str | None:
    """What the changes of a motion and its segments say differently, as a sentence; None if they agree.

    Reports of old formats have no changes, and so no contradiction.
    """
    changes, segments = motion["changes"], motion["segments"]
    if not changes:
        return None
    for number, segment in enumerate(segments):
        here = [each for each in changes if each["segment"] == number]
        ends = segment["times"][-1]
        for each in here:
            if abs(each["time"] - ends) > TIME_TOLERANCE_S:
                return f"{each['change']} has the time {each['time']:.3f} s, but segment {number} ends at {ends:.3f} s"
        told, done = Counter(_told(here)), Counter(_done(segment))
        for event in told - done:
            return f"segment {number} {_sentence(event)}, as its changes say, but not the segment"
        for event in done - told:
            return f"segment {number} {_sentence(event)}, as the segment says, but not its changes"
    return None


def _told(changes: list[ChangeReport]) -> Iterator[Event]:
    for each in changes:
        if each["change"] in ("attach", "join"):
            yield "attach", each["object"], each["to"]
        elif each["change"] == "detach":
            yield "detach", each["object"], each.get("of", "")


def _done(segment: SegmentReport) -> Iterator[Event]:
    for each in segment["attach"]:
        yield "attach", each["object"], each["to"]
    for name in segment["detach"]:
        yield "detach", name, segment["robot"]


def _sentence(event: Event) -> str:
    kind, name, other = event
    return f"attaches {name} to {other}" if kind == "attach" else f"lets {name} go from {other or 'nobody'}"
