"""The knowledge half of the verifier: possible worlds judge a plan, or a replay of kabo's inference where they cannot.

`worlds/` must be trusted, together with the files beside this one, which read formulas and effects. `replay/` judges
only plans that worlds cannot judge; the report then says so, with the reason.
"""

from kabo.verify.knowledge.judging import KnowledgeReport, check_knowledge, validate_worlds

__all__ = ["KnowledgeReport", "check_knowledge", "validate_worlds"]
