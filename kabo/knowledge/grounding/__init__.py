"""Compiles problems into bits: instances of schemas, queries, updates; static knowledge is evaluated."""
