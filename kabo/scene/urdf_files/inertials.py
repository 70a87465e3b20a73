"""The inertias of a URDF's links, which planning does not need: those that can be are kept for simulations.

Files of robots whose inertias are left empty, or are no numbers, are common, and are no reason not to plan.
"""

import math
from xml.etree import ElementTree  # noqa: S405  only files without entities are read

from kabo.language.robot_files.xml_files import MAX_LENGTH, Element

MOST = 1e6  # [kg] or [kg m²], beyond which a number is none of a robot's
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def add_inertial(made: Element, link: Element) -> None:
    """Adds the inertia of a link to the link that is `made` of it; nothing if it has none that can be."""
    given = link.find("inertial")
    mass, moments, origin = (None if given is None else given.find(tag) for tag in ("mass", "inertia", "origin"))
    if mass is None or moments is None or not 0.0 < (_number(mass.get("value")) or 0.0) <= MOST:
        return
    if any((each := _number(moments.get(key))) is None or abs(each) > MOST for key in _MOMENTS):
        return
    placed = {} if origin is None else {key: origin.get(key, "0 0 0") for key in ("xyz", "rpy")}
    if not all(_is_short(text) for text in placed.values()):
        return
    found = ElementTree.SubElement(made, "inertial")
    ElementTree.SubElement(found, "origin", placed)
    ElementTree.SubElement(found, "mass", {"value": mass.get("value", "")})
    ElementTree.SubElement(found, "inertia", {key: moments.get(key, "") for key in _MOMENTS})


def _number(text: str | None) -> float | None:
    """A finite number; None if the text is none."""
    try:
        found = float(text or "")
    except ValueError:
        return None
    return found if math.isfinite(found) else None


def _is_short(text: str) -> bool:
    """Whether a text has three numbers, none of them longer than lengths are."""
    numbers = [_number(word) for word in text.split()]
    return len(numbers) == 3 and all(each is not None and abs(each) <= MAX_LENGTH for each in numbers)
