"""The pool of workers: who has the answer to a job no longer finds it running."""

import json
import queue
import time

from kabo.service import workers
from kabo.service.jobs import JobStore, Outcome, SolveJob
from kabo.service.workers import Pool
from tests.service.conftest import STUB


def test_a_job_is_no_longer_running_when_its_answer_is_delivered():
    store, answers = JobStore(), queue.Queue[tuple[Outcome, int]]()
    pool = Pool(STUB, store, workers=1, bound=4, root=None, on_progress=lambda *_: None)
    try:
        request = json.dumps({"id": "a", "options": {"x": 3}}).encode()
        job = SolveJob("a", request, time.monotonic() + 60)
        assert store.admit(job, lambda outcome: answers.put((outcome, pool.running)), pool.enqueue) is None
        outcome, running = answers.get(timeout=60)
    finally:
        pool.close()
    assert json.loads(outcome.body) == {"id": "a", "square": 9}
    assert running == 0


def test_a_worker_that_cannot_be_started_for_a_while_loses_no_job(monkeypatch):
    """The system may lack files, memory or processes for a moment: the thread waits, and tries again."""
    attempts, spawn = [], workers._spawned

    def seldom(*arguments):
        attempts.append(None)
        if len(attempts) < 4:
            raise OSError(24, "Too many open files")
        return spawn(*arguments)

    monkeypatch.setattr(workers, "_spawned", seldom)
    store, answers = JobStore(), queue.Queue[Outcome]()
    pool = Pool(STUB, store, workers=1, bound=4, root=None, on_progress=lambda *_: None)
    try:
        request = json.dumps({"id": "a", "options": {"x": 3}}).encode()
        assert store.admit(SolveJob("a", request, time.monotonic() + 60), answers.put, pool.enqueue) is None
        assert json.loads(answers.get(timeout=60).body)["square"] == 9
    finally:
        pool.close()


def test_a_job_is_answered_when_its_thread_meets_a_defect():
    def broken(*_):
        raise RuntimeError("on purpose")

    store, answers = JobStore(), queue.Queue[Outcome]()
    pool = Pool(STUB, store, workers=1, bound=4, root=None, on_progress=broken)
    try:
        for name, options, code in (("a", {"for_s": 0.1}, "failed"), ("b", {}, None)):
            request = json.dumps({"id": name, "options": options}).encode()
            assert store.admit(SolveJob(name, request, time.monotonic() + 60), answers.put, pool.enqueue) is None
            assert answers.get(timeout=60).code == code
    finally:
        pool.close()
