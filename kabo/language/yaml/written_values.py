"""Values of properties as they are written: words, lists and mappings with places; what they mean is decided elsewhere."""

from collections.abc import Callable

from kabo.language.findings import Findings
from kabo.language.task_description import Entries, Items, PropertyReference, Word, Written
from kabo.language.yaml.documents import Mapping, Scalar, Sequence, YamlNode

ReadReference = Callable[[Scalar], PropertyReference | None]


def read_written(node: YamlNode, what: str, findings: Findings, reference: ReadReference) -> Written | None:
    """The value of a node as it is written; None after a report.

    Args:
        node: the node.
        what: the value in messages.
        findings: where errors are reported.
        reference: the reference that a scalar is, or None for other text; it may report errors, too.
    """
    if isinstance(node, Sequence):
        items = [read_written(item, f"every item of {what}", findings, reference) for item in node.items]
        return Items(tuple(each for each in items if each is not None), node.place)
    if isinstance(node, Mapping):
        entries = {
            key: read_written(value, f'"{key}" of {what}', findings, reference)
            for key, (_, value) in node.entries.items()
        }
        return Entries({key: value for key, value in entries.items() if value is not None}, node.place)
    if not isinstance(node, Scalar) or node.refused:
        return None
    if node.empty:
        findings.add(node.place, f"{what} has no value")
        return None
    return reference(node) or Word(node.text, bool(node.style), node.place)
