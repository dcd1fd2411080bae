"""Photographs of a drone as shots: place, height, attitude and lens as their files give them.

`folder.read_folder` is the front door; docs/photographs.md lists the tags of each maker.
"""
