"""MAVLink on the wire: frames, senders, datagrams."""
