"""Why there is no plan, and what would help: failed calls looked at again, changes of the scene that would do."""
