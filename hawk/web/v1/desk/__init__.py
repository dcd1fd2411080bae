"""What drones and programs send to a desk: documents, files of the inbox, and the log of both."""
