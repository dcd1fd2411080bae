"""Fuzzed input at the daemon's front door: HTTP, WebSocket frames, and messages of operators."""
