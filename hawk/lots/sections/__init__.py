"""Sections of lots: given in a file, flown over, and listed with what surveys saw of them."""
