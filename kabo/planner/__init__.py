"""The planner room: contingent search on the knowledge level, with geometry asked lazily or at every node.

It uses knowledge, the geometry server and the plan; it knows nothing of files, sockets or terminals. The entry is
`solve` in `solve.py`: a plan, a proof that there is none, and a spent budget are all results. This file imports
nothing, so that code which only needs the type `Result` does not load the search.
"""
