"""The keys of the files that kabo reads: which there are says the reader, what they mean says the table here.

A key that a reader accepts and this table does not explain stops the script, and so does one that no reader accepts.
"""

from collections.abc import Collection
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import yaml

from scripts.reference.markdown import code, table

READERS = "kabo.language.yaml"
MEANINGS = Path(__file__).with_name("file_keys.yaml")


@dataclass(frozen=True)
class Thing:
    """A mapping in a file: what it is, the constants of a reader that name its keys, and what each key means."""

    name: str
    constants: tuple[str, ...]  # `module.CONSTANT`, below kabo.language.yaml
    keys: dict[str, tuple[str, str]]  # of each key its value and its meaning


def things() -> dict[str, list[Thing]]:
    """Of each page the mappings that it explains."""
    read = yaml.safe_load(MEANINGS.read_text())
    return {page: [thing(name, **each) for name, each in entries.items()] for page, entries in read.items()}


def thing(name: str, keys: dict[str, str], reader: str) -> Thing:
    """One mapping: the meaning of a key is written `value | meaning`."""
    parted = {key: (text.partition(" | ")[0], text.partition(" | ")[2]) for key, text in keys.items()}
    return Thing(name, tuple(reader.split()), parted)


PAGES = tuple(yaml.safe_load(MEANINGS.read_text()))


def accepted(constants: Collection[str]) -> list[str]:
    """The keys that constants of readers name, in their order."""
    found: list[str] = []
    for each in constants:
        module, _, name = each.rpartition(".")
        found += getattr(import_module(f"{READERS}.{module}"), name)
    return list(dict.fromkeys(found))


def sections(page: str) -> str:
    """The tables of one page, a section for each mapping."""
    return "\n\n" + "\n\n".join(section(each) for each in things()[page]) + "\n\n"


def section(each: Thing) -> str:
    """The table of one mapping.

    Raises:
        SystemExit: the reader has a key without a meaning, or there is a meaning without a key.
    """
    known = accepted(each.constants)
    if set(known) != set(each.keys):
        raise SystemExit(
            f"{MEANINGS.name}: {each.name}: explain {sorted(set(known) ^ set(each.keys))}, or take it out"
        )
    rows = [(code(key), *each.keys[key]) for key in known]
    return f"### {each.name}\n\n" + table(("key", "value", "meaning"), rows)
