"""`uncertain`: how far a body may be from its pose, or a robot from its path [docs/reference/scenes.md#motion]."""

from collections.abc import Collection

from kabo.language.yaml.documents import Scalar, Sequence, YamlNode
from kabo.language.yaml.values import Reader

_FORM = "write uncertain: {name: 5mm}"


def read_uncertain(
    reader: Reader, node: YamlNode | None, things: Collection[str], regions: Collection[str], whole: bool
) -> dict[str, float]:
    """The errors [m] by the names of robots and bodies.

    A name of nobody is an error, since nothing would be kept from whom it means; or a warning where problems add bodies.

    Args:
        reader: reads the values, and reports what is wrong.
        node: the value of the key `uncertain`.
        things: the names of robots and bodies.
        regions: the names of regions, which are exact.
        whole: whether no body is missing.
    """
    if isinstance(node, Sequence) or (isinstance(node, Scalar) and reader.scalar(node, "`uncertain`") is not None):
        reader.findings.add(node.place, "`uncertain` is said of each body or robot by its name", _FORM)
        return {}
    found: dict[str, float] = {}
    for name, key, value in reader.entries(node, "`uncertain`"):
        error = reader.length(value, f'the error of "{name}"')
        if name in regions:
            reader.findings.add(key.place, f'"{name}" is a region, and regions are exact', _FORM)
        elif name not in things:
            hint = reader.findings.near(name, things)
            here = "" if whole else " in the scene alone"
            text = f'no robot or body is called "{name}"{here}: `uncertain` takes names of robots and bodies'
            reader.findings.add(key.place, text, hint, warning=not whole)
        elif error is not None:
            found[name] = error
    return found
