"""Whether kabo's knowledge is complete for a problem; only then does an exhausted search prove that there is no plan."""
