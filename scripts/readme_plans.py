"""Writes the plans that README files show, as the command before each of them prints it.

    python -m scripts.readme_plans

A plan is a block between ``` that begins with `n0`; the command is the last line before it with `kabo solve`.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PLAN = re.compile(r"(?<=```\n)n0 .*?(?=```)", re.DOTALL)
COMMAND = re.compile(r"^ *kabo (solve .*?)(?: -o \S+)?$", re.MULTILINE)


def shown() -> list[Path]:
    """The README files of domains and examples that show a plan."""
    pages = [*sorted(ROOT.glob("domains/*/README.md")), *sorted(ROOT.glob("examples/*/README.md"))]
    return [path for path in pages if PLAN.search(path.read_text())]


def printed(command: str) -> str:
    """What `kabo COMMAND` prints on standard output.

    Raises:
        subprocess.CalledProcessError: it found no plan.
    """
    with tempfile.TemporaryDirectory() as folder:
        program = [sys.executable, "-m", "kabo.cli", *command.split(), "-o", f"{folder}/plan.json"]
        return subprocess.run(program, cwd=ROOT, capture_output=True, text=True, check=True).stdout


def renewed(text: str) -> str:
    """A README's text with its plans as kabo makes them now."""

    def plan(found: re.Match[str]) -> str:
        return printed(COMMAND.findall(text[: found.start()])[-1])

    return PLAN.sub(plan, text)


def main() -> None:
    """Writes them all anew."""
    for path in shown():
        path.write_text(renewed(path.read_text()))
        print(path.relative_to(ROOT))


if __name__ == "__main__":
    main()
