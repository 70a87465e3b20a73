"""Possible worlds: the judge of knowledge, and the part of the verifier's knowledge half that must be trusted.

The plan is executed in every world that the initial knowledge allows. `judge.py` contains the main algorithm;
`queries.py` defines K, Kw and Kv on a set of worlds, `acts.py` the effects of actions on it, `initial.py` the
worlds at the start.
"""

from kabo.verify.knowledge.worlds.judge import Judgement, judge_in_worlds
from kabo.verify.knowledge.worlds.world import CannotJudgeError

__all__ = ["CannotJudgeError", "Judgement", "judge_in_worlds"]
