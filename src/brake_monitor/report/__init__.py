"""One file that tells all of a recording: words, figures to zoom into, applications, alarms, wear, data quality."""
