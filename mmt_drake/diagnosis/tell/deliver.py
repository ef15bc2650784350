"""The model with what was found in it, as a file, held to the figure that was promised."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from mmt_drake.diagnosis.fit.errors import heldout_nrmse
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.errors import BadInput, MmtError
from mmt_drake.model.parameters import FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Structure
from mmt_drake.model_files import Model, load_model, model_data, save_model
from mmt_drake.recording.atomic import replacing

if TYPE_CHECKING:
    from mmt_drake.diagnosis.tell.outcome import Outcome

FILE: Final = "augmented_model.yaml"

_SAME = 1e-9


def augmented_model(fitted: Fitted, normal: NormalContact | None = None) -> dict[str, Any]:
    """The model file of a fit: what `mmt_drake.model_files.parse_model` reads.

    Structural parameters have the values found, those that were left out stay 0, and what was missing is listed under
    `effects` with every parameter, those included that have a default.

    Args:
        fitted: the fit; effects that were handed in are listed first.
        normal: the normal axis of a flexible box where it was fitted too; else that of the nominal model.

    Raises:
        BadInput: a nominal model with additions that no file told, or numbers that no model can have.
    """
    hypothesis, x = fitted.hypothesis, fitted.x
    nominal = hypothesis.nominal.with_parameters(**hypothesis.structure_values(x))
    if normal is not None:
        if not isinstance(nominal, FlexibleBoxModel):
            raise BadInput("model", found=f"a normal axis for a {nominal.NAME}", expected="one for a flexible_box")
        nominal = replace(nominal, normal=normal)
    values, model, listed = hypothesis.effect_values(x), nominal, []
    # In the order in which they are applied, because a default may be a number that another effect has added to.
    for effect in sorted(hypothesis.acting, key=lambda e: e.adds_to is None):
        checked = effect.checked(values[effect.name], model, effect.name)
        model = effect.apply(model, checked)
        listed.append((effect.name, checked))
    return model_data(_file_model(nominal), listed)


def deliver(outcome: Outcome, folder: str | Path) -> Path | None:
    """Write `augmented_model.yaml`, whole or not at all, and only if it keeps what the diagnosis promised for it.

    Args:
        outcome: of a diagnosis.
        folder: where to write; it exists.

    Returns:
        The file; None where nothing was fitted, so that there is no model to deliver.

    Raises:
        BadInput: the file cannot be written.
        MmtError: read back from the file, the model has another held-out error than the diagnosis says.
    """
    fit = outcome.diagnosis.fit
    if outcome.best is None or fit is None or fit.heldout_nrmse.augmented is None:
        return None
    data = augmented_model(outcome.best, None if outcome.normal is None else outcome.normal.normal)
    target = Path(folder) / FILE
    with replacing(target) as temporary:
        save_model(temporary, data)
        model = load_model(temporary)
        for recording, one in zip(outcome.prepared.recordings, (fit, *outcome.diagnosis.further_fits), strict=True):
            found, promised = heldout_nrmse(recording, model, one.heldout_s, one.axes), one.heldout_nrmse.augmented
            if promised is None or abs(found - promised) > _SAME * max(1.0, promised):
                told = f"a held-out error of {found!r} on {recording.source}, not of {promised!r}"
                raise MmtError(f"{target}: the model read back has {told}")
    return target


def _file_model(structure: Structure) -> Model:
    assert isinstance(structure, Model)  # every structure has a model file
    return structure
