"""PDDL and contingent PDDL: parses forms, and translates their sections into kabo's formulas with source places."""
