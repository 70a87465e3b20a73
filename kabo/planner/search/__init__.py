"""Contingent search over knowledge states: AND-OR search, weak plans, solved continuations, nogoods [K 6.2]."""
