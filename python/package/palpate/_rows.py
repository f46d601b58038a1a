"""The process that works off tasks of a survey: one a line on standard input, its rows and an empty line on standard output."""

import sys

from palpate import _palpate


def main() -> int:
    """Prints a row of each group of each task, until there are no more."""
    for task in sys.stdin.buffer:
        try:
            _palpate.survey_work(task.decode())
        except _palpate.Error as error:
            print(error, file=sys.stderr)
            return error.status
        print(flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
