"""On a data set that LeRobot itself writes and reads again."""

import lerobot
import numpy as np
import palpate
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from palpate import lerobot as touch

FPS = 50
FRAMES = 600


def strain(episode: int, gauge: int) -> np.ndarray:
    """A press from 3 s on that is held until 8 s; each gauge and episode with its own strength."""
    time = np.arange(FRAMES) / FPS
    height = (300 + 100 * gauge) * (1 + episode)
    return (height * np.clip((time - 3) * 4, 0, 1) * (time < 8)).astype(np.float32)


@pytest.fixture(scope="module")
def grasps(tmp_path_factory):
    """Two episodes with two joints and two gauges in one feature."""
    names = ["shoulder", "gauge_left", "elbow", "gauge_right"]
    state = {"dtype": "float32", "shape": (4,), "names": names}
    root = tmp_path_factory.mktemp("lerobot") / "grasps"
    made = LeRobotDataset.create(
        "me/grasps", fps=FPS, features={"observation.state": state}, root=root, use_videos=False
    )
    for episode in range(2):
        left, right = (strain(episode, gauge) for gauge in range(2))
        for frame in range(FRAMES):
            row = np.array([frame, left[frame], -frame, right[frame]], np.float32)
            made.add_frame({"observation.state": row, "task": "press"})
        made.save_episode()
    made.finalize()
    return LeRobotDataset("me/grasps", root=root)


def test_the_version_is_the_one_that_the_page_names():
    assert lerobot.__version__ == "0.4.4"


def test_a_new_data_set_has_what_the_filter_of_the_device_makes_of_every_episode(grasps, tmp_path):
    where = {"output_dir": tmp_path / "touched", "repo_id": "me/touched"}
    added = touch.add_touch(grasps, "observation.state", take=["gauge_left", 3], **where)
    again = LeRobotDataset("me/touched", root=tmp_path / "touched")
    assert len(again) == len(added) == len(grasps) == 2 * FRAMES
    assert again.meta.features[touch.FA]["names"] == ["gauge_left", "gauge_right"]
    assert set(again.meta.features) - set(grasps.meta.features) == {touch.FA, touch.SA, touch.EVENT}
    stats = again.meta.stats
    assert stats[touch.FA]["max"].shape == (2,) and stats[touch.EVENT]["min"][0] == -1
    time = np.asarray(grasps.hf_dataset.with_format("numpy")[:FRAMES]["timestamp"], np.float64)
    for episode in range(2):
        frames = [again[episode * FRAMES + frame] for frame in range(FRAMES)]
        fa, sa, event = (
            np.array([frame[name].numpy() for frame in frames])
            for name in (touch.FA, touch.SA, touch.EVENT)
        )
        for gauge in range(2):
            column = {"gauge1_ustrain": strain(episode, gauge)}
            alone = palpate.decompose(palpate.DataSet.from_arrays(time, columns=column))
            part = alone["gauge1_ustrain"]
            assert (fa[:, gauge] == part.fa.astype(np.float32)).all()
            assert (sa[:, gauge] == part.sa.astype(np.float32)).all()
            assert np.abs(fa[:, gauge] + sa[:, gauge] - strain(episode, gauge)).max() < 0.01
            touched, left = (np.flatnonzero(event[:, gauge] == kind) / FPS for kind in (1, -1))
            assert len(touched) == len(left) == 1
            assert abs(touched[0] - 3.0) < 0.3 and abs(left[0] - 8.0) < 0.3, (touched, left)
        assert all((frame["observation.state"][0] == k).all() for k, frame in enumerate(frames))


def test_what_is_not_there_is_named(grasps):
    with pytest.raises(palpate.Error, match="no feature `gauges`; it has: .*observation.state"):
        touch.features(grasps, "gauges")
    with pytest.raises(palpate.Error, match="no element 'gauge_middle'; it has: shoulder, g"):
        touch.features(grasps, "observation.state", take=["gauge_middle"])
