"""Formulas and effects of the kitchen's domain, parsed on their own."""

from pathlib import Path
from typing import Any

from kabo.language import formulas as f
from kabo.language.findings import Findings
from kabo.language.source import SourceFile
from kabo.language.vocabulary import Symbol
from kabo.language.yaml.documents import Scalar, read_document
from kabo.language.yaml.domain_file import read_domain, read_parsed
from kabo.language.yaml.effects import read_effects
from kabo.language.yaml.queries import read_formula
from tests.language.conftest import DOMAIN


def _goal(here: Any, node: Any) -> Any:
    return read_formula(here, node, temporal=True)


def parse_text(text: str, start: str = "formula") -> Any:
    """The tree of a formula or effect with the parameters r: robot, o: bottle; asserts that nothing is wrong."""
    findings = Findings()
    root = read_document(SourceFile(Path("domain.yaml"), "domain.yaml", DOMAIN), findings)
    assert root is not None
    vocabulary = read_domain(root, findings).vocabulary
    place = f.Place("domain.yaml", 1, 1)
    bound = {
        "r": Symbol("parameter", "r", place, ("robot",), type="robot"),
        "o": Symbol("parameter", "o", place, ("bottle",), type="bottle"),
    }
    scalar = Scalar(SourceFile(Path("text"), "text", text), 0, len(text), text, "")
    read = {"formula": _goal, "effect": read_effects}[start]
    tree = read_parsed(scalar, start, vocabulary, "in a test", read, bound)
    assert [str(each) for each in findings.diagnostics] == []
    return tree
