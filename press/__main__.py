"""Run the command line of the book: `python -m press`."""

import sys

from press.cli import main

sys.exit(main())
