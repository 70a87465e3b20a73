"""How well a robot notices what it does to strings, judged by what really happened: before any other figure is believed."""

import numpy as np
from exploration_plucks import deflection
from guzheng import DIRECTIONS, guzheng
from plucked_string import ALIGNED, HARD, Sensed, judged, play
from table import Table

from kabo.trials import Valid


def senses(plucks: int) -> Table:
    """Random plucks of all strings: what was noticed of what happened, and what was right."""
    table = Table(f"Senses: {plucks} plucks anywhere, of all strings")
    rng, instrument = np.random.default_rng(0), guzheng()
    drawn = [
        play(
            instrument,
            str(rng.choice(list(instrument.strings))),
            str(rng.choice(DIRECTIONS)),
            rng.random(),
            deflection(rng.random()),
            seed,
        )
        for seed in range(plucks)
    ]
    table.add("onsets heard", **_noticed([[onset.time for onset in each.onsets] for each in drawn], drawn))
    table.add("drops felt", **_noticed([list(each.drops) for each in drawn], drawn))
    single = [each for each in drawn if len(each.happened) == 1]
    notes = [each for each in single if len(each.onsets) == 1]
    right = [each.onsets[0].notes == (each.happened[0].string.note,) for each in notes]
    table.add("notes told of single onsets", precision=float(np.mean(right)), events=len(right))
    called = [
        isinstance(judged(each, each.happened[0].string.note), Valid) for each in single if each.strongest <= HARD
    ]
    table.add(
        "plucks of one string, not too hard, called valid", recall=float(np.mean(called)), events=len(called)
    )
    return table


def _noticed(times: list[list[float]], drawn: list[Sensed]) -> dict[str, float]:
    """Precision, recall and the number of events; releases within a moment count once, as no sense tells them apart."""
    right = noticed = happened = 0
    for own, each in zip(times, drawn, strict=True):
        real = [release.time for release in each.happened][:1]
        right += sum(any(abs(time - at) < ALIGNED for time in own) for at in real)
        noticed, happened = noticed + len(own), happened + len(real)
    return {"precision": right / max(1, noticed), "recall": right / max(1, happened), "events": happened}
