"""The headless survey: client, scoring, exports."""
