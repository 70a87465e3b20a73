"""Searches in finite-domain tasks, one file each: breadth-first, novelty-guided, A*."""
