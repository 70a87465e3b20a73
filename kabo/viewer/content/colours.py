"""Colours of bodies that are called by one: `red`, `blue_cup` or `box_green` look as their names say."""

import re

NAMED = {
    "black": "#33363b",
    "blue": "#2f6fc4",
    "brown": "#85593a",
    "cyan": "#2aa6b8",
    "gray": "#8c9299",
    "green": "#2f8f4e",
    "grey": "#8c9299",
    "magenta": "#b8458f",
    "orange": "#e07b22",
    "pink": "#e08bae",
    "purple": "#7a55b3",
    "red": "#c8382e",
    "violet": "#7a55b3",
    "white": "#f1f2f4",
    "yellow": "#dfb52c",
}
WORD = re.compile(r"[a-z]+")


def colour_of_name(name: str) -> str | None:
    """The colour (#rrggbb) that a word of a body's name says, the first of several; None if no word is a colour."""
    return next((NAMED[word] for word in WORD.findall(name.lower()) if word in NAMED), None)
