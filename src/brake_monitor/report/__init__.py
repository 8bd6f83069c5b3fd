"""One file that tells all of a recording: words, figures that can be zoomed, stops, alarms, wear, data quality."""
