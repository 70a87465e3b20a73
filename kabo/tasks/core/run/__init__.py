"""One planning run of a task: nodes, jobs, the scheduler and its strategies [T 3.6]."""
