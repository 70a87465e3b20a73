"""Limits of explorations, and how valid parameters must be unless told otherwise: what readers of files know, too."""

LARGEST_NUMBER = 1e100  # absolute value: its square is finite
MOST_PARAMETERS = 6  # more would need more trials than can be made
MOST_CASES = 10_000  # a product of the variables' values grows fast, and each case takes memory
OPTION_BOUNDS = 0.01, 10.0  # of scale and noise of the model of validity
INFERRED_ALPHA = 0.95  # V of parameters for a wanted outcome must be greater [T 4.4.1]
