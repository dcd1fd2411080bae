"""A city's pictures as one survey: windows on many workers, each result kept in a file of its own."""
