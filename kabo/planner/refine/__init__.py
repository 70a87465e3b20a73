"""Refinement of a plan: motion is shortened, joined across tasks and retimed; the plan never gets worse."""
