"""The place's witness over drawn flights: how late it doubts a walk of GNSS, whether it doubts an honest receiver."""
