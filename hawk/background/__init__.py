"""The page's background: map tiles made from a picture of the ground, on a desk before the flight."""
