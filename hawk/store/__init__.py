"""What is kept on disk: the flight journal and the recording."""
