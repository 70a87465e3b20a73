"""PDDL and contingent PDDL: forms with places, and what their sections say in kabo's formulas."""
