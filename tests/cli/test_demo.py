"""`mmt-drake demo`: the main job end to end."""

import os
import re

import pytest
from cli_samples import disk_of

from mmt_drake.analysis.metrics import measure
from mmt_drake.cli.main import main
from mmt_drake.diagrams.proof.experiments.demo import run_demo
from mmt_drake.errors import BadInput
from mmt_drake.recording import load

PICTURES = {
    *("station", "hand", "setup1", "force", "force_delay", "contact_delay"),
    *("parameters", "energy", "energy_delay", "errors"),
}


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """The folder it was started in."""
    folder = tmp_path_factory.mktemp("demo")
    before = os.getcwd()
    os.chdir(folder)
    try:
        assert main(["demo", "--out", "shown"]) == 0
    finally:
        os.chdir(before)
    return folder


def test_it_leaves_two_recordings_ten_figures_and_a_page_and_nothing_outside_out(demo):
    assert [path.name for path in demo.iterdir()] == ["shown"]
    expected = {"setup1.mcap", "setup1_delay.mcap", "index.html", *(f"{name}.png" for name in PICTURES)}
    assert {path.name for path in (demo / "shown").iterdir()} == expected


def test_the_page_shows_every_figure_and_needs_nothing_else(demo):
    text = (demo / "shown" / "index.html").read_text()
    assert text.count('src="data:image/png;base64,') == len(PICTURES)
    assert not re.search(r'(src|href)="(?!data:|#)', text) and "<script" not in text
    assert ".demo-" not in text


def test_what_the_page_says_is_what_the_recordings_hold(demo):
    text = (demo / "shown" / "index.html").read_text()
    near = measure(load(demo / "shown" / "setup1.mcap"))
    far = measure(load(demo / "shown" / "setup1_delay.mcap"), delay_s=0.4)
    assert f"the rendered force is {100.0 * near.rendered_error.tangential['all']:.3g} % off" in text
    assert f"the rendered force is {100.0 * far.rendered_error.tangential['all']:.3g} % off" in text
    assert near.touch.median_s < 0.01 and 0.8 <= far.touch.median_s < 0.81
    assert near.rendered_error.tangential["all"] < far.rendered_error.tangential["all"]


def test_pictures_for_the_readme_are_small(demo):
    for name in ("station", "setup1"):
        assert (demo / "shown" / f"{name}.png").stat().st_size < 150_000


def test_a_folder_that_is_a_file_is_one_line_and_exit_status_2(tmp_path, capsys):
    (tmp_path / "taken").write_text("a file")
    assert main(["demo", "--out", str(tmp_path / "taken")]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.fixture
def small_disk(tmp_path):
    """A disk of 1 MB, made of memory: room for the beginning of one recording."""
    with disk_of("1m", tmp_path / "disk") as disk:
        yield disk


def test_a_disk_that_fills_up_is_one_true_line_and_nothing_is_left(small_disk, capsys):
    out = small_disk / "deep" / "shown"
    assert main(["demo", "--out", str(out)]) == 2
    assert list(small_disk.iterdir()) == []
    line = f"mmt-drake: {out}: found No space left on device, expected room for the demo; nothing of it is kept"
    assert capsys.readouterr().err.splitlines()[-1] == line


@pytest.mark.parametrize("error", [BadInput("made up", found="a fault", expected="none"), KeyboardInterrupt()])
def test_a_demo_that_fails_leaves_an_older_one_as_it_was(error, tmp_path, monkeypatch):
    (tmp_path / "index.html").write_text("older")

    def half_way(scenarios, files, asked, progress):
        for file in files.values():
            file.write_text("half a recording")
        raise error

    monkeypatch.setattr("mmt_drake.diagrams.proof.experiments.demo.run_cases", half_way)
    with pytest.raises(type(error)):
        run_demo(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["index.html"]
    assert (tmp_path / "index.html").read_text() == "older"
