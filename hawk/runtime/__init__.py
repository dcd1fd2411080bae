"""The process: its log, its supervision, its files, its computer."""
