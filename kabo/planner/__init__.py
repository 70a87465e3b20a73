"""The planner: contingent search on the knowledge level, with procedure calls made lazily or at every node.

It imports knowledge, the geometry server and the plan, and uses no files, sockets or terminals. The entry point is
`solve` in `solve.py`, which returns a plan, a proof that there is none, or the budget that was spent. This file
imports nothing, so that code which only needs the type `Result` does not load the search.
"""
