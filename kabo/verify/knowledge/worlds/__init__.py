"""Possible worlds: the judge of knowledge, and the part of the verifier's knowledge half that must be trusted.

A plan is led through every world that the initial knowledge allows. `judge.py` is the whole idea; `queries.py` says what
K, Kw and Kv mean for a set of worlds, `acts.py` what actions do to it, `initial.py` which worlds there are.
"""

from kabo.verify.knowledge.worlds.judge import Judgement, judge_in_worlds
from kabo.verify.knowledge.worlds.world import CannotJudgeError

__all__ = ["CannotJudgeError", "Judgement", "judge_in_worlds"]
