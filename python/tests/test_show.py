"""Answers as frames, tables and plots."""

from __future__ import annotations

import csv
from pathlib import Path

import matplotlib
import palpate
import pytest
from conftest import PRESS, TRACES, command
from palpate import _drawn

matplotlib.use("Agg")
ROWS = sorted(TRACES.glob("table-3.1-row-0[123].csv"))


def answers(practice: Path, model: Path) -> dict[str, palpate.Answer]:
    return {
        "fit": palpate.fit(ROWS),
        "holds": palpate.fit_holds(ROWS),
        "ranking": palpate.fit_all(ROWS),
        "comparison": palpate.compare(model, practice),
        "diagnosis": palpate.diagnose(model, practice),
        "change": palpate.add("mullins", model, practice),
        "decomposition": palpate.decompose(PRESS),
        "segmentation": palpate.segment(ROWS),
        "relaxation": palpate.relaxation(ROWS),
        "plan": palpate.plan(0.01),
        "surface": palpate.grasp.surface("circle:5", friction=0.7, force=2),
    }


def test_every_answer_is_a_frame_a_table_and_a_plot(practice: Path, model: Path, tmp_path: Path) -> None:
    for name, found in answers(practice, model).items():
        frame = found.to_frame()
        assert len(frame) > 0 and len(frame.columns) > 1, name
        html = found._repr_html_()
        assert "<table>" in html and "<script" not in html, name
        assert len(html) < 2_000_000, f"{name}: {len(html)} characters in a notebook's cell"
        assert str(found), name
        if name not in ("plan",):
            assert 'src="data:image/svg+xml;base64,' in html, name
            picture = tmp_path / f"{name}.png"
            found.plot().savefig(picture)
            assert picture.stat().st_size > 5_000, name


def test_all_figures_of_a_comparison_can_be_drawn(practice: Path, model: Path, tmp_path: Path) -> None:
    found = palpate.compare(model, practice)
    figures = _drawn.figures(found.sections())
    count = len(figures)
    assert count > 10
    for which, figure in enumerate(figures):
        found.plot(which).savefig(tmp_path / "one.png")
        drawn = found.plot_data(which)
        if figure["kind"] == "panels":
            assert len(drawn) == sum(len(series["x"]) for plot in figure["plots"] for series in plot["series"])
        else:
            across, down = ("groups", "series") if figure["kind"] == "bars" else ("columns", "rows")
            assert len(drawn) == len(figure[across]) * len(figure[down])
    with pytest.raises(palpate.Error, match=f"figure {count} of {count}"):
        found.plot(count)
    with pytest.raises(palpate.Error, match="nothing is drawn"):
        palpate.plan(0.01).plot()


def test_a_plot_has_the_samples_of_the_report(press: palpate.DataSet) -> None:
    found = palpate.decompose(press, signal="gauge1_ustrain")
    lines = {line.get_label(): line for line in found.plot().axes[0].lines}
    assert list(lines["FA"].get_ydata()) == list(found["gauge1_ustrain"].fa)
    assert press[0].plot().axes[0].lines[0].get_xdata().tolist() == press[0].time.tolist()


def test_what_an_answer_says_is_typed(practice: Path, model: Path) -> None:
    found = palpate.fit(ROWS)
    p = found.parameters["p"]
    assert p.value == found.model.parameters["p"] and p.standard_error is not None and p.standard_error > 0
    assert found.law == "fung" and found.unit == "N" and found.converged and 0.5 < found.r_squared <= 1
    diagnosis = palpate.diagnose(model, practice)
    (step,) = diagnosis.steps
    assert step.effect == "mullins" and "mullins" in step.credible_set
    assert step.rms[1] < step.rms[0] and step.held_out_rms[1] < step.held_out_rms[0]
    change = palpate.add("mullins", model, practice)
    assert change.rms[1] < change.rms[0] and "mullins" in change.parameters
    assert change.model.effects == ["mullins"]


def test_the_numbers_of_a_figure_go_through_csv_as_they_are(tmp_path: Path) -> None:
    found = palpate.fit(PRESS)
    plot = _drawn.chosen(found.sections(), 0)["plots"][0]
    drawn = found.plot_data()
    drawn.to_csv(tmp_path / "figure.csv", index=False)
    with open(tmp_path / "figure.csv", newline="") as file:
        back = list(csv.DictReader(file))
    series = plot["series"][0]
    mine = [row for row in back if (row["plot"], row["series"]) == (plot["title"], series["name"])]
    for axis in ("x", "y"):
        column = f"{plot[axis]['label']} ({plot[axis]['unit']})"
        assert [float(row[column]) for row in mine] == series[axis].tolist()


def test_the_frame_of_a_fit_has_its_numbers_as_they_are() -> None:
    found = palpate.fit(ROWS)
    frame = found.to_frame().set_index("parameter")
    assert frame.loc["v1", "value"] == found.parameters["v1"].value
    parts = palpate.decompose(PRESS).to_frame()
    assert len(parts) == 4 * len(palpate.read(PRESS)[0])
    assert ((parts.fa + parts.sa) == parts.input).all()


def test_traces_and_models_show_themselves(model: Path) -> None:
    data = palpate.read(ROWS)
    assert "table-3.1-row-01.csv" in data._repr_html_() and "3 traces" in repr(data)
    assert "<td>p</td>" in palpate.Model.read(model)._repr_html_()
    assert len(data.to_frame()) == sum(map(len, data))


def test_the_report_is_that_of_the_command(tmp_path: Path) -> None:
    mine, theirs = tmp_path / "mine.html", tmp_path / "theirs.html"
    palpate.fit(PRESS).report(mine)
    command("fit", "fung", PRESS, "--report", theirs)
    mine_text, theirs_text = mine.read_text(), theirs.read_text()
    # Only the footer says how it was made: from Python no command is told.
    assert theirs_text.replace(theirs_text.split("<p>Again with:</p>")[1].split("</footer>")[0], "").replace(
        "<p>Again with:</p>", ""
    ) == mine_text
    palpate.fit(PRESS).report(mine)


def test_an_answer_without_a_table_says_so() -> None:
    hand = Path(__file__).parents[2] / "tests" / "hands" / "two-fingers.toml"
    with pytest.raises(NotImplementedError, match="see to_dict"):
        palpate.grasp.plan(hand).to_frame()
