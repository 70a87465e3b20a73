"""Kernels on arrays for collision checks: boxes, separation of convex sets, sweeps."""
