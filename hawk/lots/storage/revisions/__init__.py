"""Steps between versions of the lots' store, one module a version. A step that has shipped never changes.

Before the first step after a release, the baseline takes a copy of the tables as that release made them.
"""
