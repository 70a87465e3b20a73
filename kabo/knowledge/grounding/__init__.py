"""From a problem to bits: schemas become instances, formulas queries, effects updates; static knowledge is evaluated."""
