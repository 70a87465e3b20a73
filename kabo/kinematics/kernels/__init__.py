"""Array kernels of the kinematics: constraint rows, projection, streams of random numbers, proofs."""
