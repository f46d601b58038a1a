"""FA, SA, touch and release as features of a LeRobot data set (v3.0).

    from lerobot.datasets.lerobot_dataset import LeRobotDataset
    from palpate import lerobot

    grasps = LeRobotDataset("me/grasps")
    out = {"output_dir": "grasps-touched", "repo_id": "me/grasps-touched"}
    touched = lerobot.add_touch(grasps, "observation.gauges", **out)

The new data set is written by LeRobot itself; nothing of the old one is changed. `features` alone
needs no LeRobot.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

from palpate._ask import decompose
from palpate._data import DataSet
from palpate._model import AnyModel
from palpate._palpate import Error
from palpate._parts import Part

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

#: What the new features are called.
FA, SA, EVENT = "observation.touch.fa", "observation.touch.sa", "observation.touch.event"
#: Regions in which there is contact: AB, BC, CD and DE.
_CONTACT = (2, 3, 4, 5)


def features(
    dataset: Any,
    gauges: str,
    *,
    take: Sequence[int | str] | None = None,
    microstrain: float = 1.0,
    model: AnyModel | None = None,
) -> dict[str, tuple[npt.NDArray[Any], dict[str, Any]]]:
    """What a data set's gauges felt, frame by frame, as LeRobot's `add_features` takes it.

    `gauges` is the feature that holds the strains, one of which is `microstrain` µε; `take` are
    those of its elements that are gauges, by place or by name, where it holds others too. Each
    episode is split by the filter of the device at the rate of the data set, with the relaxation
    function of `model`, or that of eq. 3.6.

    - `observation.touch.fa`, `observation.touch.sa`: the fast and the slow adapting part of each
      gauge, µε; their sum is the strain.
    - `observation.touch.event`: 1 in the frame in which a gauge comes into contact, −1 in which it
      is let go, else 0. Slips are jolts of milliseconds: no data set of some 30 frames a second
      holds them; a recording of the device does.
    """
    import numpy as np

    names = _names(dataset, gauges)
    wanted = range(len(names)) if take is None else take
    places = [_place(one, names, gauges) for one in wanted]
    columns = ["episode_index", "timestamp", gauges]
    frames = dataset.hf_dataset.with_format("numpy", columns=columns)[:]
    episodes = np.asarray(frames["episode_index"]).reshape(-1)
    time = np.asarray(frames["timestamp"], np.float64).reshape(-1)
    values = np.asarray(frames[gauges], np.float64).reshape(len(episodes), -1)
    strains = values[:, places] * microstrain
    fa, sa = (np.empty(strains.shape, np.float32) for _ in range(2))
    events = np.zeros(strains.shape, np.int64)
    for episode in np.unique(episodes):
        at = np.flatnonzero(episodes == episode)
        parts = _parts(int(episode), time[at], strains[at], model)
        for gauge, part in enumerate(parts):
            fa[at, gauge], sa[at, gauge] = part.fa, part.sa
            contact = np.isin(part.region, _CONTACT).astype(np.int64)
            events[at, gauge] = np.diff(contact, prepend=0)
    told = [names[place] for place in places]

    def info(kind: str, values: npt.NDArray[Any]) -> dict[str, Any]:
        return {"dtype": kind, "shape": (values.shape[1],), "names": told}

    return {
        FA: (fa, info("float32", fa)),
        SA: (sa, info("float32", sa)),
        EVENT: (events, info("int64", events)),
    }


def add_touch(
    dataset: Any,
    gauges: str,
    output_dir: str | PathLike[str],
    *,
    repo_id: str,
    take: Sequence[int | str] | None = None,
    microstrain: float = 1.0,
    model: AnyModel | None = None,
) -> Any:
    """A new LeRobot data set in `output_dir`: all that `dataset` has and what `features` finds.

    Needs LeRobot 0.4, and all episodes of `dataset`.
    """
    from lerobot.datasets.compute_stats import get_feature_stats
    from lerobot.datasets.dataset_tools import add_features
    from lerobot.datasets.utils import write_stats

    if len(dataset.hf_dataset) != dataset.meta.total_frames:
        raise Error("only some episodes are loaded; open the data set without `episodes`")
    added = features(dataset, gauges, take=take, microstrain=microstrain, model=model)
    by_frame = {name: (_by_index(values), info) for name, (values, info) in added.items()}
    made = add_features(dataset, by_frame, output_dir=output_dir, repo_id=repo_id)
    stats = dict(made.meta.stats or {})
    for name, (values, _) in added.items():
        stats[name] = get_feature_stats(values, axis=0, keepdims=False)
    write_stats(stats, made.root)
    made.meta.stats = stats
    return made


def _by_index(values: npt.NDArray[Any]) -> Callable[[dict[str, Any], int, int], npt.NDArray[Any]]:
    """Rows one by one: of arrays, LeRobot 0.4 adds only those with one column."""
    return lambda row, _episode, _frame: values[int(row["index"])]


def _names(dataset: Any, gauges: str) -> list[str]:
    """The elements of a feature by name, or by place where it has none."""
    all_features = dataset.meta.features
    if gauges not in all_features:
        there = ", ".join(sorted(all_features))
        raise Error(f"the data set has no feature `{gauges}`; it has: {there}")
    feature = all_features[gauges]
    if len(feature["shape"]) != 1 or not str(feature["dtype"]).startswith(("float", "int")):
        what = f"{feature['dtype']} of shape {tuple(feature['shape'])}"
        raise Error(f"`{gauges}` is no row of numbers: {what}")
    names = feature.get("names")
    if isinstance(names, dict):
        names = [name for part in names.values() for name in part]
    count = feature["shape"][0]
    known = names if names and len(names) == count else range(count)
    return [str(name) for name in known]


def _place(one: int | str, names: list[str], gauges: str) -> int:
    if isinstance(one, str) and one in names:
        return names.index(one)
    if isinstance(one, int) and 0 <= one < len(names):
        return one
    raise Error(f"`{gauges}` has no element {one!r}; it has: {', '.join(names)}")


def _parts(
    episode: int,
    time: npt.NDArray[np.float64],
    strains: npt.NDArray[np.float64],
    model: AnyModel | None,
) -> list[Part]:
    names = [f"gauge{gauge + 1}_ustrain" for gauge in range(strains.shape[1])]
    columns = dict(zip(names, strains.T, strict=True))
    try:
        found = decompose(DataSet.from_arrays(time, columns=columns), model, signal=names)
    except Error as error:
        raise Error(f"episode {episode}: {error}") from error
    return [found[name] for name in names]
