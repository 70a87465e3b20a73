"""Writes what a solve can be told into docs/: from the table of options, so that the pages say what kabo does.

    python -m scripts.option_pages

docs/reference/commands.md gets the arguments of `kabo solve`, docs/reference/service.md the fields of a request,
docs/reference/files.md the keys of a problem file.
"""

from collections.abc import Callable
from pathlib import Path

from kabo.options import OPTIONS, Option

DOCS = Path(__file__).resolve().parent.parent / "docs"
BEGIN, END = "<!-- python -m scripts.option_pages writes from here -->", "<!-- to here -->"


def table() -> str:
    """The arguments of `kabo solve`, as a table."""
    rows = [
        f"| {argument(option)} | {default(option)} | {meaning(option)} |"
        for option in OPTIONS.values()
        if "solve" in option.commands
    ]
    return "\n".join(["", "| option | default | |", "|---|---|---|", *rows, ""])


def argument(option: Option) -> str:
    """An option as it is written on the command line."""
    name = option.name.replace("_", "-")
    if option.kind is bool:
        return f"`--{name}`, `--no-{name}`"
    value = "NAME" if option.choices else "N" if option.kind is int else option.name[0].upper()
    return f"`--{name} {value}`"


def default(option: Option) -> str:
    """What an option is if nobody says it."""
    said = option.otherwise or ("yes" if option.default is True else f"`{option.default}`")
    return said if option.problem_key is None else f"the problem's, else {said}"


def meaning(option: Option) -> str:
    """What an option means, and its choices unless that names them."""
    unnamed = [choice for choice in option.choices if f"`{choice}`:" not in option.help]
    choices = ", ".join(f"`{choice}`" for choice in option.choices)
    return f"{option.help} ({choices})" if unnamed else option.help


def fields() -> str:
    """The options of a request."""
    return ", ".join(f"`{name}`" for name in OPTIONS)


def problem_keys() -> str:
    """The options of a problem file."""
    keys = [option.problem_key.split(".") for option in OPTIONS.values() if option.problem_key is not None]
    budget = ", ".join(f"`{key[1]}`" for key in keys if len(key) == 2)
    return ", ".join([f"`{key[0]}`" for key in keys if len(key) == 1] + [f"`budget`: {{{budget}}}"])


PAGES: dict[Path, Callable[[], str]] = {
    DOCS / "reference" / "commands.md": table,
    DOCS / "reference" / "service.md": fields,
    DOCS / "reference" / "files.md": problem_keys,
}


def renewed(page: Path) -> str:
    """The text of a page with what the table of options says now."""
    before, _, rest = page.read_text().partition(BEGIN)
    return before + BEGIN + PAGES[page]() + END + rest.partition(END)[2]


def main() -> None:
    """Writes all pages."""
    for page in PAGES:
        page.write_text(renewed(page))
    print(*(page.relative_to(DOCS.parent) for page in PAGES))


if __name__ == "__main__":
    main()
