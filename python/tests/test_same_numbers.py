"""Every question gives what the command gives, bit for bit: JSON numbers come back as the same doubles."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import numpy as np
import palpate
import pytest
from conftest import PRESS, TOP, TRACES, answer, command

ROWS = sorted(TRACES.glob("table-3.1-row-0[123].csv"))


@pytest.mark.parametrize(
    ("law", "options", "words"),
    [
        ("fung", {}, ()),
        ("fung", {"terms": "auto", "separation": "free"}, ("--terms", "auto", "--separation", "free")),
        ("latency-power", {"exponent": 3}, ("--exponent", 3)),
        ("kelvin-voigt", {"tare": True}, ("--tare",)),
        ("fung", {"join_steps": True}, ("--join-steps",)),
    ],
)
def test_fit(law: str, options: dict, words: tuple, tmp_path: Path) -> None:
    found = palpate.fit(palpate.read(PRESS), law, **options)
    path = tmp_path / "model.toml"
    assert found.to_dict() == answer("fit", law, PRESS, *words, "-o", path)
    assert found.model.to_toml() == path.read_text()
    assert found.model == palpate.Model.read(path)


def test_fit_of_several_traces_with_what_is_held_out() -> None:
    found = palpate.fit(ROWS, "fung")
    assert found.to_dict() == answer("fit", "fung", *ROWS)
    assert found.held_out_rms is not None and found.held_out_rms > found.rms / 2


def test_fit_all_and_fit_holds() -> None:
    assert palpate.fit_all(ROWS).to_dict() == answer("fit", "--all", *ROWS)
    holds = palpate.fit_holds(ROWS, terms=2, signs=True)
    assert holds.to_dict() == answer("fit", "fung", *ROWS, "--hold-only", "--terms", 2, "--signs")


def test_heads_travel_with_arrays() -> None:
    """What a head says of the set-up can change a fit; through arrays it is the same fit."""
    traces = palpate.read(ROWS)
    again = [
        palpate.DataSet.from_arrays(
            trace.time, columns={k: v for k, v in trace.to_dict().items() if k != "time_s"}, head=trace.head
        )
        for trace in traces
    ]
    found = palpate.fit(sum(again[1:], again[0]), "fung").to_dict()
    wanted = answer("fit", "fung", *ROWS)
    assert found["parameters"] == wanted["parameters"]
    assert found["residual_rms"] == wanted["residual_rms"]


def test_compare_diagnose_explore_add_drop(practice: Path, model: Path, tmp_path: Path) -> None:
    data, base = palpate.read(practice), palpate.Model.read(model)
    assert palpate.compare(base, data).to_dict() == answer("compare", model, practice)
    found = palpate.diagnose(base, data)
    assert found.to_dict() == answer("diagnose", "--model", model, practice)
    assert (found.verdict, found.effects) == ("named", ["mullins"])
    climbed = palpate.explore(base, data)
    path = tmp_path / "better.toml"
    wanted = answer("explore", "--model", model, practice, "-o", path)
    assert {**climbed.to_dict(), "model": str(path)} == wanted
    assert climbed.model.to_toml() == path.read_text()
    added = palpate.add("mullins", base, data)
    other = tmp_path / "added.toml"
    assert added.to_dict() == answer("add", "mullins", model, practice, "-o", other)
    assert added.model.to_toml() == other.read_text()
    dropped = palpate.drop("mullins", added, data)
    assert dropped.to_dict() == answer("drop", "mullins", other, practice)


def test_discover(practice: Path, model: Path, tmp_path: Path) -> None:
    found = palpate.discover(palpate.Model.read(model), palpate.read(practice))
    path = tmp_path / "found.toml"
    assert found.to_dict() == answer("discover", "--model", model, practice, "-o", path)
    assert found.outcome == "library"
    assert found.model.to_toml() == path.read_text()


def test_decompose(tmp_path: Path) -> None:
    found = palpate.decompose(PRESS)
    assert found.to_dict() == answer("decompose", PRESS, "-o", tmp_path / "split")
    written = palpate.read(tmp_path / "split")[0]
    made = found.data[0]
    assert made.columns == written.columns
    for name in made.columns:
        assert np.array_equal(made[name], written[name]), name
    for signal, part in found.trace(0).items():
        stem = signal.split("_")[0]
        assert np.array_equal(part.fa, written[f"{stem}_fa_ustrain"])
        whole = {name: part.integers(name) for name in ("input", "fa", "sa", "equilibrium", "latent")}
        assert np.array_equal(whole["fa"] + whole["sa"], whole["input"])
        assert np.array_equal(whole["equilibrium"] + whole["latent"], whole["input"])
        assert np.array_equal(whole["fa"] * part.lsb, part.fa)
        assert part.lsb == 2.0**-8


def test_decompose_by_a_model(model: Path) -> None:
    found = palpate.decompose(PRESS, model, signal="force_N")
    assert found.to_dict() == answer("decompose", PRESS, "--model", model, "--signal", "force_N")


def test_segment_and_relaxation() -> None:
    assert palpate.segment(ROWS).to_dict() == answer("segment", *ROWS)
    assert palpate.relaxation(ROWS, terms="auto").to_dict() == answer("relaxation", *ROWS, "--terms", "auto")


def test_simulate(model: Path, press: palpate.DataSet, tmp_path: Path) -> None:
    path = tmp_path / "made.csv"
    with pytest.warns(UserWarning, match="beyond the .* that the model was fitted to"):
        deeper = palpate.DataSet.from_arrays(press[0].time, press[0]["displacement_mm"] * 9)
        palpate.simulate(model, deeper)
    profile = tmp_path / "profile.toml"
    profile.write_text(
        "palpate-profile = 1\nrate_hz = 200.0\nspeed_mm_per_s = 20.0\n[[step]]\nhold_s = 0.2\n[[step]]\nto_mm = 3.0\n"
    )
    for motion in (str(PRESS), str(profile)):
        command("simulate", model, "--motion", motion, "--noise", 0.01, "--seed", 3, "-o", path)
        made, wanted = palpate.simulate(model, motion, noise=0.01, seed=3), palpate.read(path)[0]
        assert made.head == wanted.head
        assert made.columns == wanted.columns
        assert all(np.array_equal(made[name], wanted[name]) for name in made.columns)
        path.unlink()
    force = tmp_path / "force.toml"
    force.write_text(
        "palpate-force-profile = 1\nrate_hz = 200.0\nloading_N_per_s = 1.96\nbandwidth_hz = 5.0\n[[step]]\nto_N = 0.2\n[[step]]\nhold_s = 1.0\n"
    )
    command("simulate", model, "--force", force, "-o", path)
    made, wanted = palpate.simulate(model, force=force), palpate.read(path)[0]
    assert all(np.array_equal(made[name], wanted[name]) for name in wanted.columns)
    in_memory = palpate.simulate(model, press)
    command("simulate", model, "--motion", PRESS, "-o", tmp_path / "press.csv")
    assert np.array_equal(in_memory["force_N"], palpate.read(tmp_path / "press.csv")[0]["force_N"])


def test_plan(model: Path) -> None:
    found = palpate.plan(0.01, want={"v1": 2, "v2": 5})
    assert found.to_dict() == answer("plan", "--noise", 0.01, "--want", "v1=2", "--want", "v2=5")
    found = palpate.plan(0.02, model, compression=8, duration=10)
    wanted = answer("plan", "--noise", 0.02, "--model", model, "--compression", 8, "--duration", 10)
    assert found.to_dict() == wanted
    found = palpate.plan(0.01, shares=[0.25, 0.27], rates=[4, 0.5], force=1.5)
    words = ("--shares", "0.25,0.27", "--rates", "4,0.5", "--force", 1.5)
    assert found.to_dict() == answer("plan", "--noise", 0.01, *words)


def test_hide(practice: Path) -> None:
    made = palpate.hide("mullins", seed=7)
    read = palpate.read(practice)
    assert made.seed == 7 and made.data.names == read.names
    for mine, theirs in zip(made.data, read, strict=True):
        assert mine.head == theirs.head
        assert all(np.array_equal(mine[name], theirs[name]) for name in theirs.columns)
    assert made.truth() == palpate.truth(practice) == answer("hide", "--open", practice)


def test_grasp(model: Path, tmp_path: Path) -> None:
    found = palpate.grasp.surface(
        "rectangle:42.22x26.38", exponent=4, friction=0.7, force=2, tangential=-0.5
    )
    words = ("--contact", "rectangle:42.22x26.38", "--exponent", 4, "--friction", 0.7, "--force", 2)
    assert found.to_dict() == answer("grasp", "surface", *words, "--tangential=-0.5")
    found = palpate.grasp.growth("sphere:35", model, friction=0.7, compression=5)
    words = ("--contact", "sphere:35", "--friction", 0.7, "--compression", 5, "--model", model)
    assert found.to_dict() == answer("grasp", "growth", *words)
    found = palpate.grasp.growth(
        "block:40x25x50:0.48", friction=0.7, force=2, creep=8.1, shares=[-0.0738, -0.214], rates=[0.8229, 0.007805]
    )
    words = ("--contact", "block:40x25x50:0.48", "--friction", 0.7, "--force", 2, "--creep", 8.1)
    words += ("--shares=-0.0738,-0.214", "--rates", "0.8229,0.007805")
    assert found.to_dict() == answer("grasp", "growth", *words)
    slide = palpate.DataSet.from_arrays(
        np.arange(100) / 100,
        force=np.full(100, 2.0),
        columns={"tangential_N": np.linspace(0, 1.3, 100)},
        name="slide.csv",
    )
    path = tmp_path / "slide.csv"
    slide[0].write(path)
    found = palpate.grasp.margin(slide, contact="circle:5", friction=0.7)
    words = (path, "--contact", "circle:5")
    assert found.to_dict() == answer("grasp", "margin", *words, "--friction", 0.7)
    found = palpate.grasp.friction(slide, contact="circle:5", from_=0.5)
    assert found.to_dict() == answer("grasp", "friction", *words, "--from", 0.5)
    hand = sorted((TOP / "tests" / "hands").glob("*.toml"))[0]
    found = palpate.grasp.plan(hand, margin=1.2)
    assert found.to_dict() == answer("grasp", "plan", hand, "--margin", 1.2)


def test_effects_and_laws_of_ones_own(practice: Path, model: Path, tmp_path: Path) -> None:
    assert palpate.effects() == answer("effects")
    own = palpate.Model.read(model).with_law(
        "cogging",
        "sensor",
        "size * sin(2 * PI * x / pitch)",
        {"size": {"value": 0.0, "unit": "N"}, "pitch": {"value": 1.7, "lower": 0.5, "upper": 5.0, "unit": "mm"}},
        meaning="the drive is pulled from pole to pole",
    )
    path = tmp_path / "own.toml"
    own.write(path)
    assert tomllib.loads(path.read_text())["candidate"][0]["name"] == "cogging"
    found = palpate.diagnose(own, practice)
    assert found.to_dict() == answer("diagnose", "--model", path, practice)
    assert "cogging" in {one["effect"] for one in found.to_dict()["candidates"]}


def test_a_law_as_a_python_function_is_the_law_as_an_expression(practice: Path, model: Path) -> None:
    def cogging(x, size, pitch):
        return size * np.sin(2 * np.pi * x / pitch)

    parameters = {"size": {"value": 0.0, "unit": "N"}, "pitch": {"value": 1.7, "lower": 0.5, "upper": 5.0, "unit": "mm"}}
    base = palpate.Model.read(model)
    one = palpate.diagnose(base.with_law("cogging", "sensor", cogging, parameters), practice).to_dict()
    written = "size * sin(2 * PI * x / pitch)"
    other = palpate.diagnose(base.with_law("cogging", "sensor", written, parameters), practice).to_dict()
    assert one == other


def test_a_law_as_a_python_function_may_do_all_that_a_formula_may(model: Path) -> None:
    def law(t, x, v, depth, tau):
        late = palpate.formula.lag(np.maximum(v, 0), tau) + palpate.formula.peak(x) - palpate.formula.total(abs(v)) / palpate.formula.since(palpate.formula.play(x, 0.5))
        return depth * (-late**2 + np.exp(-t) * np.arctan2(x, 1) - +np.square(x))

    found = palpate.Model.read(model).with_law("own", "sensor", law, {"depth": 0.0, "tau": 1.0}).to_dict()["candidate"][0]["expression"]
    late = "((lag(max(v, 0.0), tau) + peak(x)) - (total(abs(v)) / since(play(x, 0.5))))"
    assert found == f"(depth * (((-({late} ^ 2.0)) + (exp((-t)) * atan2(x, 1.0))) - (x ^ 2.0)))"


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (lambda x, size: size if x > 0 else 0, "no branches"),
        (lambda x, size: size * max(x, 0), "no branches"),
        (lambda x, size: size * math.sin(x), "not those of math"),
        (lambda x, y, size: size * x * y, "takes `y`, which is no variable and no parameter; there are t, t_set, x"),
        (lambda x: x, "does not take its parameter `size`"),
        (lambda x, size: np.where(x, size, 0), "no branches"),
        (lambda x, size: [x, size], "of single numbers, not of list"),
    ],
)
def test_a_function_that_is_no_formula_is_refused_in_words(law, words: str, model: Path) -> None:
    with pytest.raises(palpate.Error, match=words):
        palpate.Model.read(model).with_law("own", "sensor", law, {"size": 0.0})
