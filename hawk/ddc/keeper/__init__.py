"""One keeper: everything that we set or require in the autopilot is compared again and again, and put back."""
