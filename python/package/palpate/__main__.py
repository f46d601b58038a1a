"""`python -m palpate` is the command `palpate`."""

import sys

from palpate._command import main

sys.exit(main())
