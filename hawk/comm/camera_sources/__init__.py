"""Where pictures come from: one module for each kind of source, all with the same face."""
