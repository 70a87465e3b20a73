"""What is shown of waiting, as text: spans of time, an estimate of what is left, a bar, a line for a pipe."""

from dataclasses import dataclass

from kabo.cli.waiting.doing import Doing

BAR = 24  # cells
FULL, EMPTY, SPINNER = "━", "─", "⠋⠙⠹⠸⠼⠴⠦⠧⠇⠏"
PLAIN_FULL, PLAIN_EMPTY, PLAIN_SPINNER = "#", "-", "|/-\\"
COLOUR, DIM, PLAIN = "\x1b[36m", "\x1b[2m", "\x1b[0m"
SURE_AFTER_S, SURE_SHARE = 2.0, 0.02  # before this much of a step, its end is not estimated


@dataclass(frozen=True)
class Style:
    """What a terminal can show: colours, letters beyond ASCII, and so many columns."""

    colours: bool
    wide: bool
    columns: int


class Estimate:
    """Estimates the seconds that a step still takes, from the share of it that was done since it began."""

    def __init__(self) -> None:
        self._step: str | None = None
        self._began, self._first = 0.0, 0.0

    def left(self, doing: Doing, now: float) -> float | None:
        """The seconds left; None if that cannot be said yet, or at all."""
        if doing.of_budget:
            return None if doing.ends is None else max(0.0, doing.ends - now)
        fraction, step = doing.fraction, doing.step
        if step != self._step or fraction is None or fraction < self._first:
            self._step, self._began, self._first = step, now, fraction or 0.0
            return None
        done, taken = fraction - self._first, now - self._began
        if done < SURE_SHARE or taken < SURE_AFTER_S:
            return None
        return (1.0 - fraction) * taken / done


def span(seconds: float) -> str:
    """A span of time: `8 s`, `2 min 5 s`, `3 h 20 min`."""
    whole = max(0, round(seconds))
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def _ending(doing: Doing, left: float | None) -> str:
    if left is None:
        return ""
    return f", {'at most' if doing.of_budget else 'about'} {span(left)} left"


def piped(doing: Doing, seconds: float, left: float | None) -> str:
    """A line for a pipe or a file: `kabo: checking motions: 3 of 12 motions (25 %); 20 s so far, about 60 s left`."""
    share = "" if doing.fraction is None or doing.of_budget else f" ({100.0 * doing.fraction:.0f} %)"
    return f"kabo: {doing.text}{share}; {span(seconds)} so far{_ending(doing, left)}"


def barred(doing: Doing, share: float | None, seconds: float, left: float | None, style: Style, turn: int) -> str:
    """One row of a terminal: a turning sign, what is done, a bar if there is a bound, and times; never wider than it."""
    spinner = SPINNER if style.wide else PLAIN_SPINNER
    head, times = spinner[turn % len(spinner)], f" {span(seconds)}{_ending(doing, left)}"
    bar = "" if share is None else _bar(share, style)
    cells = BAR + 1 if bar else 0
    room = style.columns - 1 - len(head) - 1 - cells - len(times)
    if room < 12:  # a narrow terminal: what is done says most
        bar, times = "", ""
        room = style.columns - 1 - len(head) - 1
    text = shortened(doing.text, max(1, room), style)
    return f"{head} {text}{' ' + bar if bar else ''}{times}"


def shortened(text: str, room: int, style: Style) -> str:
    """The text in one row of at most so many columns, without control characters."""
    row = "".join(letter if letter.isprintable() else " " for letter in text)
    if not style.wide:
        row = row.encode("ascii", "replace").decode()
    dots = "…" if style.wide else "..."
    return row if len(row) <= room else row[: max(0, room - len(dots))] + dots[:room]


def _bar(fraction: float, style: Style) -> str:
    full, empty = (FULL, EMPTY) if style.wide else (PLAIN_FULL, PLAIN_EMPTY)
    done = min(BAR, max(0, int(BAR * fraction)))
    if not style.colours:
        return full * done + empty * (BAR - done)
    return f"{COLOUR}{full * done}{PLAIN}{DIM}{empty * (BAR - done)}{PLAIN}"
