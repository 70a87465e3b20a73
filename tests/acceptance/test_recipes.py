"""The recipes of CONTRIBUTING: the files that they name exist, and have the names that one should look at."""

import re
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
SECTION = (REPOSITORY / "CONTRIBUTING.md").read_text().split("\n## How do I\n")[1].split("\n## ")[0]
RECIPES = dict(re.findall(r"^### (.*)\n((?:(?!### ).*\n)*)", SECTION, flags=re.MULTILINE))
WANTED = ("constraint", "stage", "heuristic", "search", "option", "verb", "mesh format", "docs")


def rows(recipe: str) -> list[tuple[str, list[str]]]:
    """Of each row of a recipe's table the path, and the names to look at."""
    found = []
    for line in recipe.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")] if line.startswith("|") else []
        for path, looked_at in zip(cells, cells[1:], strict=False):
            if re.fullmatch(r"(?:a file of )?`[\w./]+/[\w./]*`", path):
                found.append((path.split("`")[1], re.findall(r"`(\w+)`", looked_at)))
    return found


def test_there_is_a_recipe_for_every_common_change():
    assert not [word for word in WANTED if not any(word in title for title in RECIPES)]


@pytest.mark.parametrize("title", RECIPES)
def test_a_recipe_names_files_that_exist_with_the_names_to_look_at(title):
    named = rows(RECIPES[title])
    assert len([path for path, _ in named if path.startswith("kabo/")]) >= 1
    for path, names in named:
        file = REPOSITORY / path
        assert file.exists(), path
        text = file.read_text() if file.is_file() else ""
        assert not [name for name in names if not re.search(rf"\b{name}\b", text)], path


def test_interfaces_that_recipes_name_exist_somewhere():
    """Such as `RobotStage` and `Algorithm`, which stand in no row of their own."""
    sources = "\n".join(
        path.read_text() for room in ("kabo", "scripts") for path in (REPOSITORY / room).rglob("*.py")
    )
    named = set(re.findall(r"`([A-Z]\w+)`", SECTION))
    assert len(named) > 15
    assert not {name for name in named if not re.search(rf"\b{name}\b", sources)}
