"""palpate from Python: fit contact models to recordings of touch, see where they fail, name what they lack.

    import palpate
    data = palpate.read("traces/")
    model = palpate.fit(data, "fung").model
    palpate.diagnose(model, data).verdict

Same numbers as the command `palpate`, bit for bit: both are the same compiled code.
"""

from palpate import formula, grasp
from palpate._answers import (
    Answer,
    Change,
    Comparison,
    Diagnosis,
    Discovery,
    Exploration,
    Fit,
    HoldFits,
    Parameter,
    Plan,
    Ranking,
    Relaxation,
    Segmentation,
    Step,
)
from palpate._ask import (
    add,
    compare,
    decompose,
    diagnose,
    discover,
    drop,
    explore,
    fit,
    fit_all,
    fit_holds,
    plan,
    relaxation,
    segment,
    simulate,
)
from palpate._data import DataSet, Trace, read
from palpate._device import Block, Device
from palpate._foreign import import_, suggest
from palpate._model import Model, effects
from palpate._palpate import Error, __version__
from palpate._parts import Decomposition, Part
from palpate._practice import Practice, hide, truth
from palpate._progress import progress
from palpate._survey import Survey, survey

__all__ = [
    "Answer",
    "Block",
    "Change",
    "Comparison",
    "DataSet",
    "Decomposition",
    "Device",
    "Diagnosis",
    "Error",
    "Discovery",
    "Exploration",
    "Fit",
    "HoldFits",
    "Model",
    "Parameter",
    "Part",
    "Plan",
    "Practice",
    "Ranking",
    "Relaxation",
    "Segmentation",
    "Step",
    "Survey",
    "Trace",
    "__version__",
    "add",
    "compare",
    "decompose",
    "diagnose",
    "discover",
    "drop",
    "effects",
    "explore",
    "fit",
    "fit_all",
    "fit_holds",
    "formula",
    "grasp",
    "hide",
    "import_",
    "plan",
    "progress",
    "read",
    "relaxation",
    "segment",
    "simulate",
    "suggest",
    "survey",
    "truth",
]
