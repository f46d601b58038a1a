"""`python -m palpate.survey … --engine tcp://scheduler:8786` is `palpate survey …` on a cluster of Dask."""

import sys
from types import ModuleType
from typing import cast

from palpate import _palpate
from palpate._survey import fill, survey

ENGINE = "--engine"


def main() -> int:
    """Asks as the command does, by the engine that is named, and gives the exit status of the command."""
    words, engine = _engine_of(sys.argv[1:])
    if engine is None:
        from palpate import _command

        sys.argv[:] = ["palpate", "survey", *words]
        return _command.main()
    try:
        native = _palpate.Survey.called(words)
        fill(native, engine)
        native.tell()
    except _palpate.Error as error:
        print(f"error: {error}", file=sys.stderr)
        return error.status
    except KeyboardInterrupt:
        return 130
    return 0


def _engine_of(words: list[str]) -> tuple[list[str], str | None]:
    """The words of the command, and the address of the engine."""
    for place, word in enumerate(words):
        if word.startswith(ENGINE + "="):
            return words[:place] + words[place + 1 :], word[len(ENGINE) + 1 :]
        if word == ENGINE and place + 1 < len(words):
            return words[:place] + words[place + 2 :], words[place + 1]
    return words, None


if __name__ == "__main__":
    sys.exit(main())
else:
    # `import palpate.survey` must not put this module in the place of the function.
    sys.modules[__name__] = cast(ModuleType, survey)
