"""Scripted geometry for tests of the search: which calls are refused, where; every question is counted."""

from collections import Counter


class Scripted:
    """A trace is the tuple of the calls made, with their attempts; the key shows only some of them.

    `refused` maps a call's text to the set of attempts that fail, `tells_apart` lists calls that the key shows.
    """

    start = ()

    def __init__(self, refused=(), attempts=1, tells_apart=(), tests=None):
        self.refused = dict(refused)
        self.attempts = attempts
        self.tells_apart = set(tells_apart)
        self.tests = tests or {}
        self.asked = Counter()

    def options(self, call, trace):
        self.asked[str(call)] += 1
        failing = self.refused.get(str(call), ())
        return [(n, (*trace, (str(call), n))) for n in range(self.attempts) if n not in failing]

    def key(self, trace):
        return tuple(entry for entry in trace if entry[0] in self.tells_apart)

    def test(self, call, trace):
        return self.tests.get(str(call), lambda trace: True)(trace)

    def confirm(self, trace):
        return True

    def refused_everywhere(self):
        return frozenset(), False

    def learnt(self):
        return None
