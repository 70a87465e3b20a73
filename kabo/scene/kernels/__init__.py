"""Array kernels of the scene: poses along a kinematic tree."""
