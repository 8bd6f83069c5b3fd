"""One module per command: SUMMARY, DESCRIPTION and EPILOG of its help, `add_options`, `run(options) -> exit code`."""
