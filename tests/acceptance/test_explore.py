"""`kabo explore` as a program: killed, cut off, with other numbers of threads, and without its extra."""

import json
import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from kabo.exploration import Exploration, Space, load_exploration
from tests.conftest import PROPERTY_SCALE
from tests.support.discs import FILE, STAGES, write_files

REPOSITORY = Path(__file__).parents[2]
KABO = [sys.executable, "-m", "kabo", "explore"]
RUN = [*KABO, "run", "disc.yaml", "--stages", "disc.py", "-o", "m.jsonl"]
BLOCKED = """\
import sys

class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("sklearn", "threadpoolctl"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Blocker())
"""


@pytest.fixture
def discs(tmp_path):
    write_files(tmp_path)
    return tmp_path


def environment(folder, **given):
    path = os.pathsep.join([str(folder), os.environ["PYTHONPATH"]])
    return {**os.environ, "PYTHONPATH": path, **given}


def done(folder, *command, **given):
    made = subprocess.run(
        [str(each) for each in command], cwd=folder, env=environment(folder, **given), capture_output=True, text=True,
        timeout=120, check=False,
    )  # fmt: skip
    assert "Traceback" not in made.stderr, made.stderr
    return made


def begun(folder, *command, **given):
    return subprocess.Popen(
        [str(each) for each in command], cwd=folder, env=environment(folder, **given), stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def lines(path):
    return path.read_bytes().count(b"\n") if path.exists() else 0


def wait_for(what, seconds=60.0):
    """Waits until `what` is true."""
    until = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < until
        time.sleep(0.002)


def slowed(folder, seconds):
    """Makes each trial take so long."""
    text = STAGES.replace("    along,", f"    time.sleep({seconds})\n    along,", 1)
    (folder / "disc.py").write_text("import time\n" + text)


def make_endless(folder):
    """Makes about every fifth trial endless; such a one says so by a file."""
    endless = "    while seed % 5 == 0:\n        open('stuck', 'w').close()\n    along,"
    (folder / "disc.py").write_text(STAGES.replace("    along,", endless, 1))


@pytest.mark.parametrize("kills", [3, pytest.param(max(10, round(20 * PROPERTY_SCALE)), marks=pytest.mark.slow)])
def test_a_run_that_is_killed_and_resumed_writes_the_same_bytes(discs, kills):
    trials, model = 3 * kills, discs / "m.jsonl"
    assert done(discs, *RUN, "--trials", trials).returncode == 0
    whole = model.read_bytes()
    model.unlink()
    slowed(discs, 0.01)
    for kill in range(kills):
        threads = str(1 + kill % 2)
        given = {"OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": threads}
        before, process = lines(model), begun(discs, *RUN, "--trials", trials, "--resume", **given)
        wait_for(lambda n=before, process=process: lines(model) > n or process.poll() is not None)
        time.sleep(0.0013 * (kill % 7))
        process.kill()
        process.communicate()
        wait_for(lambda: not is_growing(model))
        assert whole.startswith(model.read_bytes()[: model.read_bytes().rfind(b"\n") + 1])
    assert 1 < lines(model) <= trials
    said = done(discs, *RUN, "--trials", trials, "--resume")
    assert said.returncode == 0 and model.read_bytes() == whole


def is_growing(path):
    """Whether somebody still writes into a file."""
    before = path.stat().st_size
    time.sleep(0.05)
    return path.stat().st_size != before


def test_a_run_that_is_interrupted_20_times_writes_the_same_bytes(discs):
    model = discs / "m.jsonl"
    done(discs, *RUN, "--trials", 45)
    whole = model.read_bytes()
    header = whole.split(b"\n", 1)[0] + b"\n"
    cuts = sorted(np.random.default_rng(0).integers(len(header), len(whole), 20))
    model.write_bytes(header)
    for cut in cuts:
        trials = whole[:cut].count(b"\n") - 1
        assert in_this_process(discs, trials) == 0
        model.write_bytes(whole[:cut])  # as if the line after the last whole one was being written
    assert in_this_process(discs, 45) == 0 and model.read_bytes() == whole


def in_this_process(folder, trials):
    from kabo.cli import main

    names = [str(folder / name) for name in ("disc.yaml", "disc.py", "m.jsonl")]
    arguments = ["--stages", names[1], "--trials", str(trials), "--resume", "-o", names[2], "--json"]
    return main(["explore", "run", names[0], *arguments])


def test_the_next_trial_does_not_depend_on_the_number_of_threads(discs):
    """With 400 trials of one case, of which linear algebra makes blocks for its threads."""
    made = Exploration(Space({"along": (0.0, 1.0), "force": (0.0, 1.0)}), ["torque"])
    rng = np.random.default_rng(0)
    for along, force in rng.random((400, 2)).tolist():
        valid = bool((along - 0.5) ** 2 + (force - 0.5) ** 2 < 0.1)
        made.tell({}, {"along": along, "force": force}, valid, {"torque": along + force**2} if valid else None)
    made.save(discs / "m.jsonl")
    answers = set()
    for threads in ("1", "2"):
        given = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), threads)
        for command in (["ask", "m.jsonl"], ["infer", "m.jsonl", "--target", "torque=0.9"], ["show", "m.jsonl"]):
            answers.add(done(discs, *KABO, *command, "--json", **given).stdout)
    assert len(answers) == 3


@pytest.mark.slow
def test_a_run_does_not_depend_on_the_number_of_threads(discs):
    (discs / "disc.yaml").write_text(FILE.replace("cases: {bar: [steel, wood]}\n", ""))
    written = set()
    for threads in ("1", "2"):
        given = {"OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": threads}
        assert done(discs, *RUN, "--trials", 320, **given).returncode == 0
        written.add((discs / "m.jsonl").read_bytes())
        (discs / "m.jsonl").unlink()
    assert len(written) == 1


@pytest.fixture(scope="module")
def twenty_trials(tmp_path_factory):
    """The model of a run of twenty trials."""
    folder = tmp_path_factory.mktemp("twenty")
    write_files(folder)
    assert done(folder, *RUN, "--trials", 20).returncode == 0
    return (folder / "m.jsonl").read_bytes()


@pytest.mark.parametrize(
    "command",
    [
        ["run", "disc.yaml", "--stages", "disc.py", "--trials", "60", "--resume", "-o", "m.jsonl"],
        ["ask", "m.jsonl", "--case", "bar=steel"],
        ["infer", "m.jsonl", "--target", "torque=0"],
        ["show", "m.jsonl"],
        ["show", "m.jsonl", "--html", "m.html"],
    ],
    ids=" ".join,
)
def test_without_the_extra_it_is_told_how_to_install_it(discs, command, twenty_trials):
    before = twenty_trials
    (discs / "m.jsonl").write_bytes(before)
    (discs / "sitecustomize.py").write_text(BLOCKED)
    said = done(discs, *KABO, *command)
    assert said.returncode == 1 and said.stderr.count("\n") == 1, said.stderr
    assert 'pip install "kabo[explore]"' in said.stderr and not said.stdout
    assert (discs / "m.jsonl").read_bytes() == before and not (discs / "m.html").exists()
    said = done(discs, *KABO, *command, "--json")
    assert json.loads(said.stdout)["code"] == "failed"


def test_without_the_extra_no_first_trial_is_made(discs):
    (discs / "sitecustomize.py").write_text(BLOCKED)
    said = done(discs, *RUN, "--trials", 5)
    assert said.returncode == 1 and 'pip install "kabo[explore]"' in said.stderr
    assert not (discs / "m.jsonl").exists()


def test_without_the_extra_a_trial_can_be_told(discs):
    (discs / "sitecustomize.py").write_text(BLOCKED)
    assert done(discs, *RUN, "--trials", 0).returncode == 0
    told = ["tell", "m.jsonl", "--case", "bar=steel", "--set", "along=0", "force=20", "--invalid"]
    assert done(discs, *KABO, *told).returncode == 0


def test_a_trial_without_an_end_is_cut_off_at_the_time_limit_and_all_before_it_is_kept(discs):
    make_endless(discs)
    said = done(discs, *RUN, "--trials", 60, "--timeout", 8, "--json")
    assert said.returncode == 4 and "cut off while trying (time exhausted)" in said.stderr
    kept = load_exploration(discs / "m.jsonl").trials
    answer = json.loads(said.stdout)
    assert answer["stopped"] == "time" and answer["trials"] == len(kept) < 60
    assert "--resume goes on" in said.stderr


@pytest.mark.parametrize("times", [1, 2])
def test_ctrl_c_within_a_trial_ends_the_run_and_keeps_all_before_it(discs, times):
    make_endless(discs)
    process = begun(discs, *RUN, "--trials", 60, "--json")
    wait_for((discs / "stuck").exists)
    for _ in range(times):
        process.send_signal(signal.SIGINT)
        time.sleep(0.3)
    out, told = process.communicate(timeout=30)
    kept, answer = len(load_exploration(discs / "m.jsonl").trials), json.loads(out)
    assert process.returncode == 4 and "(interrupted)" in told and f"the model has {kept} trial" in told
    assert "nothing was written" not in told
    assert answer["stopped"] == "interrupted" and answer["trials"] == kept


def test_a_trial_that_takes_the_process_with_it_ends_the_run_and_all_before_it_is_kept(discs):
    crash = "    if seed % 5 == 0:\n        os.kill(os.getpid(), 11)\n    along,"
    (discs / "disc.py").write_text("import os\n" + STAGES.replace("    along,", crash, 1))
    said = done(discs, *RUN, "--trials", 60, "--json")
    kept = len(load_exploration(discs / "m.jsonl").trials)
    assert said.returncode == 1 and "SIGSEGV" in said.stderr and f"the model has {kept} trial" in said.stderr
    assert "nothing was written" not in said.stderr and json.loads(said.stdout)["code"] == "failed"


def test_ctrl_c_between_trials_ends_the_run_with_what_there_is(discs):
    slowed(discs, 0.05)
    process = begun(discs, *RUN, "--trials", 5000)
    wait_for(lambda: lines(discs / "m.jsonl") > 6)  # scikit-learn is loaded
    process.send_signal(signal.SIGINT)
    out, told = process.communicate(timeout=30)
    assert process.returncode == 4 and "interrupted; all trials are kept" in told
    assert out.startswith(f"disc: {len(load_exploration(discs / 'm.jsonl').trials)} trials")


def test_progress_is_shown_on_a_terminal(discs):
    slowed(discs, 0.1)
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [*RUN, "--trials", "12"], cwd=discs, env=environment(discs, TERM="xterm", COLUMNS="100"), stderr=theirs,
        stdout=subprocess.DEVNULL,
    )  # fmt: skip
    os.close(theirs)
    shown = b""
    while True:
        try:
            read = os.read(ours, 65536)
        except OSError:
            break
        if not read:
            break
        shown += read
    assert process.wait() == 0
    os.close(ours)
    assert b"of 12: bar " in shown


def test_an_exploration_file_executes_no_code_that_it_names(discs):
    (discs / "evil.py").write_text("raise SystemExit('executed')\n")
    for trial in ("evil.py", "evil", "evil:run", "./evil.py"):
        (discs / "disc.yaml").write_text(FILE.replace("tests/Disc", trial))
        said = done(discs, *KABO, "run", "disc.yaml", "--trials", 1, "-o", "m.jsonl")
        assert said.returncode == 2 and "unknown trial" in said.stderr and "executed" not in said.stderr
    assert not (discs / "m.jsonl").exists()
