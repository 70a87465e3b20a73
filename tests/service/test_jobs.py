"""The store of jobs: what waits is bounded by bytes as well as by number, and what is stored, too."""

import time

from kabo.service.jobs import JobStore, Outcome, SolveJob


def job(name: str, size: int, digest: bytes = b"") -> SolveJob:
    return SolveJob(name, bytes(size), time.monotonic() + 60, digest)


def admitted(store: JobStore, each: SolveJob) -> str | None:
    return store.admit(each, lambda _: None, lambda _: None)


def test_requests_that_wait_are_bounded_by_bytes():
    store = JobStore(max_request_bytes=100)
    first, second = job("first", 60), job("second", 40)
    assert admitted(store, first) is None and admitted(store, second) is None
    assert admitted(store, job("third", 1)) == "busy"
    store.finish(first, Outcome(None, b"{}"))
    assert admitted(store, job("fourth", 61)) == "busy"
    assert admitted(store, job("fifth", 60)) is None


def test_a_single_request_is_let_in_however_large():
    store = JobStore(max_request_bytes=100)
    large = job("large", 1000)
    assert admitted(store, large) is None
    assert admitted(store, job("small", 1)) == "busy"
    store.finish(large, large.failure("worker_died", ""))
    assert admitted(store, job("larger", 2000)) is None


def test_who_asks_again_joins_whatever_the_deadline_and_is_never_turned_away_as_busy():
    store, answers = JobStore(max_request_bytes=100), []
    running = job("a", 100, b"what")
    assert admitted(store, running) is None
    assert store.admit(job("a", 100, b"what"), answers.append, lambda _: "busy") is None
    assert admitted(store, job("a", 100, b"else")) == "id_reused"
    store.finish(running, Outcome(None, b"{}"))
    assert [each.body for each in answers] == [b"{}"]


def test_who_looks_for_open_jobs_does_not_walk_what_is_stored():
    store = JobStore()
    for k in range(1000):
        done = job(f"done{k}", 1)
        admitted(store, done)
        store.finish(done, Outcome(None, b"{}"))
    waiting = job("waiting", 1)
    admitted(store, waiting)
    assert store.unfinished() == [waiting] and list(store._unfinished) == ["waiting"]
    assert store.cancel("waiting") and not store.cancel("done1")
