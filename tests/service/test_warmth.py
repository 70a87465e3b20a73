"""Workers are warm before anybody sees the server, and before their first job, whenever they are replaced."""

import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from kabo.service import Client, client_config
from tests.service.conftest import REPOSITORY, STUB, free_endpoint
from tests.service.test_server import ask

ARMS = ("circular_rearrange/n3.yaml", "force_sensing/n2.yaml")
WARMTH = """
import json, sys
from pathlib import Path
from kabo.options import SolveOptions
from kabo.requests import solve_file
from kabo.service.worker import warm_up

def compiled():
    kernels = [m for name, m in sys.modules.items() if name.startswith("kabo.") and ".kernels." in name]
    whole = [each for m in kernels for each in vars(m).values() if hasattr(each, "signatures")]
    return {f"{each.__module__}.{each.__name__}{signature}" for each in whole for signature in each.signatures}

warm_up()
modules, kernels = set(sys.modules), compiled()
for problem in sys.argv[1:]:
    assert solve_file(Path(problem), SolveOptions()).body["status"] == "solved"
print(json.dumps([len(kernels), sorted(set(sys.modules) - modules), sorted(compiled() - kernels)]))
"""


def test_a_server_is_seen_when_all_its_workers_are_warm(serve, tmp_path, monkeypatch):
    log = tmp_path / "warm"
    monkeypatch.setenv("STUB_WARM_LOG", str(log))
    monkeypatch.setenv("STUB_WARM_S", "0.7")
    endpoint = free_endpoint()
    with Client(client_config([endpoint])) as client, ThreadPoolExecutor(1) as threads:
        starting = threads.submit(serve, workers=2, endpoint=endpoint)
        until = time.monotonic() + 60
        while not client.servers() and time.monotonic() < until:
            time.sleep(0.005)
        warm = log.read_text().split()
        running = starting.result()
        assert sorted(map(int, warm)) == sorted(running.workers())
        assert ask(client, x=3)["square"] == 9


def test_a_replaced_worker_is_warm_before_its_next_job_and_no_job_is_lost(serve, tmp_path, monkeypatch):
    warm, jobs = tmp_path / "warm", tmp_path / "jobs"
    monkeypatch.setenv("STUB_WARM_LOG", str(warm))
    monkeypatch.setenv("STUB_WARM_S", "0.3")
    server = serve(workers=2)
    with server.client() as client, ThreadPoolExecutor(6) as threads:
        asked = [threads.submit(ask, client, deadline_s=60.0, x=x, for_s=0.5, log=str(jobs)) for x in range(6)]
        time.sleep(0.25)
        for worker in server.workers():
            os.kill(worker, signal.SIGKILL)
        assert [each.result()["square"] for each in asked] == [x * x for x in range(6)]
    workers = set(jobs.read_text().split()[1::2])
    assert len(workers) == 4 and workers <= set(warm.read_text().split())


def test_a_worker_that_dies_while_it_waits_is_replaced_and_costs_no_job(serve, tmp_path):
    log = tmp_path / "log"
    server = serve(workers=1)
    with server.client() as client:
        for x in range(3):
            (worker,) = server.workers()
            os.kill(worker, signal.SIGKILL)
            assert ask(client, x=x, log=str(log))["square"] == x * x
    assert len(log.read_text().split()) == 6, "one attempt for each"


def test_workers_that_die_in_every_start_are_told_instead_of_a_server(monkeypatch):
    monkeypatch.setenv("STUB_COLD_DEATH", "1")
    script = str(Path(__file__).with_name("serving.py"))
    command = [sys.executable, script, free_endpoint(), "1", "4", STUB]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode != 0 and "died 8 times while it started" in done.stderr and not done.stdout


def test_after_warming_up_small_problems_and_those_of_arms_load_and_compile_nothing():
    problems = [str(REPOSITORY / "domains" / name) for name in ("stacked/n3.yaml", "doors/n3.yaml", *ARMS)]
    done = subprocess.run(
        [sys.executable, "-c", WARMTH, *problems], capture_output=True, text=True, check=True, timeout=600
    )
    kernels, modules, compiled = json.loads(done.stdout)
    assert kernels > 20 and not modules and not compiled
