"""Drone decision and control: the operations state machine."""
