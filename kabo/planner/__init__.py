"""The planner room: contingent search on the knowledge level, with geometry asked lazily or at every node.

It knows knowledge, the geometry server and the plan; not files, sockets or terminals. The function `solve` of the
file `solve.py` is the whole of it: a plan, a proof that there is none and a spent budget are all results. Nothing
is imported here, so that whoever speaks of a `Result` does not load the search.
"""
