"""PKS XML: markup and expressions with places, and what they say in kabo's formulas."""
