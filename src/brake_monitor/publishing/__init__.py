"""Outputs → Zenoh: payloads, what is kept until it is delivered, answers, health."""
