"""What code knows, written into docs/reference/ as Markdown: options, keys, procedures, stages, messages, the Python API.

    python -m scripts.reference

A page holds sections between two marks, `<!-- python -m scripts.reference: NAME -->` and `<!-- to here -->`; what stands
between them is replaced, and the rest of the page is left as somebody wrote it. tests/scripts/test_reference.py compares.
"""
