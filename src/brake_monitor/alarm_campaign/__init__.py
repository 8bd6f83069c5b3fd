"""Which alarms come, and how soon, against which are due by the plant's truth; and what is said of ordinary service."""
