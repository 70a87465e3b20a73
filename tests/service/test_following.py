"""Those who follow a server get the request as it was sent, its answer by joining it, and what is refused meanwhile."""

import threading
from collections.abc import Callable
from typing import Any

import msgspec

from kabo.geometry_server import Refusal
from kabo.language.formulas import Constant, GroundCall
from kabo.service import Client, Reply, Watched
from kabo.service.following import Following
from kabo.tasks.records import Record, Where
from tests.service.conftest import Running


def sent(client: Client, identifier: str, **options: Any) -> None:
    client.solve(lambda _: {"path": "p"}, options, deadline_s=20, identifier=identifier)


def test_there_is_no_request_before_the_first(serve: Callable[..., Running]) -> None:
    running = serve(workers=1)
    with running.client() as client:
        while not client.servers():
            pass
        assert client.latest_request(running.name) is None


def test_a_running_request_is_joined_and_an_ended_one_has_its_answer(serve: Callable[..., Running]) -> None:
    running = serve(workers=1)
    with running.client() as client, running.client() as follower:
        asking = threading.Thread(target=sent, args=(client, "one"), kwargs={"x": 7, "for_s": 1.0})
        watched: list[Watched] = []
        follower.watch(watched.append)
        asking.start()
        while (raw := follower.latest_request(running.name)) is None:
            pass
        assert msgspec.json.decode(raw)["id"] == "one"
        answer = follower.join(running.name, raw)
        asking.join()
        assert isinstance(answer, Reply) and answer.body["square"] == 49 and answer.plan == b"plan of one"
        assert follower.latest_request(running.name) == raw
        again = follower.join(running.name, raw)
        assert isinstance(again, Reply) and again.body == answer.body
        assert {(each.kind, each.identifier) for each in watched} == {("progress", "one")}


class _Asked:
    """Stands for the procedures of a run, of which only the records are read."""

    def __init__(self, records: dict[GroundCall, Record]) -> None:
        self.records = type("Records", (), {"of": records, "unfinished": {}})()

    def refused_so_far(self) -> dict[GroundCall, Where]:
        return {}


def test_refusals_are_told_by_pair_and_only_when_they_have_changed() -> None:
    call = GroundCall("pick", (Constant("arm"), Constant("cup")))
    refusal = Refusal("collision", "no", pairs=((("arm.hand", "board"), 40),), attempts=40)
    record = Record(failures=1, places=[Where(None, 0, 0, refusal)])  # type: ignore[arg-type]
    told: list[tuple[bytes, bytes | None]] = []
    following = Following(lambda message, plan: told.append((message, plan)))
    following.look()
    assert not told, "nothing is known before there are procedures"
    following.procedures(_Asked({call: record}))  # type: ignore[arg-type]
    for _ in range(3):
        following._next = 0.0
        following.look()
    ((message, plan),) = told
    content = msgspec.json.decode(message)
    assert plan is None and content["format"] == "kabo-follow/1"
    assert content["refused"][0]["pairs"] == [["arm.hand", "board", 40]]
    following.found({"status": "solved"}, b"plan")
    assert told[-1][1] == b"plan" and msgspec.json.decode(told[-1][0])["found"] == {"status": "solved"}
