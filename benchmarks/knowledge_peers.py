"""Planners of others on the same instances, written as PDDL: only classical ones install from the package index.

They run as external processes in an environment of their own, named by its interpreter: `pip install
up-fast-downward up-symk up-enhsp up-lpg pyperplan` there (ENHSP needs Java). Contingent engines (CPOR, PO-PRP,
Contingent-FF, MBP) are not on the index, so instances with sensing have no peers; they are counted.
"""

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

from knowledge_instances import Instance
from knowledge_pddl import NotClassicalError, to_pddl
from table import Table

import kabo

WHERE = """\
import importlib.util
for name in ("up_fast_downward", "up_symk", "up_enhsp", "up_lpg", "pyperplan"):
    found = importlib.util.find_spec(name)
    print(name, "-" if found is None else list(found.submodule_search_locations)[0])
"""
LIMITED = """\
import os, resource, sys
size = int(sys.argv[1])
resource.setrlimit(resource.RLIMIT_AS, (size, size))
os.execvp(sys.argv[2], sys.argv[2:])
"""
LAMA_FIRST = ["--alias", "lama-first", "--plan-file", "{plan}", "{domain}", "{problem}"]
LMCUT = ["--plan-file", "{plan}", "{domain}", "{problem}", "--search", "astar(lmcut())"]
SYMK = ["--plan-file", "{plan}", "{domain}", "{problem}", "--search", "sym_bd()"]


def commands(python: str) -> dict[str, list[str]]:
    """The command of each peer that is installed, with {domain}, {problem} and {plan} to fill in."""
    answer = subprocess.run([python, "-c", WHERE], capture_output=True, text=True, check=True).stdout
    places = dict(line.split(" ", 1) for line in answer.splitlines())
    found: dict[str, list[str]] = {}
    if places["up_fast_downward"] != "-":
        driver = [python, f"{places['up_fast_downward']}/downward/fast-downward.py"]
        found["Fast Downward, first LAMA iteration"] = [*driver, *LAMA_FIRST]
        found["Fast Downward, A* with lmcut (optimal)"] = [*driver, *LMCUT]
    if places["up_symk"] != "-":
        found["SymK, bidirectional (optimal)"] = [python, f"{places['up_symk']}/symk/fast-downward.py", *SYMK]
    if places["up_enhsp"] != "-":
        jar = f"{places['up_enhsp']}/ENHSP/enhsp.jar"
        found["ENHSP"] = ["java", "-jar", jar, "-o", "{domain}", "-f", "{problem}", "-sp", "{plan}"]
    if places["up_lpg"] != "-":
        lpg = next(
            (str(path) for path in Path(places["up_lpg"]).rglob("lpg*") if path.is_file() and _runs(path)), None
        )
        if lpg is not None:
            found["LPG"] = [lpg, "-o", "{domain}", "-f", "{problem}", "-n", "1", "-seed", "1", "-out", "{plan}"]
    if places["pyperplan"] != "-":
        found["pyperplan, gbf with hff"] = [
            python,
            "-m",
            "pyperplan",
            "-s",
            "gbf",
            "-H",
            "hff",
            "{domain}",
            "{problem}",
        ]
    return found


def _runs(path: Path) -> bool:
    return path.suffix == "" and bool(path.stat().st_mode & 0o111)


def peers(python: str, instances: Sequence[Instance], timeout: float, memory: float) -> Table:
    """One row per classical problem and peer: seconds from start to end of the process, and the plan's length."""
    table = Table(f"Planners of others, as external processes, time-out {timeout:g} s")
    seen: set[str] = set()
    refused = 0
    for instance in instances:
        text = instance.text()
        if text in seen:
            continue
        seen.add(text)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "problem.yaml"
            path.write_text(text)
            try:
                domain, problem = to_pddl(kabo.load_problem(path))
            except NotClassicalError:
                refused += 1
                continue
            Path(folder, "domain.pddl").write_text(domain)
            Path(folder, "problem.pddl").write_text(problem)
            for name, command in commands(python).items():
                short = instance.name.partition(" ")[0]
                table.add(f"{short}, {name}", **_run(command, Path(folder), timeout, memory))
    table.add("not classical: no peer installs", instances=refused)
    return table


def _run(command: list[str], folder: Path, timeout: float, memory: float) -> dict[str, object]:
    plan = folder / "plan"
    for old in [*folder.glob("plan*"), folder / "problem.pddl.soln"]:
        old.unlink(missing_ok=True)
    filled = [
        part.format(domain=folder / "domain.pddl", problem=folder / "problem.pddl", plan=plan) for part in command
    ]
    if command[0] != "java":  # Java reserves more than it uses
        filled = [sys.executable, "-c", LIMITED, str(int(memory * 2**30)), *filled]
    began = perf_counter()
    process = subprocess.Popen(
        filled,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        cwd=folder,
        start_new_session=True,  # drivers start the planner as a process of their own
    )
    try:
        code = process.wait(timeout)
        ended = "" if code == 0 else f"exit {code}"
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        ended = "time-out"
    seconds = perf_counter() - began
    written = sorted([*folder.glob("plan*"), *folder.glob("*.soln"), *folder.glob("plan*.SOL")])
    lengths = [_length(path) for path in written]
    return {"s": seconds, "actions": min((n for n in lengths if n), default=None), "ended": ended or "ok"}


def _length(path: Path) -> int:
    return sum("(" in line and not line.lstrip().startswith(";") for line in path.read_text().splitlines())
