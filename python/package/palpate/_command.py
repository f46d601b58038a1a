"""The command `palpate`, as `pip install` puts it on the path."""

import signal
import sys

from palpate import _palpate


def main() -> int:
    """Runs the command line of this process and gives its exit status."""
    # The command has its own way to end in order; Python's would wait for it.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    return _palpate.run(sys.argv)


if __name__ == "__main__":
    sys.exit(main())
