"""A robot server of a hundred lines, with zenoh and JSON alone: what one in any other language has to do.

    python examples/robot_server/server.py [ENDPOINT [LIMIT]]
    kabo execute domains/stacked/n2.yaml plan.json --on zenoh --endpoint tcp/127.0.0.1:7448

Its robot is where it is sent, and it sees no bodies. Where `hardware` stands in a comment, yours is driven and measured.
"""

import json
import os
import sys
import threading
import time

import zenoh

ROBOTS = {"mobile": [*(f"arm_joint_{k}" for k in range(1, 6)), "finger_joint"]}  # names and order are the scene's
BODIES = ["o1", "o2"]
START = {"mobile": [0.0, -0.34906585, 1.919862177, 1.570796327, 0.0, 0.04]}  # rad and m
TICK, STOPS_IN, NEAR = 0.01, 0.4, 0.01  # s, s, rad or m
NAME = f"example-{os.getpid()}"
KEY = f"kabo/v1/{NAME}/robot"


class RefusedError(Exception):
    """A request that is not obeyed: its code, and why."""


class Server:
    """Whoever drives, the motion that is followed, and where the robots are."""

    def __init__(self, limit):
        self.limit = limit  # s: a client that gives no sign of life for so long drives no more
        self.lock = threading.RLock()  # zenoh calls back from threads of its own
        self.driver = self.halted = self.motion = None
        self.q = {name: list(values) for name, values in START.items()}
        self.v = {name: [0.0] * len(values) for name, values in START.items()}
        self.count, self.heard, self.time, self.at, self.rate, self.slows = 0, 0.0, 0.0, 0.0, 1.0, False
        self.pressing = {}

    # ------------------------------------------------------------------------------------------------------ motion
    def tick(self):
        """Goes on along the motion for 10 ms; a stop slows down its clock, so that robots stay on their paths."""
        if self.driver and self.motion and time.monotonic() - self.heard > self.limit:
            self.let_go(f"client {self.driver} gave no sign of life for {self.limit} s; the robots were stopped")
        self.time += TICK
        self.v = {name: [0.0] * len(values) for name, values in self.q.items()}
        if self.motion is None:
            return
        before, end = self.at, self.motion["end"]
        if self.slows:  # hardware: slow down within your limits of acceleration
            self.rate = max(0.0, self.rate - TICK / STOPS_IN)
        self.at = min(end, self.at + TICK * self.rate)
        for each in self.motion["stretches"]:
            if each["times"][0] <= self.at and each["times"][-1] >= before:
                self.send(each, min(self.at, each["times"][-1]))
        if self.at >= end or self.rate == 0.0:
            self.motion = None

    def send(self, stretch, t):
        """Piece k is a polynomial in the time since times[k], for each joint a list of coefficients."""
        k = max(i for i, begin in enumerate(stretch["times"][:-1]) if begin <= t or i == 0)
        u, robot = t - stretch["times"][k], stretch["robot"]
        for joint, c in zip(stretch["joints"], stretch["coefficients"][k], strict=True):
            j = ROBOTS[robot].index(joint)  # hardware: send the value and the velocity, and measure them
            self.q[robot][j] = sum(a * u**i for i, a in enumerate(c))
            self.v[robot][j] = self.rate * sum(i * a * u ** (i - 1) for i, a in enumerate(c) if i)

    def let_go(self, why):
        """Nobody drives any more; robots that move come to a stop."""
        self.driver, self.halted, self.slows = None, why, True

    def state(self):
        """What is measured."""
        self.count += 1
        found = {"count": self.count, "time": self.time, "motion_time": self.at, "moving": self.motion is not None}
        found |= {"positions": self.q, "velocities": self.v, "pressing": self.pressing, "still": list(ROBOTS)}
        return found | {"bodies": {}, "driver": self.driver, "halted": self.halted}

    # ---------------------------------------------------------------------------------------------------- requests
    def take(self, told):
        """Whom the client drives from now on."""
        if told.get("protocol", "kabo-robot/1") != "kabo-robot/1":
            raise RefusedError("bad_request", f"this server speaks kabo-robot/1, not {told['protocol']}")
        if self.driver not in (None, told["client"]) or self.motion:
            raise RefusedError("busy", "the robots still move" if self.motion else "another client drives")
        self.driver, self.halted, self.heard = told["client"], None, time.monotonic()
        found = {"limit_s": self.limit, "robots": ROBOTS, "bodies": BODIES, "state": self.state()}
        return found | {"protocol": "kabo-robot/1"}

    def follow(self, told):
        """Begins a motion where the robots are; hardware: check limits, too."""
        if self.motion:
            raise RefusedError("bad_request", "a motion is being followed")
        for each in told["stretches"]:
            robot, first = each["robot"], each["coefficients"][0]
            for joint, c in zip(each["joints"], first, strict=True):
                starts = all(
                    joint not in e["joints"] or e["times"][0] >= each["times"][0] for e in told["stretches"]
                )
                if starts and abs(self.q[robot][ROBOTS[robot].index(joint)] - c[0]) > NEAR:
                    raise RefusedError("bad_request", f"{robot}.{joint} is not where the motion begins")
        self.motion, self.at, self.rate, self.slows = told, told["begin"], 1.0, False
        self.heard = time.monotonic()

    def stop(self, told):
        """Comes to a stop on the path."""
        self.slows = True

    def pace(self, told):
        """Late robots are slowed down, if a server can; this one cannot."""
        return {"paced": False, "state": self.state()}

    def leave(self, told):
        """The client drives no more."""
        self.let_go(f"client {told['client']} has left")

    def grip(self, told):
        """A hand presses; hardware: with its force, whatever its width."""
        self.pressing[told["robot"]] = 0.0

    def release(self, told):
        """A hand presses no more."""
        self.pressing.pop(told["robot"], None)

    def look(self, told):
        """Hardware: read a weight [kg] or a contact, by `kind` and `things`."""
        return {"reading": None, "state": self.state()}

    def answer(self, verb, query):
        """Replies in JSON to whatever comes, or with an error."""
        with self.lock, query:
            try:
                told = json.loads(query.payload.to_bytes())
                if verb != "take" and told["client"] != self.driver:
                    raise RefusedError("busy", self.halted or "take the robots first")
                found = getattr(self, verb)(told) or self.state()
                query.reply(f"{KEY}/{verb}", json.dumps(found), encoding="application/json")
            except Exception as error:  # noqa: BLE001 - else a client would believe that nobody is there
                code, why = error.args if isinstance(error, RefusedError) else ("bad_request", repr(error))
                query.reply_err(json.dumps({"code": code, "message": why}), encoding="application/json")

    def beat(self, sample):
        """A sign of life of a client."""
        if str(sample.key_expr).rpartition("/")[2] == self.driver:
            self.heard = time.monotonic()

    def seen(self, sample):
        """A client has come, or its connection has ended."""
        with self.lock:
            if sample.kind == zenoh.SampleKind.DELETE and str(sample.key_expr).rpartition("/")[2] == self.driver:
                self.let_go(f"the connection to client {self.driver} was lost")


def main(endpoint, limit):
    """Serves until it is ended."""
    config, server = zenoh.Config(), Server(limit)
    config.insert_json5("listen/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(config) as session:
        kept = [  # what nobody keeps ends
            session.declare_queryable(f"{KEY}/{verb}", lambda query, verb=verb: server.answer(verb, query))
            for verb in ("take", "follow", "stop", "pace", "leave", "grip", "release", "look")
        ]
        kept.append(session.declare_subscriber(f"{KEY}/driver/*", server.beat))
        kept.append(session.liveliness().declare_subscriber(f"{KEY}/driver/*", server.seen))
        states = session.declare_publisher(f"{KEY}/state", express=True)
        kept.append(session.liveliness().declare_token(f"{KEY}/alive"))  # from now on clients come
        sys.stderr.write(f"{NAME} serves {', '.join(ROBOTS)}\n")
        due = time.monotonic()
        while True:
            with server.lock:
                server.tick()
                states.put(json.dumps(server.state()))
            due = max(due + TICK, time.monotonic())
            time.sleep(due - time.monotonic() if due > time.monotonic() else 0.0)


if __name__ == "__main__":
    given = sys.argv[1:] + ["tcp/127.0.0.1:7448", "0.035"][len(sys.argv) - 1 :]
    main(given[0], float(given[1]))
