"""A city of 400 windows on workers: pace, overhead, memory, killed workers and schedulers."""
