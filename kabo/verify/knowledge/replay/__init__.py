"""The second judge of knowledge: computes anew what kabo's inference knows at every node of a plan.

Source: docs/explanation/knowledge.md.

It judges only plans that possible worlds cannot judge; `worlds/judge.py` says which.
"""

from kabo.verify.knowledge.replay.run import Replay, replay

__all__ = ["Replay", "replay"]
