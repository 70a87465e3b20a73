"""Writes docs/explanation/benchmarks.md: all tables of figures, from the JSON that the scripts in benchmarks/ wrote.

    python benchmarks/sampling.py --output benchmarks/results/sampling.json
    python -m scripts.benchmarks_page

A file is named after its script; one that writes a file for each section has a folder: `tasks/core.json`. What each
script asks stands in benchmarks/README.md. No figure is written by hand, and a script without a file says so.
"""

import json
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
RESULTS, QUESTIONS, PAGE = (
    ROOT / "benchmarks" / "results",
    ROOT / "benchmarks" / "README.md",
    ROOT / "docs" / "explanation" / "benchmarks.md",
)
HEAD = """# Benchmarks

Figures as they were measured last, each table with its command, day, machine and load. Seconds age, and a machine that
does something else at the same time is slower. `python -m scripts.benchmarks_page` writes this page from the files in
`benchmarks/results/`, which the scripts write; [benchmarks/README.md](../../benchmarks/README.md) says what each needs.
Decisions keep the figures for which something was decided, as they were then.

To measure again: on a machine that has nothing else to do, run the command below a heading with
`--output benchmarks/results/NAME.json` (a folder `NAME`, if it has sections), then the one above.
"""


def questions() -> dict[str, str]:
    """What each script asks, in the order of benchmarks/README.md."""
    return dict(re.findall(r"^\| `(\w+)\.py` \| (.*) \|$", QUESTIONS.read_text(), flags=re.MULTILINE))


def results(script: str) -> list[Path]:
    """The files with tables that a script has written, in alphabetical order."""
    found = [*RESULTS.glob(f"{script}.json"), *sorted(RESULTS.glob(f"{script}/*.json"))]
    return [path for path in found if "tables" in json.loads(path.read_text())]


def cell(value: Any) -> str:
    """A figure with four digits, a text as it is, a dash for nothing."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    return str(value).replace("|", "\\|")


def table(content: dict[str, Any]) -> str:
    """A table as Markdown; columns in the order in which rows name them."""
    rows = content["rows"]
    columns = list(dict.fromkeys(["", *(name for row in rows for name in row)]))
    lines = [f"| {' | '.join(columns)} |", "|" + "---|" * len(columns)]
    lines += [f"| {' | '.join(cell(row.get(name)) for name in columns)} |" for row in rows]
    return f"**{content['title']}**\n\n" + "\n".join(lines) + "\n"


def measured(path: Path) -> str:
    """The tables of a file, below the command and what the figures depend on."""
    content = json.loads(path.read_text())
    around = content["surroundings"]
    versions = ", ".join(f"{name} {number}" for name, number in sorted(around["versions"].items()) if number)
    load = " ".join(f"{value:g}" for value in around["load"])
    command = re.sub(r" --output \S+", "", around["command"])
    said = (
        f"`{command}`, {around['date']}, commit {around['commit'][:10]}, {around['processor']}, {around['cores']} cores, "
        f"load {load} at the end; Python {around['python']}, {versions}."
    )
    if "pace" in around:
        said += f" Ten million additions in Python took {around['pace']:.2g} s of the processor then."
    if around["load"][0] > around["cores"]:
        said += " **The machine had more to do than it has cores: seconds on the clock are too long.**"
    return "\n".join([said, "", *(table(each) for each in content["tables"])])


def page() -> str:
    """The whole page."""
    parts = [HEAD]
    for script, question in questions().items():
        found = [measured(path) for path in results(script)]
        parts += [
            f"## {script}\n",
            f"{question}\n",
            *(found or [f"`python benchmarks/{script}.py`: not measured here yet.\n"]),
        ]
    return "\n".join(parts)


def main() -> None:
    """Writes the page."""
    PAGE.write_text(page())
    print(PAGE.relative_to(ROOT))


if __name__ == "__main__":
    main()
