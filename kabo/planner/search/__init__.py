"""Contingent plans over knowledge: AND-OR search, weak plans, solved continuations, nogoods [K 6.2]."""
