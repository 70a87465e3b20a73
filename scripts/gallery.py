"""Writes what README files of domains and examples show of one plan: figures, its pictures, and how to see more.

    python -m scripts.gallery [--plans FOLDER] [--pages FOLDER]

The block stands between two marks at the end of each README. With `--pages` the page of each plan is written, too, as
`kabo view` writes it. Pictures are written by `python -m scripts.pictures`. Plans are solved, or taken from FOLDER.
"""

import argparse
import re
import tempfile
from pathlib import Path

from kabo.plan import Plan, branch_of, load_plan, plan_statistics
from kabo.whole_files import write_atomically
from scripts.pictures import MOVING, ROOT, SHOWN, plan_of

BEGIN, END = "<!-- from here on written by `python -m scripts.gallery` -->", "<!-- to here -->"
BLOCK = re.compile(re.escape(BEGIN) + ".*" + re.escape(END), re.DOTALL)


def block(folder: str, plan: Plan) -> str:
    """The text between the marks."""
    problem = f"{SHOWN[folder]}.yaml"
    return "\n".join(
        [BEGIN, "## What the plan looks like", "", _figures(problem, plan), "", *_shown(folder), "", END]
    )


def _figures(problem: str, plan: Plan) -> str:
    found = plan_statistics(plan)
    outcomes = "one outcome" if found.plan_leaves == 1 else f"{found.plan_leaves} outcomes"
    text = f"The plan of `{problem}` has {found.plan_nodes} nodes, {outcomes} and {found.plan_actions} actions"
    text += "" if found.plan_leaves == 1 else " on its longest branch"
    seconds = _seconds(plan)
    if seconds:
        text += f"; the motions {'of the branch with most of them ' if found.plan_leaves > 1 else ''}last {seconds:.1f} s"
    if plan.certificate is not None and not plan.certificate_gaps:
        text += ", and a certificate proves every one of them free of collision"
    return text + "."


def _seconds(plan: Plan) -> float:
    """How long the motions of the branch with most of them last, one after the other [s]."""
    nodes = (plan.nodes[name] for name, _ in branch_of(plan, None, plan.problem))
    return sum(max((segment.times[-1] for segment in node.motion), default=0.0) for node in nodes)


def _shown(folder: str) -> list[str]:
    problem = f"{folder}/{SHOWN[folder]}.yaml"
    graph = "The graph of the plan: actions blue, what is sensed amber, the goal green"
    lines = [f"![{graph}](plan.svg)", ""]
    commands = [
        f"    kabo solve {problem} -o plan.json",
        "    kabo view plan.json",
        "    kabo picture plan.json -o plan.svg",
    ]
    if folder in MOVING:
        lines = [
            "![Key frames of the branch with most motions](plan.png)",
            "",
            "All branches at once: [the graph of the plan](plan.svg).",
            "",
        ]
        commands[2:] = ["    kabo picture plan.json -o plan.png", "    kabo picture plan.json -o plan.gif"]
    return [*lines, "`kabo view` shows it as a page, to play and to follow on every branch:", "", *commands]


def readme_of(folder: str) -> Path | None:
    """The README of a domain or example; None if it has none."""
    path = ROOT / folder / "README.md"
    return path if path.exists() else None


def renewed(text: str, folder: str, plan: Plan) -> str:
    """A README's text with its block as the plan makes it; without marks it is appended."""
    new = block(folder, plan)
    return BLOCK.sub(lambda _: new, text) if BLOCK.search(text) else f"{text.rstrip()}\n\n{new}\n"


def page(folder: str, plan_file: Path) -> bytes:
    """The viewer's page of a plan."""
    from kabo.viewer import ViewOptions, document_of_file, page_of

    return page_of(document_of_file(plan_file, ViewOptions(problem=ROOT / f"{folder}/{SHOWN[folder]}.yaml")))


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plans", type=Path, metavar="FOLDER", help="where plans are kept")
    parser.add_argument("--pages", type=Path, metavar="FOLDER", help="write the page of each plan there")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        plans = (options.plans or Path(temporary)).resolve()
        for folder, name in SHOWN.items():
            plan_file = plan_of(f"{folder}/{name}.yaml", plans)
            if (readme := readme_of(folder)) is not None:
                write_atomically(readme, renewed(readme.read_text(), folder, load_plan(plan_file)).encode())
                print(readme.relative_to(ROOT), flush=True)
            if options.pages is not None:
                options.pages.mkdir(parents=True, exist_ok=True)
                target = options.pages / f"{folder.replace('/', '-')}.html"
                write_atomically(target, page(folder, plan_file))
                print(target, flush=True)


if __name__ == "__main__":
    main()
