"""Search in finite-domain tasks: operators on variables with finitely many values, packed into machine words."""
