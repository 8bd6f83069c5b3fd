"""Counts of things in words."""


def plural(count: int, thing: str) -> str:
    """`1 alarm`, `3 alarms`; of several words the last one is the thing: `2 brake applications`."""
    return f"{count} {thing}{'' if count == 1 else 's'}"
