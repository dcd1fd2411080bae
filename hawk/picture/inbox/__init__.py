"""A folder of pictures as it is filled: each flight in it becomes a survey of the store."""
