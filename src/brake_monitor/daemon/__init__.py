"""The service on the gateway: threads, time and systemd around the one path."""
