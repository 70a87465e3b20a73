"""Grounds problems on bits: schemas become instances, formulas queries, effects updates; static facts are evaluated."""
