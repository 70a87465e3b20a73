"""Why there is no plan, and what would help: failed calls are examined, and changes of the scene are tried."""
