"""The generated sections of docs/reference/ say what the code says."""

import json
import re

import pytest

from kabo import options
from kabo.cli.main import COMMANDS
from kabo.geometry_server import REASONS
from kabo.tasks.files import registry
from scripts.reference import file_keys, procedures, schemas
from scripts.reference.sections import DOCS, ROOT, SECTIONS, named, pages, renewed

REFERENCE = DOCS / "reference"


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.name)
def test_a_page_is_what_the_script_writes(page):
    assert renewed(page.read_text()) == page.read_text(), "python -m scripts.reference writes it"


def test_every_section_stands_on_exactly_one_page():
    found = [name for page in pages() for name in named(page.read_text())]
    assert sorted(found) == sorted(SECTIONS)


def test_every_command_option_stage_procedure_and_reason_is_described():
    commands, stages = (REFERENCE / "options.md").read_text(), (REFERENCE / "stages.md").read_text()
    assert {command.NAME for command in COMMANDS} <= set(re.findall(r"^## kabo (\S+)$", commands, re.MULTILINE))
    for option in options.OPTIONS.values():
        assert option.commands == () or f"--{option.name.replace('_', '-')}" in commands
    shipped = {*registry._CONTAINERS, *registry._LEARNED, *registry._robot_names()}
    assert set(re.findall(r"^### (\w+)$", stages, re.MULTILINE)) == shipped
    described = (REFERENCE / "procedures.md").read_text()
    names = {path.stem for path in procedures.LIBRARY.glob("*.yaml")}
    assert names <= set(re.findall(r"^## (\w+)$", described, re.MULTILINE))
    assert all(f"`{reason}`" in described for reason in REASONS)


def test_every_constant_of_keys_that_readers_have_is_explained():
    readers = ROOT / "kabo" / "language" / "yaml"
    constants = {
        f"{path.relative_to(readers).with_suffix('').as_posix().replace('/', '.')}.{name}"
        for path in readers.rglob("*.py")
        for name in re.findall(r"^([A-Z_]+_KEYS) = ", path.read_text(), re.MULTILINE)
    }
    explained = {constant for page in file_keys.things().values() for each in page for constant in each.constants}
    parts = {  # these stand inside of others: their keys are in the row of the key that holds them
        "problem_file.BUDGET_KEYS",
        "scenes.bodies.MODEL_KEYS",
        "scenes.bodies.ROUND_KEYS",
        "scenes.bodies.SHAPE_KEYS",
        "scenes.robots.ROBOT_MODEL_KEYS",
        "scenes.sensors.VIEW_KEYS",
    }
    assert constants - parts == explained


def test_a_key_without_a_meaning_stops_the_script():
    known = next(each for each in file_keys.things()["scene"] if each.name == "Scene")
    lacking = file_keys.Thing(known.name, known.constants, {key: known.keys[key] for key in list(known.keys)[1:]})
    with pytest.raises(SystemExit, match=r"explain \['scene'\]"):
        file_keys.section(lacking)


def keys_of(schema: object) -> set[str]:
    """All keys that a schema, or a part of one, names as properties."""
    if isinstance(schema, list):
        return {key for each in schema for key in keys_of(each)}
    if not isinstance(schema, dict):
        return set()
    return set(schema.get("properties", {})) | {key for each in schema.values() for key in keys_of(each)}


@pytest.mark.parametrize("path", sorted(schemas.FOLDER.glob("*.json")), ids=lambda path: path.name)
def test_every_key_of_every_schema_has_a_row(path):
    page = (REFERENCE / "schemas.md").read_text()
    rows = {
        part.removesuffix("[]")
        for row in re.findall(r"^\| `([^`]+)`", page, re.MULTILINE)
        for part in row.split(".")
    }
    assert not keys_of(json.loads(path.read_text())) - rows
