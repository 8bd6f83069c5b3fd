"""`python -m brake_monitor COMMAND …`."""

import sys

from brake_monitor.cli import main

sys.exit(main())
