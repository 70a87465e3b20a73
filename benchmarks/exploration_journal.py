"""Whether `kabo explore run` writes the same bytes when it is resumed or killed again and again, under 1 and 2 threads."""

import argparse
import hashlib
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from exploration_must import must
from table import Table

TRIALS, TIMES = (
    320,
    20,
)  # above 300 trials the last bits of linear algebra depend on its threads if nothing limits them
FILE = """exploration: bent
trial: bent/Try
parameters: {a: {from: -1, to: 1, unit: m}, b: {from: 0, to: 2}}
cases: {side: [left, right]}
outcomes: {height: {unit: m}, strain: {}}
start: {a: 0.0, b: 0.6}
"""
STAGES = """import random
from kabo.trials import Invalid, Valid, register

def bent(case, parameters, seed):
    noise = random.Random(seed).gauss(0, 0.02)
    a, b = parameters["a"] * (1 if case["side"] == "left" else -0.8), parameters["b"]
    if not 0.3 < b - a * a < 1.1:
        return Invalid("below" if b < a * a + 0.5 else "above")
    return Valid({"height": a + 0.3 * b * b + noise, "strain": 2 * a * b - noise})

register(bent, "bent/Try")
"""


class Run:
    """A run in a folder of its own, in child processes with so many threads of linear algebra."""

    def __init__(self, folder: Path, threads: int) -> None:
        self.folder, self.model = folder, folder / "model.jsonl"
        folder.mkdir()
        (folder / "bent.yaml").write_text(FILE)
        (folder / "bent.py").write_text(STAGES)
        names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
        self.environment = {**os.environ, **dict.fromkeys(names, str(threads))}

    def start(self, trials: int) -> subprocess.Popen[str]:
        """A process that goes on until there are so many trials."""
        command = [sys.executable, "-m", "kabo", "explore", "run", "bent.yaml", "--stages", "bent.py", "--resume"]
        command += ["--seed", "7", "--invalid-budget", "0.2", "--trials", str(trials), "-o", str(self.model)]
        return subprocess.Popen(
            command,
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )

    def finish(self, trials: int) -> None:
        """Goes on to the end; raises RuntimeError if that fails."""
        child = self.start(trials)
        said = child.communicate()[1]
        if child.returncode != 0:
            raise RuntimeError(f"exit code {child.returncode}: {said}")

    def kill_after(self, lines: int, pause: float, trials: int) -> bool:
        """Kills a process some seconds after the file has grown by so many lines; says whether it was still at work."""
        child = self.start(trials)
        before = self.lines()
        while child.poll() is None and self.lines() < before + lines:
            time.sleep(0.002)
        time.sleep(pause)
        working = child.poll() is None
        child.kill()
        child.communicate()
        return working

    def lines(self) -> int:
        """The whole lines of the file."""
        return self.model.read_bytes().count(b"\n") if self.model.exists() else 0


def written(run: Run, way: str, trials: int, times: int) -> int:
    """Makes the trials in one way; returns how often the run was interrupted."""
    rng = np.random.default_rng(trials)
    interrupted = 0
    if way == "resumed":
        for number in range(1, times + 1):
            run.finish(number * trials // (times + 1))
        interrupted = times
    if way == "killed":
        for _ in range(times):
            lines = int(rng.integers(1, max(2, trials // times - 3)))
            interrupted += run.kill_after(lines, 0.02 * rng.random(), trials)
    if way == "torn":  # as if the power had failed within the last line
        for number in range(1, times + 1):
            run.finish(number * trials // (times + 1))
            os.truncate(run.model, run.model.stat().st_size - int(rng.integers(1, 40)))
        interrupted = times
    run.finish(trials)
    return interrupted


def tables(options: argparse.Namespace) -> list[Table]:
    """A row for each way and number of threads, and whether all files are the same."""
    trials, times = (8, 1) if options.small else (options.trials or TRIALS, TIMES)
    shown = Table(f"A run of {trials} trials: what it writes")
    digests = set()
    with tempfile.TemporaryDirectory() as folder:
        for threads in (1,) if options.small else (1, 2):
            for way in ("at once", "resumed", "killed", "torn"):
                run = Run(Path(folder) / f"{way} {threads}", threads)
                interrupted = written(run, way, trials, times)
                content = run.model.read_bytes()
                digests.add(content)
                digest = hashlib.sha256(content).hexdigest()[:16]
                shown.add(f"{way}, threads: {threads}", interrupted=interrupted, lines=run.lines(), sha256=digest)
    judged = Table("Journals: must reach")
    must(judged, "different files", float(len(digests)), at_most=1)
    return [shown, judged]
