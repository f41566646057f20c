"""Run the command line: `python -m msc`."""

import sys

from msc.cli import main

sys.exit(main())
