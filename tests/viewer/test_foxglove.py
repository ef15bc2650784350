"""The shipped Foxglove layout names what a run records, and nothing else."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from mmt_drake.cli.main import main
from mmt_drake.model.parameters import THETA
from mmt_drake.recording.messages import ros2_types
from mmt_drake.recording.signals import SIGNALS
from mmt_drake.viewer.foxglove import layout_text, shown


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `run setup1` records."""
    file = tmp_path_factory.mktemp("foxglove") / "out.mcap"
    assert main(["run", "setup1", "--seconds", "0.5", "--record", str(file)]) == 0
    return file


def first_messages(file: Path) -> dict[str, Any]:
    """Topic -> its first message, as a ROS tool reads it."""
    found: dict[str, Any] = {}
    with file.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            if channel.topic not in found and schema is not None:
                found[channel.topic] = ros2_types().deserialize_cdr(message.data, schema.name)
    return found


def test_every_topic_and_field_of_the_layout_is_in_what_run_setup1_records(run: Path) -> None:
    messages = first_messages(run)
    assert len(shown()) > 25
    for topic, field in shown():
        assert topic in messages, topic
        value = messages[topic]
        for name, index in re.findall(r"(\w+)(?:\[(\d+)\])?", field):
            value = getattr(value, name)
            value = value[int(index)] if index else value
        assert field == "" or float(value) == float(value) or topic == "/estimator/theta", (topic, field)


def test_theta_s_labels_are_its_parameters_in_order_in_the_layout_and_in_the_file(run: Path) -> None:
    plots = json.loads(layout_text())["configById"].values()
    labels = {path["value"]: path["label"] for plot in plots for path in plot.get("paths", ())}
    for number, name in enumerate(THETA):
        assert labels[f"/estimator/theta.data[{number}]"].replace(" ", "_").removeprefix("theta_") == name
    with run.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    told = next(channel.metadata for channel in summary.channels.values() if channel.topic == "/estimator/theta")
    assert told["columns"].split(", ") == [f"theta_{name}" for name in THETA] and told["units"].startswith("kg, N/m")


def test_the_layout_shows_panels_that_it_has_and_topics_of_the_conventions() -> None:
    layout = json.loads(layout_text())
    placed = re.findall(r'"(\w+!\w+)"', json.dumps(layout["layout"]).replace("3D!", "ThreeD!"))
    assert sorted(placed) == sorted(name.replace("3D!", "ThreeD!") for name in layout["configById"])
    assert {topic for topic, _ in shown()} <= {signal.topic for signal in SIGNALS} | {"/cloud"}


def test_view_writes_the_layout_and_refuses_what_foxglove_does_not_read(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "layout.json"
    assert main(["view", str(run), "--foxglove", str(target)]) == 0
    assert target.read_text() == layout_text() and capsys.readouterr().out == f"layout: {target}\n"
    table = tmp_path / "out.csv"
    table.write_text("time,position,force\n0,0,0\n1,0,0\n2,0,0\n")
    assert main(["view", str(table), "--foxglove", str(target)]) == 2
    assert main(["view", str(run), "--foxglove", str(tmp_path / "layout.txt")]) == 2
    assert capsys.readouterr().err.count("\n") == 2
