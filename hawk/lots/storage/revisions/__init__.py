"""Steps between versions of the lots' store, one module a version. A step that has shipped never changes."""
