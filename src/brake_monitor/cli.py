"""The command line."""


def main() -> int:
    """Run the command; placeholder until the commands exist."""
    return 0
