"""Live pictures to many viewers: hawk's server beside µStreamer."""
