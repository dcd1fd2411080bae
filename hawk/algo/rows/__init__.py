"""Rows of stalls as objects: found stalls and weak evidence → rows of aligned stalls."""
