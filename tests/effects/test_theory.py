"""Theory pages: in step with the sources, complete, linked both ways, and drawn from what the kernels compute."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from theory import INDEX, pages, theory
from theory_pictures import picture

from mmt_drake.effects import LIBRARY, register_file
from mmt_drake.errors import BadInput

NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
LINK = re.compile(r"\]\(([^)#:]+)\)")
OWN = '''
"""A spring of the fifth power.

k5 d^5 beside the contact spring.

Easily confused with:

- `{other}`: alike in strokes of
  one size.
"""

from mmt_drake.effects import Effect, Parameter
from mmt_drake.model.laws import Slot, law


@law(Slot.CONTACT)
def quintic(at, q, p):
    return p[0] * at.d**5, 0.0, 0.0, 0.0


EFFECT = Effect(
    name="fifth_power",
    block="contact",
    parameters=(Parameter("k5", "N/m^5", (0.0, 1e12)),),
    equation="k5 |d|^5 sgn d",
    source="mine",
    law=quintic,
    starts=lambda scales: [{{"k5": 1e10}}],
)
'''


@pytest.fixture(scope="module")
def made():
    return pages(LIBRARY)


@pytest.fixture
def own(tmp_path):
    def write(other):
        path = tmp_path / "own.py"
        path.write_text(OWN.format(other=other))
        return path

    yield write
    LIBRARY.pop("fifth_power", None)


def lines(svg, color):
    """Points (n, 2) of the lines of a colour, panel by panel, in points of the page, up positive."""
    paths = ElementTree.fromstring(svg).iter("{http://www.w3.org/2000/svg}path")
    drawn = [
        path.get("d") for path in paths if f"stroke: {color.lower()}" in path.get("style", "") and path.get("clip-path")
    ]
    tables = [np.array(NUMBER.findall(d), dtype=float).reshape(-1, 2) * [1.0, -1.0] for d in drawn]
    return [table for table in tables if len(table) > 20]


def test_the_committed_pages_are_those_that_the_sources_give(made, checkout):
    folder = checkout / "docs" / "theory"
    committed = {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}
    again = "python scripts/theory.py"
    assert set(committed) == set(made), again
    for name, text in made.items():
        if name.endswith(".svg"):  # the last digit of a coordinate is the processor's
            assert NUMBER.sub("", committed[name]) == NUMBER.sub("", text), f"{name}: {again}"
            was, now = (np.array(NUMBER.findall(content), dtype=float) for content in (committed[name], text))
            np.testing.assert_allclose(was, now, atol=0.3, err_msg=f"{name}: {again}")
        else:
            assert committed[name] == text, f"{name}: {again}"


@pytest.mark.parametrize("name", LIBRARY)
def test_a_page_tells_all_that_its_effect_declares(made, name):
    effect, page = LIBRARY[name], made[f"{name}.md"]
    assert page.startswith(f"# {name}\n\n{theory(effect).about}\n")
    assert effect.equation in page and effect.source in page and f"`{effect.block}`" in page
    for parameter in effect.parameters:
        row = next(line for line in page.splitlines() if line.startswith(f"| `{parameter.symbol}` |"))
        assert row.split(" | ")[1] == parameter.unit and row.count(" | ") == 4
    assert all(word in page for names in effect.equal_to for word in names.split(" + "))
    assert f"]({name}.md)" in made[INDEX] and theory(effect).about in made[INDEX]
    assert f"]({name}.svg)" in page and len(made[f"{name}.svg"].encode()) < 40_000


def test_structures_are_named_where_an_effect_can_be(made):
    told = "Structures that can have it: {}."
    everywhere, without_spring, box_only = (
        told.format(", ".join(f"`{name}`" for name in names))
        for names in (
            ("flexible_box", "kelvin_voigt", "surface_contact", "driven_body", "transmission"),
            ("flexible_box", "driven_body", "transmission"),
            ("flexible_box", "kelvin_voigt"),
        )
    )
    assert everywhere in made["coulomb_friction.md"] and without_spring in made["end_stop.md"]
    assert box_only in made["force_bias.md"] and told.format("`transmission`") in made["gear_play.md"]


def test_every_effect_is_confused_with_another_and_both_pages_say_so(made):
    for name in LIBRARY:
        _, _, told = made[f"{name}.md"].partition("## Easily confused with\n")
        others = re.findall(r"^- \[(\w+)\]", told, re.MULTILINE)
        assert others and name not in others
        assert not set(LIBRARY[name].equal_to) & set(others), "what is equal cannot be told apart"
        for other in others:
            assert f"- [{name}]({name}.md): " in made[f"{other}.md"]


def test_every_link_leads_to_a_file(made):
    for name, text in made.items():
        if name.endswith(".md"):
            assert set(LINK.findall(text)) <= set(made), name


def test_pictures_show_what_the_kernels_compute():
    # A bias lifts the recorded force by one amount everywhere, in both panels; drawn to a tenth of a point.
    svg = picture(LIBRARY["force_bias"]).svg
    (true, response), (read, biased) = lines(svg, "#8a8a8a"), lines(svg, "#0072b2")
    for without, with_it in ((true, read), (response, biased)):
        lifted = with_it[:, 1] - without[:, 1]
        assert lifted.mean() > 3.0 and np.ptp(lifted) < 0.25
        np.testing.assert_array_equal(with_it[:, 0], without[:, 0])
    # A clipped force has a ceiling and a floor, and where the force is small it is the force.
    svg = picture(LIBRARY["force_saturation"]).svg
    true, read = lines(svg, "#8a8a8a")[0], lines(svg, "#0072b2")[0]
    ceiling, floor = read[:, 1].max(), read[:, 1].min()
    assert np.ptp(true[:, 1]) > 2.5 * (ceiling - floor)
    np.testing.assert_allclose(read[:, 1], np.clip(true[:, 1], floor, ceiling), atol=0.11)


def test_an_effect_of_another_file_gets_its_page(own, monkeypatch):
    register_file(own("hysteresis"))
    monkeypatch.setattr("theory.picture", lambda effect: picture(effect) if effect.name == "fifth_power" else None)
    files = pages(LIBRARY)
    page = files["fifth_power.md"]
    assert page.startswith("# fifth_power\n\nA spring of the fifth power.\n")
    assert "| `k5` | N/m^5 | 0 to 1e+12 | must be said | 0 |" in page and "with k5 = 1e+10 N/m^5." in page
    assert "- [hysteresis](hysteresis.md): alike in strokes of one size.\n" in page
    assert "- [fifth_power](fifth_power.md): alike in strokes of one size.\n" in files["hysteresis.md"]
    assert "`` k5 \\|d\\|^5 sgn d ``" in files[INDEX]
    grey, blue = (lines(files["fifth_power.svg"], color)[0] for color in ("#8a8a8a", "#0072b2"))
    assert np.abs(blue - grey).max() > 5.0


def test_an_unknown_effect_in_a_docstring_is_told(own):
    register_file(own("nothing_such"))
    with pytest.raises(BadInput, match="fifth_power: Easily confused with: found nothing_such"):
        pages(LIBRARY)
