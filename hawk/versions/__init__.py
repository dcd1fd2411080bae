"""The versions of this program on a drone's computer: which is in force, which is kept, and when one may be switched.

The Debian package runs this room by Debian's own Python, so that a version that does not start can be left. It imports
the standard library only.
"""
