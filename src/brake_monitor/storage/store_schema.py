"""The tables of the memory, one script per version: a file is brought up to date by the scripts it has not seen.

Contents that are read and written whole are JSON, checked against their types when read; what is searched for has a
column of its own. A released script never changes: a new version is a new script at the end. What is added to a
stored structure needs a default, or a version.
"""

APPLICATION_ID = 0x42524D4F  # in the file's header: tells our memory from other SQLite files

VERSIONS: tuple[tuple[str, ...], ...] = (
    (
        "CREATE TABLE meta (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID",
        """CREATE TABLE alarms (
            number INTEGER PRIMARY KEY,
            id TEXT NOT NULL UNIQUE,
            raised_time_s REAL NOT NULL,
            cleared_time_s REAL,
            content TEXT NOT NULL)""",
        "CREATE INDEX alarms_by_time ON alarms (raised_time_s)",
        "CREATE INDEX alarms_open ON alarms (number) WHERE cleared_time_s IS NULL",
        "CREATE TABLE wear (wheelset INTEGER PRIMARY KEY, time_s REAL, content TEXT NOT NULL)",
        """CREATE TABLE gauges (
            number INTEGER PRIMARY KEY,
            wheelset INTEGER NOT NULL,
            content TEXT NOT NULL,
            applied INTEGER NOT NULL DEFAULT 0)""",
        "CREATE TABLE learned (number INTEGER PRIMARY KEY CHECK (number = 1), content TEXT NOT NULL)",
        "CREATE TABLE stops (number INTEGER PRIMARY KEY, start_time_s REAL NOT NULL UNIQUE, content TEXT NOT NULL)",
        "CREATE TABLE outbox (sequence INTEGER PRIMARY KEY, message BLOB NOT NULL)",
    ),
)
