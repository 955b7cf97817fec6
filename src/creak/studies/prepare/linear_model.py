"""The deck as a study has it: other materials, sections, nodes, supports and clips; its linear structure."""

from __future__ import annotations

from collections.abc import Sequence

from creak.assembly.part import Rayleigh, common_rayleigh
from creak.contact.play import Play
from creak.formats.deck.catalogue import ignored_in_vain, stop_on_unread, with_named_stops, without_unread_damping
from creak.model.mesh import Model
from creak.model.units import UNITS
from creak.studies.design.clips import with_clips
from creak.studies.design.named_nodes import with_named_nodes
from creak.studies.design.properties import with_properties
from creak.studies.design.supports import check_driven, freed_where_moved, with_supports
from creak.studies.file.config import DampingTable
from creak.studies.file.reader import Study
from creak.studies.prepare.excitation import driven_dofs
from creak.studies.prepare.imported import imported_superelements
from creak.studies.prepare.structure import Structure
from creak.studies.prepare.unit_check import check_units
from creak.studies.warned import Warned


def designed_model(
    study: Study, model: Model, ignore: Sequence[str] = ()
) -> tuple[Model, list[tuple[Play, str]], list[str]]:
    """The model of the deck as the study changes it, the connectors that its clips are with their places, and notes.

    Parameters
    ----------
    ignore : keywords of the deck that may go unread although they change the answer.

    Raises
    ------
    InputError : something unread that changes the answer, wrong units, or anything wrong in these tables.
    """
    c, places, driving = study.config, study.places, study.driving
    if own_damping(model, c.damping)[1]:
        model = without_unread_damping(model, "[damping] of the study stands in its place")
    model = with_named_stops(model, [name for t in study.touching.connectors for name in t.node_sets])
    stop_on_unread(model, ignore)
    vain = [Warned(text) for text in ignored_in_vain(model, ignore)]
    check_units(model, c.model.units, places)
    model, changed = with_properties(model, c.material, c.section, places)
    model, named = with_named_nodes(model, c.nodes, places, UNITS[c.model.units].length)
    model = freed_where_moved(model, driving)
    model, held = with_supports(model, c.support, places)
    model, clips, placed = with_clips(model, study.touching)
    return model, clips, [*vain, *changed, *named, *held, *placed]


def own_damping(model: Model, table: DampingTable) -> tuple[Rayleigh, bool]:
    """Rayleigh numbers of all parts, and whether they replace the deck's damping."""
    if table.rayleigh is not None:
        return Rayleigh(table.rayleigh.alpha, table.rayleigh.beta), True
    if table.modal is not None or table.from_test is not None:
        return Rayleigh(0.0, 0.0), True
    return common_rayleigh(model), False


def linear_structure(study: Study, model: Model, ignore: Sequence[str] = ()) -> Structure:
    """What the study says of stiffness, mass and supports, contact left out; no excitation need be complete.

    Where it prescribes motion the structure is held. Damping is that of the deck, or the study's own Rayleigh numbers.

    Raises
    ------
    InputError : as `designed_model`; a dof driven twice, a superelement that cannot be used.
    """
    c = study.config
    model, _, _ = designed_model(study, model, ignore)
    driven = driven_dofs(model, study.driving)
    check_driven(model, study.driving, driven)
    rayleigh, override = own_damping(model, DampingTable(rayleigh=c.damping.rayleigh))
    superelements, _ = imported_superelements(model, c.superelement, study.places, rayleigh, override)
    return Structure(model, driven, rayleigh, override, superelements, None)
