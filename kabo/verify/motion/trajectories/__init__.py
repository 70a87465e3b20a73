"""Judges trajectories: polynomials in time, their deviation from the proven path, and the limits that they must keep."""
