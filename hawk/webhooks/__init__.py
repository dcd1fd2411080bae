"""Reports of surveys and layouts to other programs: signed, from the store's outbox, until they are received."""
