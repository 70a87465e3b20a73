"""Rows with a figure that was seen, what it must reach, and whether it does."""

from typing import Any

from table import Table


def must(
    table: Table,
    name: str,
    seen: float | None,
    *,
    at_most: float | None = None,
    at_least: float | None = None,
    **more: Any,
) -> None:
    """Appends a row: the figure, its bounds, and whether it keeps them; None keeps no bound."""
    bounds = [f"≤ {at_most:g}"] if at_most is not None else []
    bounds += [f"≥ {at_least:g}"] if at_least is not None else []
    kept = seen is not None and (at_most is None or seen <= at_most) and (at_least is None or seen >= at_least)
    table.add(name, seen=seen, must=" and ".join(bounds) or None, met=kept if bounds else None, **more)
