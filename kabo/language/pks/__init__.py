"""PKS XML files: parses markup and expressions, and translates them into kabo's formulas with source places."""
