"""The knowledge half of the verifier: judges a plan in all possible worlds, or by replaying kabo's inference.

A verdict relies on the code in `worlds/` and in the modules of this folder, which read formulas and effects.
`replay/` judges only plans that cannot be judged in worlds; the report then says so, with the reason.
"""

from kabo.verify.knowledge.judging import KnowledgeReport, check_knowledge, validate_worlds

__all__ = ["KnowledgeReport", "check_knowledge", "validate_worlds"]
