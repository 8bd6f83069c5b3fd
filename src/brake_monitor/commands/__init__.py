"""One module per command: DESCRIPTION and EPILOG of its help, `add_options`, `run(options) -> exit code`."""
