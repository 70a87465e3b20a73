"""Kernels of physics: what is computed in each time step."""
