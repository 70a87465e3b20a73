"""The reference pages against the code: what they name exists, and what exists they name."""

import re
from pathlib import Path
from typing import get_args

import pytest

from kabo.cli import exit_codes
from kabo.cli.main import COMMANDS, parser
from kabo.options import OPTIONS
from kabo.service.messages import Code, Status

REPOSITORY = Path(__file__).parents[2]
COMMANDS_PAGE = (REPOSITORY / "docs" / "reference" / "commands.md").read_text()
SERVICE_PAGE = (REPOSITORY / "docs" / "reference" / "service.md").read_text()
PAGES = [*sorted(REPOSITORY.glob("*.md")), *sorted(REPOSITORY.glob("docs/**/*.md"))]


def options_of(command: str) -> set[str]:
    """The long options of a command."""
    (commands,) = (action for action in parser()._actions if isinstance(action.choices, dict))
    own = list(commands.choices[command]._actions)
    for action in [each for each in own if isinstance(each.choices, dict)]:  # commands of a command
        own += [each for inner in action.choices.values() for each in inner._actions]
    return {option for action in own for option in action.option_strings if option.startswith("--")} - {"--help"}


def top_options() -> set[str]:
    """The long options that stand before or behind every command."""
    return {option for action in parser()._actions for option in action.option_strings if option.startswith("--")}


def test_every_command_has_a_section_and_every_option_that_it_names_exists():
    """That every option is described is the business of docs/reference/options.md, which is written by the code."""
    sections = re.split(r"^## ", COMMANDS_PAGE, flags=re.MULTILINE)[1:]
    described = {
        section.split()[1]: set(re.findall(r"--[a-z][a-z-]*", section))
        for section in sections
        if section[:4] == "kabo"
    }
    assert set(described) == {command.NAME for command in COMMANDS}
    known = {option for command in COMMANDS for option in options_of(command.NAME)} | top_options()
    assert not {name: found - known for name, found in described.items() if found - known}


def test_the_options_of_all_commands_are_described_once():
    section = COMMANDS_PAGE.split("## Messages", 1)[1].split("## Limits", 1)[0]
    assert not {option for option in top_options() - {"--help", "--version"} if option not in section}


def test_every_exit_code_is_described():
    listed = {int(code) for code in re.findall(r"^\| (\d+) \|", COMMANDS_PAGE, flags=re.MULTILINE)}
    assert listed == {
        value for name, value in vars(exit_codes).items() if name.isupper() and isinstance(value, int)
    }


def test_every_error_code_option_and_status_field_of_the_service_is_described():
    listed = set(re.findall(r"^\| `([a-z_]+)` \|", SERVICE_PAGE.split("## Fields")[0], flags=re.MULTILINE))
    assert listed == set(get_args(Code))
    for name in (*OPTIONS, *Status.__struct_fields__):
        assert f"`{name}`" in SERVICE_PAGE or f'"{name}"' in SERVICE_PAGE


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(REPOSITORY).as_posix())
def test_files_that_a_page_names_exist(page):
    named = re.findall(r"`((?:kabo|tests|domains|scripts|benchmarks|docs)/[\w/.-]*)`", page.read_text())
    assert not {name for name in named if not (REPOSITORY / name).exists()}
