"""Compiled kernels of finite-domain search: functions on numbers and arrays, without objects or exceptions."""
