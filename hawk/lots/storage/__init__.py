"""The file of the lots' store: opened, checked, migrated, backed up, restored, and erased from."""
