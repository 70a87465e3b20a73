"""What notebooks show of kabo's objects: a small table of figures, and the viewer's page below it.

Rooms below the viewer call `display` without importing it: the viewer is imported by its name, and only when a notebook
asks. Nothing is solved here. A page that cannot be made, or is too large for a notebook, is left out, and a line says so.
"""

from collections.abc import Iterable, Mapping
from html import escape
from importlib import import_module

VIEWER = "kabo.viewer"

MAX_PAGE_CHARACTERS = 6_000_000  # of a page inside a notebook, which stores every page that it shows
MAX_CELL_CHARACTERS = 400  # of one figure
MAX_LISTED = 20  # lines of a list
FRAME_PIXELS = 560  # height of a page inside a notebook


def display(title: str, figures: Mapping[str, str], thing: object = None) -> str:
    """HTML for a notebook: a title, a table of figures, and the page of `thing` in a frame.

    Args:
        title: what is shown, in a few words.
        figures: values by name, as plain text; long ones are cut.
        thing: what the viewer shows; None for a table alone.
    """
    rows = "".join(
        f'<tr><th scope="row" style="text-align: left; vertical-align: top">{escape(name)}</th>'
        f'<td style="text-align: left">{escape(shortened(value))}</td></tr>'
        for name, value in figures.items()
        if value
    )
    table = f"<table><tbody>{rows}</tbody></table>" if rows else ""
    return f"<div><strong>{escape(title)}</strong>{table}{'' if thing is None else page_of(thing)}</div>"


def page_of(thing: object) -> str:
    """The viewer's page of a thing as a frame; empty if no page can be made of it."""
    page = import_module(VIEWER).notebook_page(thing)
    return frame(page) if isinstance(page, str) else ""


def frame(page: str, height: int = FRAME_PIXELS) -> str:
    """A whole page inside a frame of a notebook, `height` pixels high; a line instead if the page is too large."""
    if len(page) > MAX_PAGE_CHARACTERS:
        size = f"{len(page) / 1e6:.0f} MB"
        return (
            f"<p>The page of the viewer has {size}, too much for a notebook; <code>kabo.view</code> opens it.</p>"
        )
    return (
        f'<iframe srcdoc="{escape(page)}" title="kabo" style="width: 100%; height: {height}px; border: 1px solid #8888" '
        'loading="lazy" allowfullscreen></iframe>'
    )


def bullets(lines: Iterable[str], title: str = "") -> str:
    """HTML for a list of lines, below its title; a long list is cut. Empty without lines."""
    told = list(lines)
    if not told:
        return ""
    shown = [shortened(line) for line in told[:MAX_LISTED]]
    if len(told) > MAX_LISTED:
        shown.append(f"and {len(told) - MAX_LISTED} more")
    head = f"<p>{escape(title)}:</p>" if title else ""
    return f"{head}<ul>{''.join(f'<li>{escape(line)}</li>' for line in shown)}</ul>"


def counted(number: int, thing: str, things: str | None = None) -> str:
    """A number with its thing, in the plural if it must be: `1 body`, `2 bodies`."""
    return f"{number} {thing if number == 1 else things or thing + 's'}"


def shortened(text: str, most: int = MAX_CELL_CHARACTERS) -> str:
    """The text, cut after `most` characters."""
    return text if len(text) <= most else f"{text[: most - 1]}…"
