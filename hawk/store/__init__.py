"""Flight journal and recording on disk."""
