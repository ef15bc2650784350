"""A diagnosis's numbers in pictures: errors of the models, shares, rivals, parameters, a learned law."""

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from mmt_drake.analysis.plotting import BLACK, GREY, ORANGE, PURPLE, RED, styled
from mmt_drake.analysis.wording import percent, significant
from mmt_drake.diagnosis.decide.budget import NAMELESS, NOISE, PARAMETERS, SHARED, BudgetPart
from mmt_drake.diagnosis.decide.mismatch import Mismatch
from mmt_drake.diagnosis.tell.figures_common import COLORS, HELDOUT, grid, legend_below
from mmt_drake.diagnosis.tell.result import Diagnosis, EffectParameter, Fit, NamedEffect, Status
from mmt_drake.diagnosis.tell.wording import all_words, part_words, words

MOST_CANDIDATES = 16
_MARKS: dict[Status, tuple[str, str, bool]] = {  # marker, colour, filled
    "accepted": ("o", COLORS["augmented"], True),
    "ambiguous": ("D", PURPLE, True),
    "at a bound": (">", ORANGE, True),
    "rejected": ("o", GREY, False),
}


@styled
def heldout_errors(fit: Fit) -> Figure | None:
    """The error of each model on held-out data as bars, the noise floor as a line; None where no model was run."""
    errors = {name: error for name, error in vars(fit.heldout_nrmse).items() if error is not None}
    if not errors:
        return None
    figure, (panel,) = grid(1, 1, 0.95 + 0.34 * len(errors))
    _bars(panel, errors, [COLORS[name] for name in errors])
    panel.set_xlim(0.0, 1.14 * max(*errors.values(), fit.noise_floor or 0.0))
    panel.xaxis.set_major_formatter(lambda value, _: f"{100.0 * value:g} %")
    panel.set_xlabel("held-out error / standard deviation of the measured signal")
    if fit.noise_floor is not None:
        floor = f"noise floor, {percent(fit.noise_floor)}"
        panel.axvline(fit.noise_floor, color=BLACK, linestyle=(0, (4, 2)), linewidth=1.2, label=floor)
        legend_below(figure, [panel])
    return figure


def _bars(
    panel: Axes,
    values: Mapping[str, float],
    color: str | Sequence[str],
    *,
    height: float = 0.62,
    padding: float = 4.0,
    fontsize: float = 9.0,
) -> None:
    """Ratios as bars below one another, each with its percentage."""
    bars = panel.barh(list(values), list(values.values()), height=height, color=color)
    panel.bar_label(bars, [percent(value) for value in values.values()], padding=padding, fontsize=fontsize)
    panel.invert_yaxis()
    panel.grid(axis="y", visible=False)


@styled
def budget(parts: Sequence[BudgetPart]) -> Figure | None:
    """What the squared error of the model handed in is made of, as bars; noise last and grey. None without a part."""
    shown = [part for part in parts if part.share > 0.0]
    if not shown:
        return None
    colors = {PARAMETERS: COLORS["refit"], SHARED: PURPLE, NAMELESS: RED, NOISE: GREY}
    figure, (panel,) = grid(1, 1, 0.85 + 0.3 * len(shown))
    shares = {part_words(part.part): part.share for part in shown}
    _bars(panel, shares, [colors.get(part.part, COLORS["augmented"]) for part in shown])
    panel.set_xlim(0.0, 1.14 * max(shares.values()))
    panel.xaxis.set_major_formatter(lambda value, _: f"{100.0 * value:g} %")
    panel.set_xlabel("share of the squared held-out error of the model handed in")
    return figure


@styled
def where(mismatch: Mismatch) -> Figure | None:
    """Shares of the blocks, and how strongly the error follows each signal, as bars side by side.

    None where neither is known.
    """
    shares = {words(block.block): block.share for block in mismatch.blocks}
    follows = {words(one.signal): one.score for one in mismatch.depends_on}
    shown = {"share of the mismatch": shares, "error explained by one signal": follows}
    shown = {title: bars for title, bars in shown.items() if bars}
    if not shown:
        return None
    figure, drawn = grid(1, len(shown), 0.75 + 0.26 * max(len(bars) for bars in shown.values()))
    for panel, (title, values) in zip(drawn, shown.items(), strict=True):
        _bars(panel, values, RED, height=0.6, padding=3.0, fontsize=8.5)
        panel.set(xlim=(0.0, 1.18), title=title)
        panel.set_xticks([0.0, 0.5, 1.0], ["0", "50 %", "100 %"])
    return figure


@styled
def rivals(diagnosis: Diagnosis) -> Figure | None:
    """Held-out error with each candidate, the best `MOST_CANDIDATES` of those fitted, and what became of it.

    None where none was fitted.
    """
    known = [(one.heldout_nrmse, one) for one in diagnosis.candidates if one.heldout_nrmse is not None]
    shown = sorted(known, key=lambda pair: pair[0])[:MOST_CANDIDATES]
    if not shown:
        return None
    figure, (panel,) = grid(1, 1, 0.95 + 0.21 * len(shown))
    for status, (marker, color, filled) in _MARKS.items():
        rows = [row for row, (_, one) in enumerate(shown) if one.status == status]
        errors = [shown[row][0] for row in rows]
        face = color if filled else "white"
        if rows:
            panel.plot(errors, rows, marker, color=color, markerfacecolor=face, markersize=6.5, label=status)
    if diagnosis.fit is not None:
        _reference(panel, diagnosis.fit.heldout_nrmse.refit, "refit, no effect", COLORS["refit"])
        _reference(panel, diagnosis.fit.noise_floor, "noise floor", BLACK)
    panel.set_yticks(range(len(shown)), [all_words(one.names) for _, one in shown])
    panel.set_ylim(len(shown) - 0.4, -0.6)
    panel.set_xscale("log")
    panel.xaxis.set_major_formatter(lambda value, _: f"{100.0 * value:g} %")
    panel.xaxis.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 5.0, 7.0)))
    panel.xaxis.set_minor_formatter(NullFormatter())
    panel.set_xlabel("held-out error / standard deviation of the measured signal")
    legend_below(figure, [panel])
    return figure


def _reference(panel: Axes, at: float | None, label: str, color: str) -> None:
    if at is not None:
        panel.axvline(at, color=color, linestyle=(0, (4, 2)), linewidth=1.2, label=label)


@styled
def parameters(diagnosis: Diagnosis) -> Figure | None:
    """Parameters with their 95 % intervals: structural ones over the nominal value, effects' over their estimate.

    A structural parameter is wrong where its interval leaves out 1; a parameter of an effect tells of something where
    its interval leaves out 0. Tables and texts are left out, and so is what is 0; None where nothing remains.
    """
    structural = [
        (name, one.value / one.nominal, None if one.ci95 is None else [end / one.nominal for end in one.ci95])
        for name, one in diagnosis.parameters.items()
        if one.nominal != 0.0
    ]
    of_effects: list[tuple[str, float, list[float] | None]] = []
    for effect in diagnosis.effects:
        for symbol, number in effect.parameters.items():
            if isinstance(number.value, float | int) and number.value != 0.0:
                size = abs(number.value)
                interval = [end / size for end in number.ci95 or () if isinstance(end, float | int)]
                of_effects.append((f"{words(effect.name)}: {symbol}", number.value / size, interval or None))
    shown = {"value / nominal value": (structural, 1.0), "value / estimate; 0 is no effect": (of_effects, 0.0)}
    shown = {title: group for title, group in shown.items() if group[0]}
    if not shown:
        return None
    figure, drawn = grid(1, len(shown), 0.85 + 0.26 * max(len(group) for group, _ in shown.values()))
    for panel, (title, (group, neutral)) in zip(drawn, shown.items(), strict=True):
        for row, (_, value, ends) in enumerate(group):
            if ends is not None:
                panel.plot(ends, [row, row], color=COLORS["augmented"], linewidth=3.0, solid_capstyle="butt")
            panel.plot(value, row, "o", color=BLACK, markersize=4.5)
        panel.axvline(neutral, color=RED, linestyle=(0, (4, 2)), linewidth=1.2)
        panel.set_yticks(range(len(group)), [name for name, *_ in group])
        panel.set_ylim(len(group) - 0.4, -0.6)
        panel.margins(x=0.1)
        panel.set_xlabel(title)
    return figure


@styled
def learned_law(effect: NamedEffect) -> Figure | None:
    """The table of a `tabulated_force` over its signal, with its 95 % band; None where the effect holds no table."""
    of, at, value = (effect.parameters.get(symbol, EffectParameter("", "")) for symbol in ("of", "at", "value"))
    if not (isinstance(at.value, tuple) and isinstance(value.value, tuple)):
        return None
    figure, (panel,) = grid(1, 1, 2.8)
    if value.ci95 is not None:
        low, high = value.ci95
        panel.fill_between(at.value, low, high, color=HELDOUT, linewidth=0, label="95 % interval")
    panel.plot(at.value, value.value, "o-", color=COLORS["augmented"], markersize=3.5, label="learned")
    panel.axhline(0.0, color=GREY, linewidth=0.8)
    panel.set(xlabel=f"{words(str(of.value))} [{at.unit}]", ylabel=f"missing force [{value.unit}]")
    span = f"{significant(at.value[0], 3)} to {significant(at.value[-1], 3)} {at.unit}"
    panel.set_title(f"What is missing, over {words(str(of.value))} from {span}")
    legend_below(figure, [panel])
    return figure
