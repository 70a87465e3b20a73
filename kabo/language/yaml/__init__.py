"""YAML with places, and one grammar for formulas: kabo's own files, from documents to a domain, scene, problem or task."""
