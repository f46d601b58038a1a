"""The process that works off one task of a survey: the task on standard input, its rows on standard output."""

import sys

from palpate import _palpate


def main() -> int:
    """Prints a row of each group of the task."""
    try:
        _palpate.survey_work(sys.stdin.buffer.read().decode())
    except _palpate.Error as error:
        print(error, file=sys.stderr)
        return error.status
    return 0


if __name__ == "__main__":
    sys.exit(main())
