"""Plans of lots, corrected by persons: operations, edits with undo and redo, and each version as it was."""
