"""Which alarms come, and how soon, against those due by the plant's truth; and false alarms in ordinary service."""
