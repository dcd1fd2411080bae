"""Flight journal, recording, and the folder of an inbox, on disk."""
