"""Array kernels of collision checks: boxes, separation of convex sets, sweeps."""
