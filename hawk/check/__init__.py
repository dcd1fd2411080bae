"""Looks at a drone's computer before the daemon starts (``hawk-drone check``), and collects what a bug report needs
(``hawk-drone doctor``). It sends nothing that arms, moves or changes the drone.
"""
