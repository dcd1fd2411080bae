"""The daemon on a small computer: one core, 1 GiB, a lot of three hectares."""
