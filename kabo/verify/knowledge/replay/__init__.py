"""The second judge of knowledge: replays what kabo's own inference knows at every node of a plan (docs/knowledge.md).

It judges only the plans that possible worlds cannot judge; `worlds/judge.py` says which.
"""

from kabo.verify.knowledge.replay.run import Replay, replay

__all__ = ["Replay", "replay"]
