"""The report of a diagnosis of an arm: one page, a row and figures for each joint."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from mmt_drake.analysis.interactive import THINNING, Plot, cloud, curve, rows, shade
from mmt_drake.analysis.page import Banner, Bar, Section, Tone, write_page
from mmt_drake.analysis.table import Table
from mmt_drake.analysis.wording import percent
from mmt_drake.arms.base_parameters import BaseParameter
from mmt_drake.arms.believed import Predicted
from mmt_drake.arms.forward import WINDOW_S
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.result import ArmDiagnosis, ArmEffectFound, Number
from mmt_drake.arms.wording import found, headline, told
from mmt_drake.diagnosis.decide.budget import SHARED
from mmt_drake.diagnosis.tell.figures_common import COLORS, DASHES, HELDOUT, MEASURED, NAMES
from mmt_drake.diagnosis.tell.first_screen import PART_COLORS
from mmt_drake.diagnosis.tell.provenance import Provenance
from mmt_drake.diagnosis.tell.wording import capitalised, part_words, share_words
from mmt_drake.effects.wording import words

_TONES: Final[dict[str, Tone]] = {
    "no_mismatch": "good",
    "parameters": "fair",
    "missing_physics": "fair",
    "partly_explained": "open",
    "ambiguous": "open",
    "unexplained": "bad",
}
_WEAKEST: Final = 12
_TERMS: Final = 4
"""Base parameters that are shown, and terms of each."""
_SHARED: Final = "Laws that cannot be told apart"


def write_arm_report(
    diagnosis: ArmDiagnosis, before: Predicted, after: Predicted, path: str | Path, provenance: Provenance
) -> Path:
    """Write the page, with everything in it.

    Args:
        diagnosis: what was found.
        before, after: torque of the first log, as the model handed in and the one found predict it.
        path: of the page.
        provenance: of the report.

    Raises:
        BadInput: the file cannot be written.
    """
    sections = [
        Section("Joint by joint", table=_joint_table(diagnosis)),
        Section("What was found", _sure_text(diagnosis), table=_effect_table(diagnosis)),
        *_links(diagnosis),
        *_base(diagnosis),
        *_ahead(diagnosis),
        *_joints(diagnosis, before, after),
        Section("How this was computed", _METHOD, facts=provenance.facts, remark=THINNING),
    ]
    banner = Banner(words(diagnosis.verdict), _TONES[diagnosis.verdict])
    return write_page(path, headline(diagnosis), sections, found(diagnosis), banner, _first(diagnosis, provenance))


_METHOD: Final = (
    "Positions and torques were made smooth without phase below the edge of the band, and the torque that the motion "
    "asks for was computed by Drake's multibody dynamics, linear in the inertial numbers of the links. Every effect of "
    "the library was tried on every joint, by least squares on blocks that are held out in turn; a third of the blocks "
    "chose nothing and fitted nothing: the errors here are theirs. A joint that rests is left out, since dry friction "
    "holds whatever it has to."
)


def _first(diagnosis: ArmDiagnosis, provenance: Provenance) -> list[Section]:
    bars = [
        Bar(
            _SHARED if p.part == SHARED else capitalised(part_words(p.part)),
            p.share,
            share_words(p.share),
            PART_COLORS.get(p.part, COLORS["augmented"]),
        )
        for p in diagnosis.budget
        if p.share >= 0.001
    ]
    steps = [
        "Simulate with augmented_model.yaml: `mmt_drake.arms.deliver.arm_diagram` builds plant and effects.",
        "Hold it to a log of another motion: `mmt-drake simulate --model augmented_model.yaml` tells the error.",
    ]
    base = diagnosis.base
    if base and (weak := len(base.structural) - len(base.well_told)):
        steps.append(
            f"{weak} of {len(base.structural)} base parameters are not told by this motion, or barely: "
            "`mmt-drake excite --model ARM.yaml --log LOG --out motion.csv` plans one that tells more."
        )
    remark = (
        "Percent of the squared error of the model handed in, on blocks that no choice has seen, mean of the joints."
    )
    return [
        Section("What the model's error is made of", bars=bars, remark=remark),
        Section("What to do next", items=[*steps, *diagnosis.notes]),
        Section("Where this comes from", facts=provenance.facts),
    ]


def _joint_table(diagnosis: ArmDiagnosis) -> Table:
    headers = (
        "joint",
        "spread of torque [N m]",
        "as handed in",
        "links fitted",
        "with what was found",
        "noise",
        "named",
    )
    table: list[tuple[str | float | None, ...]] = []
    for joint in diagnosis.joints:
        named = ", ".join(words(e.name) for e in diagnosis.effects if e.where == joint.name and e.certain)
        nothing = "something, for sure" if joint.name in diagnosis.places else "nothing"
        if not joint.moves:
            table.append((joint.name, joint.spread, None, None, None, None, "did not move"))
            continue
        table.append(
            (joint.name, joint.spread, joint.nominal, joint.refit, joint.augmented, joint.noise, named or nothing)
        )
    caption = "RMS error of the torque in parts of its spread, on blocks that no choice has seen."
    return Table(headers, table, caption, digits=3)


def _sure_text(diagnosis: ArmDiagnosis) -> str:
    if not diagnosis.effects:
        return "No effect of the library earned its place on any joint."
    return (
        "Certain says how deep a name holds: the law, its family, or only the block. Without one it is in the model "
        "that is delivered, but not sure: what stands beside it, if anything does, would explain as much in its place."
    )


def _effect_table(diagnosis: ArmDiagnosis) -> Table | None:
    if not diagnosis.effects:
        return None
    headers = ("where", "effect", "numbers (95 % interval)", "certain", "share", "as good")
    table = [
        (
            e.where or "arm",
            words(e.name),
            _numbers(e),
            e.certain or "no",
            share_words(e.share),
            ", ".join(map(words, e.instead)),
        )
        for e in diagnosis.effects
    ]
    return Table(headers, table)


def _numbers(effect: ArmEffectFound) -> str:
    said = []
    for symbol, number in effect.numbers.items():
        if not isinstance(number, Number):
            said.append(f"with {number}")
            continue
        interval = f" ({number.ci95[0]:.3g} to {number.ci95[1]:.3g})" if number.ci95 else ""
        said.append(f"{symbol} {number.value:.3g}{interval} {'' if number.unit == '1' else number.unit}".strip())
    return ", ".join(said)


def _links(diagnosis: ArmDiagnosis) -> Iterator[Section]:
    if diagnosis.parameters:
        table = [
            (link, symbol, n.value, f"{n.ci95[0]:.3g} to {n.ci95[1]:.3g}" if n.ci95 else "", n.unit)
            for link, some in diagnosis.parameters.items()
            for symbol, n in some.items()
        ]
        text = "Numbers about the frame of each link, with what hangs on it; those whose interval excludes the file's."
        yield Section(
            "Inertial numbers of links", text, table=Table(("link", "number", "value", "95 % interval", "unit"), table)
        )
    if diagnosis.untold:
        items = [f"{link}: {', '.join(symbols)}" for link, symbols in diagnosis.untold.items()]
        text = "They stay at the file's values, or move only together with others."
        yield Section("Not told by this motion", text, items=items, inner=bool(diagnosis.parameters))


def _base(diagnosis: ArmDiagnosis) -> Iterator[Section]:
    base = diagnosis.base
    if base is None:
        return
    worst = sorted(base.parameters, key=lambda one: -(one.deviation or 0.0) / one.size)
    table = [
        (
            one.said(_TERMS),
            one.value,
            one.unit,
            one.deviation,
            percent(one.relative) if one.relative else "",
            _barely(one),
        )
        for one in worst[:_WEAKEST]
    ]
    condition = f"{base.condition:.3g}" if np.isfinite(base.condition) else "infinite"
    text = (
        f"Torques tell {len(base.structural)} combinations of this arm's inertial numbers apart, and this motion "
        f"{len(base.parameters)}. The condition number of the regressor is {condition}."
    )
    caption = f"The weakest, {len(table)} of {len(worst)}; diagnosis.json has all, with every term."
    headers = ("base parameter", "as handed in", "unit", "standard deviation", "of its value", "told")
    items = [f"Told by another motion: {one.said(_TERMS)}" for one in base.untold]
    if base.unexcited:
        items.append(f"Nothing in this motion depends on {', '.join(base.unexcited)}.")
    if items:
        items.append("Such a motion is planned by `mmt-drake excite --model ARM.yaml --log LOG --out motion.csv`.")
    yield Section("What the motion tells", text, items=items, table=Table(headers, table, caption, digits=3))


def _barely(one: BaseParameter) -> str:
    return "barely" if one.barely else "well"


def _ahead(diagnosis: ArmDiagnosis) -> Iterator[Section]:
    if diagnosis.forward is None or not diagnosis.forward[0].windows:
        return
    before, after = diagnosis.forward
    table: list[tuple[str | float | None, ...]] = [
        (
            joint.name,
            *(float(1e3 * e) if np.isfinite(e) else None for e in (before.way[j], before.rms[j], after.rms[j])),
        )
        for j, joint in enumerate(diagnosis.joints)
        if joint.moves
    ]
    loop = "its controller closing the loop" if before.closed else "in open loop"
    text = (
        f"Drake's plant under the recorded torque, {loop}, over {before.windows} windows of {WINDOW_S:g} s that "
        "were held out, each from the recorded state. A dash: it could not be simulated."
    )
    headers = ("joint", "way [mrad]", "off, as handed in [mrad]", "off, with what was found [mrad]")
    yield Section("Simulated forward", text, table=Table(headers, table, "RMS over the windows.", digits=3))


def _joints(diagnosis: ArmDiagnosis, before: Predicted, after: Predicted) -> Iterator[Section]:
    for j, joint in enumerate(diagnosis.joints):
        if not joint.moves:
            continue
        plots = [_over_time(diagnosis, before, after, j), _over_velocity(before, after, j)]
        effects = [
            f"{words(e.name)}: {told(e)}; {ARM_EFFECTS[e.name].equation}"
            for e in diagnosis.effects
            if e.where == joint.name
        ]
        yield Section(joint.name, "", plots, items=effects)


def _over_time(diagnosis: ArmDiagnosis, before: Predicted, after: Predicted, j: int) -> Plot:
    figure = rows([240, 140])
    curve(figure, before.time, before.measured[:, j], "measured", MEASURED)
    for name, one in (("nominal", before), ("augmented", after)):
        style: dict[str, Any] = {"line": {"color": COLORS[name], "width": 1.3, "dash": DASHES[name]}}
        curve(figure, one.time, one.predicted[:, j], NAMES[name], COLORS[name], **style)
        left = np.where(one.counted[:, j], one.measured[:, j] - one.predicted[:, j], np.nan)
        curve(figure, one.time, left, NAMES[name], COLORS[name], row=2, showlegend=False, **style)
    for row in (1, 2):
        shade(figure, [(a, b) for a, b, log in diagnosis.heldout_s if log == 0], HELDOUT, "held out from the fit", row)
    figure.data[-1].update(showlegend=False)
    figure.update_yaxes(title_text="torque [N m]", row=1, col=1)
    figure.update_yaxes(title_text="error [N m]", row=2, col=1)
    figure.update_xaxes(title_text="time [s]", row=2, col=1)
    return Plot(figure, "", "Torque over time")


def _over_velocity(before: Predicted, after: Predicted, j: int) -> Plot:
    figure = rows([260])
    for name, one in (("nominal", before), ("augmented", after)):
        own = one.counted[:, j]
        left = one.measured[own, j] - one.predicted[own, j]
        cloud(figure, one.velocity[own, j], left, NAMES[name], COLORS[name])
    figure.update_layout(height=figure.layout.height + 16, margin_t=52)
    figure.update_xaxes(title_text="velocity [rad/s]")
    figure.update_yaxes(title_text="error of the torque [N m]")
    return Plot(figure, "A step at zero is dry friction, a slope viscous friction.", "Error over velocity")
