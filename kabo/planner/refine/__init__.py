"""Better motion for a plan that was found: joined, shortened and timed across its tasks, never worse."""
