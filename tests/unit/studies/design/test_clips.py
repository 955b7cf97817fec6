"""Clips, bushings, stops and foam: their forces on a cantilever against closed forms, and where their values come from."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import qmc

from creak.errors import InputError
from creak.studies.design.clips import _library, clips_of
from creak.studies.file.config import StudyConfig
from creak.studies.file.reader import read_study
from creak.studies.file.scatter_tables import Distribution
from creak.studies.prepare.setup import Setup, set_up
from creak.studies.robust.changes import keeps_model
from creak.studies.robust.draws import make_causes
from creak.studies.run.precheck import ready
from helpers_decks import write_study

LENGTH, SIDE, MODULUS, N = 200.0, 2.0, 210000.0, 4
GIVE = LENGTH**3 / (3.0 * MODULUS * SIDE**4 / 12.0)
"""mm/N at the tip."""
BEAM = (
    "*NODE\n"
    + "".join(f"{i + 1}, {LENGTH * i / N}, 0., 0.\n" for i in range(N + 1))
    + "*ELEMENT, TYPE=B31, ELSET=BEAM\n"
    + "".join(f"{i + 1}, {i + 1}, {i + 2}\n" for i in range(N))
    + f"*NSET, NSET=TIP\n{N + 1}\n*NSET, NSET=ROOT\n1\n*NSET, NSET=INNER\n2, 3\n"
    + f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{MODULUS}, 0.3\n*DENSITY\n7.85e-9,\n*DAMPING, ALPHA=5.\n"
    + f"*BEAM SECTION, SECTION=RECT, ELSET=BEAM, MATERIAL=STEEL\n{SIDE}, {SIDE}\n0., 1., 0.\n*BOUNDARY\nROOT, 1, 6\n"
)
HEAD = '[model]\ndeck = "beam.inp"\n[time]\nend = 0.01\n'
UP = 'nodes = "TIP"\naxis = [0, 0, 2]\n'
EXACT = 1e-3


def clipped(folder: Path, tables: str, top: str = "") -> Setup:
    path = write_study(folder, top + HEAD + tables, {"beam.inp": BEAM})
    return set_up(read_study(path))


def tip(folder: Path, force: float, clip: str, top: str = "") -> float:
    """Place of the tip at rest under a force."""
    load = f'[[static]]\nforce = {force}\nnode_set = "TIP"\ndof = "z"\n'
    setup, *_ = ready(clipped(folder, load + clip, top), lambda *_: None)
    assert setup.static is not None
    return float(setup.static.at(np.array([6 * N + 2]))[0])


def test_a_bushing_holds_along_its_axes(tmp_path):
    """Turned: its stiffness along an oblique axis, and the same across, act as one number along z."""
    k = 3.0
    bushing = f'[[clip]]\ntype = "bushing"\nnodes = "TIP"\nstiffness = [{k}, {k}, {k}, 0, 0, 0]\n'
    held = GIVE / (1.0 + k * GIVE)
    for axis in ("", "axis = [1, 2, 3]\n"):
        assert tip(tmp_path, 1.0, bushing + axis) == pytest.approx(held, rel=EXACT)
    along = bushing.replace(f"[{k}, {k}, {k}", f"[{k}, 0, 0") + "axis = [0, 1, 1]\n"
    half = 0.5 * (GIVE + held)  # along the axis held, across it free
    assert tip(tmp_path, 1.0, along) == pytest.approx(half, rel=EXACT)
    aged = bushing + "ageing = 0.5\n"
    assert tip(tmp_path, 1.0, aged) == pytest.approx(GIVE / (1.0 + 0.5 * k * GIVE), rel=EXACT)


def test_a_clip_leaves_its_seat_at_its_force(tmp_path):
    """Below it holds as a spring, above with that force alone; aged it leaves earlier."""
    k, leaves = 50.0, 2.0
    clip = f'[[clip]]\ntype = "pull-out"\n{UP}stiffness = {k}\npull_out = {leaves}\n'
    assert tip(tmp_path, 1.0, clip) == pytest.approx(1.0 / (1.0 / GIVE + k), rel=EXACT)
    assert tip(tmp_path, -1.0, clip) == pytest.approx(-1.0 / (1.0 / GIVE + k), rel=EXACT)
    assert tip(tmp_path, 20.0, clip) == pytest.approx(GIVE * (20.0 - leaves), rel=EXACT)
    assert tip(tmp_path, 20.0, clip + "ageing = 0.25\n") == pytest.approx(GIVE * (20.0 - 0.25 * leaves), rel=EXACT)


def test_foam_and_stops_press_by_their_table(tmp_path):
    """Two slopes: 2 N/mm up to 1 mm, then 8 N/mm."""
    table = "table = [[0, 0], [1, 2], [2, 10]]\n"
    foam = f'[[clip]]\ntype = "foam"\n{UP}{table}gap = 0.5\ndamping = 0.01\n'
    z = tip(tmp_path, 6.0, foam)
    squeezed = z - 0.5
    assert squeezed > 1.0
    assert 6.0 - z / GIVE == pytest.approx(2.0 + 8.0 * (squeezed - 1.0), rel=EXACT)
    assert tip(tmp_path, -6.0, foam) == pytest.approx(-6.0 * GIVE, rel=EXACT)
    stop = f'[[clip]]\ntype = "stop"\n{UP}stiffness = 50.0\ngap = 0.5\n'
    pressed = (6.0 * GIVE - 0.5) / (GIVE + 1.0 / 50.0)
    assert tip(tmp_path, 6.0, stop) == pytest.approx(GIVE * (6.0 - pressed), rel=EXACT)


def test_connectors_between_the_same_sets_are_told_apart(tmp_path):
    """Their events, too: one name is one place."""
    one = '[[connector]]\ntype = "play"\nnodes = ["ROOT", "TIP"]\ndof = "y"\nupper = 0.1\nstiffness = 5\n'
    named, other = f'{one}name = "hook"\n', one.replace('["ROOT", "TIP"]', '"TIP"')
    assert clipped(tmp_path, one + named + other).connectors.group == ("ROOT-TIP", "hook", "TIP")
    two = clipped(tmp_path, one + named + one.replace('"y"', '"z"')).connectors
    assert two.group == ("ROOT-TIP.1", "hook", "ROOT-TIP.3")
    assert two.names == tuple(f"{name}:upper" for name in two.group)


def test_a_clip_with_play_is_a_connector_along_any_axis(tmp_path):
    play = '[[clip]]\nname = "hook"\ntype = "play"\nlower = -0.1\nupper = 0.2\nstiffness = 40\n'
    along_z = clipped(tmp_path, play + UP).connectors
    connector = play.replace("[[clip]]", "[[connector]]") + 'nodes = "TIP"\ndof = "z"\n'
    given = clipped(tmp_path, connector).connectors
    for key in ("gap0", "stiffness", "labels"):
        assert np.array_equal(getattr(along_z, key), getattr(given, key))
    assert along_z.names == given.names == ("hook:upper", "hook:lower")
    oblique = clipped(tmp_path, play + 'nodes = ["ROOT", "TIP"]\naxis = [3, 0, 4]\n').connectors
    assert oblique.G[1].toarray().ravel() == pytest.approx([-0.6, -0.8, 0.6, 0.8])


def test_values_come_from_libraries_in_the_units_of_the_study(tmp_path):
    use = f'[[clip]]\nuse = "mine"\n{UP}'
    (tmp_path / "my.toml").write_text(
        'units = "mm-t-s"\n[clip.mine]\ntype = "play"\nlower = -2.0\ntable = [[0, 0], [1, 5]]\ndamping = 0.3\n'
        '[clip.stiff]\ntype = "bushing"\nstiffness = [1, 2, 2, 4, 5, 5]\n',
        encoding="utf-8",
    )
    top = 'clips = "my.toml"\n'
    found = clipped(tmp_path, use, top).connectors
    assert (found.gap0.tolist(), found.stiffness.tolist(), found.damping.tolist()) == ([2.0], [5.0], [0.3])
    deck = BEAM.replace(f"{MODULUS}, 0.3", "2.1e11, 0.3").replace("7.85e-9", "7850.")
    (tmp_path / "beam.inp").write_text(deck, encoding="utf-8")
    metres = HEAD.replace("[time]", 'units = "m-kg-s"\n[time]')
    path = tmp_path / "metres.toml"
    path.write_text(top + metres + use + '[[clip]]\nuse = "stiff"\nnodes = "TIP"\n', encoding="utf-8")
    setup = set_up(read_study(path))
    assert setup.connectors.gap0 == pytest.approx([2e-3])
    assert setup.connectors.stiffness == pytest.approx([5e3])
    assert setup.connectors.damping == pytest.approx([300.0])
    assert np.diag(setup.model.blocks[-1].section.stiffness) == pytest.approx([1e3, 2e3, 2e3, 4e-3, 5e-3, 5e-3])
    inch, pound = 25.4, 4.4482216152605
    found = _library(tmp_path / "my.toml", "in-lbf-s")
    assert found["mine"]["lower"] == pytest.approx(-2.0 / inch)
    assert np.array(found["mine"]["table"])[1] == pytest.approx([1.0 / inch, 5.0 / pound])
    turning = np.array([4.0, 5.0, 5.0]) / (pound * inch)
    assert found["stiff"]["stiffness"] == pytest.approx([inch / pound, *[2.0 * inch / pound] * 2, *turning])
    own = clipped(tmp_path, use + "stiffness = 7.0\n", top).connectors
    assert own.stiffness.tolist() == [7.0]
    assert own.curves is None


def test_every_clip_of_creak_can_be_used(tmp_path):
    from creak.studies.design.clips import OWN
    from creak.studies.file.reader import read_toml

    names = read_toml(OWN, "clip library")[0]["clip"]
    setup = clipped(tmp_path, "".join(f'[[clip]]\nuse = "{name}"\n{UP}' for name in names))
    assert len(names) == len(set(setup.connectors.group)) + 1 == 5
    assert all("example" in values["source"] for values in names.values())


def test_clips_sit_at_places_of_parts(tmp_path):
    place = '[[clip]]\ntype = "stop"\nstiffness = 5\ngap = 1\naxis = [0, 0, 1]\nat = [[50, 0.2, 0], [150, 0, 0]]\n'
    setup = clipped(tmp_path, f'{place}parts = "PART-1"\n'.replace("PART-1", _part(tmp_path)))
    assert setup.model.nodes.ids[setup.connectors.nodes_idx].tolist() == [2, 4]
    assert any("lie up to 0.2 mm from the given places" in note for note in setup.notes)


def _part(folder: Path) -> str:
    return clipped(folder, "").model.parts[0].name


TWICE = f'[[clip]]\nname = "hook"\ntype = "stop"\n{UP}stiffness = 1\n'
CONNECTOR = '[[connector]]\ntype = "play"\nname = "hook"\nnodes = "TIP"\ndof = "z"\nupper = 1\nstiffness = 1\n'
REFUSED = {
    "one name": (TWICE + TWICE, "the name 'hook' is taken"),
    "connectors": (CONNECTOR + CONNECTOR, r"study.toml:12 \[connector.1\]: the name 'hook' is taken"),
    "itself": (CONNECTOR.replace('"TIP"', '["TIP", "TIP"]'), r"\[connector.0\]: node 5 of 'TIP' is joined to itself"),
    "bushing to itself": (
        '[[clip]]\ntype = "bushing"\nnodes = ["INNER", "INNER"]\nstiffness = [1, 1, 1, 0, 0, 0]\n',
        r"\[clip.0\]: node 2 of 'INNER' is joined to itself",
    ),
    "stop to itself": (
        '[[clip]]\ntype = "stop"\nnodes = ["TIP", "TIP"]\naxis = [0, 0, 1]\nstiffness = 1\n',
        "node 5 of 'TIP' is joined to itself",
    ),
    "no type": (f"[[clip]]\n{UP}", "give type .*or use"),
    "unknown": (f'[[clip]]\nuse = "example-trim-slip"\n{UP}', "unknown clip .*example-trim-clip"),
    "no place": ('[[clip]]\ntype = "stop"\naxis = [0, 0, 1]\nstiffness = 1\n', "give either nodes, or at and parts"),
    "no axis": ('[[clip]]\ntype = "stop"\nnodes = "TIP"\nstiffness = 1\n', "needs an axis"),
    "no force": (f'[[clip]]\ntype = "pull-out"\n{UP}stiffness = 1\n', "needs stiffness and pull_out"),
    "foreign": (f'[[clip]]\ntype = "foam"\n{UP}table = [[0, 0], [1, 1]]\nlower = 1\n', "a foam clip has no lower"),
    "one number": (f'[[clip]]\ntype = "bushing"\n{UP}stiffness = 1\n', "six numbers"),
    "falls": (f'[[clip]]\ntype = "foam"\n{UP}table = [[0, 0], [1, 2], [2, 1]]\n', "does not rise"),
    "no limits": (f'[[clip]]\ntype = "play"\n{UP}stiffness = 1\n', "needs lower, upper or both"),
    "lateral": (
        f'[[clip]]\ntype = "bushing"\n{UP}stiffness = [1, 2, 3, 0, 0, 0]\n',
        "lateral: the direction of the first",
    ),
    "unlike sets": (
        '[[clip]]\ntype = "bushing"\nnodes = ["TIP", "INNER"]\nstiffness = [1, 1, 1, 0, 0, 0]\n',
        "1 and 2",
    ),
    "far": (
        '[[clip]]\ntype = "stop"\nstiffness = 1\naxis = [0, 0, 1]\nat = [[50, 9, 0]]\nparts = "BEAM"\n',
        "unknown part|no node within",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_meant_is_refused(tmp_path, case):
    tables, match = REFUSED[case]
    with pytest.raises(InputError, match=match):
        clipped(tmp_path, tables)


@pytest.mark.parametrize(
    "clip",
    [
        'type = "bushing"\nnodes = "TIP"\nstiffness = [1, 1, 1, 0, 0, 0]',
        f'type = "play"\n{UP}upper = 0.3\nstiffness = 50',
        f'type = "pull-out"\n{UP}stiffness = 50\npull_out = 2',
        f'type = "stop"\n{UP}gap = 0.4\nstiffness = 50\ndamping = 0.1',
        f'type = "foam"\n{UP}table = [[0, 0], [1, 2]]',
        f'use = "example-rubber-stop"\n{UP}',
    ],
)
def test_clips_are_the_same_after_results_or_draws_wrote_them_down(clip, tmp_path):
    """All keys are then given, unused ones as none."""
    setup = clipped(tmp_path, f"[[clip]]\n{clip}\n")
    config = setup.study.config
    again = StudyConfig.model_validate(config.model_dump(mode="json", by_alias=True))
    assert again == config
    assert clips_of(replace(setup.study, config=again).touching) == clips_of(setup.study.touching)


@pytest.mark.parametrize(
    "given", ['type = "normal"\nmean = 3\nsigma = 0.1', 'type = "uniform"\nlow = 1\nhigh = 2', 'type = "seed"']
)
def test_distributions_are_the_same_after_they_were_written_down(given):
    one = Distribution.model_validate(tomllib.loads(given))
    assert Distribution.model_validate(one.model_dump(mode="json")) == one


def test_measured_scatter_of_clips_is_one_word(tmp_path):
    """Standard deviations of doi 10.1177/0954406217721724, about values of the library and of the study."""
    clips = f'[[clip]]\nuse = "example-snap-fit"\n{UP}[[clip]]\ntype = "stop"\n{UP}name = "s"\nstiffness = 50.0\n'
    words = '"clip.0.{}" = {{ type = "clip-{}" }}\n'
    rows = [("ageing", "one-side"), ("damping", "both-sides"), ("stiffness", "both-sides")]
    vary = "[scatter.vary]\n" + "".join(words.format(*row) for row in rows)
    vary += '"clip.s.stiffness" = { type = "clip-one-side" }\n'
    setup = clipped(tmp_path, clips + vary)
    study = setup.study
    found = clips_of(study.touching)
    data = {"clip": [clip.model_dump(mode="json") for clip in found]}
    causes = make_causes(study.config.scatter, data, {}, {}, study.places, {})
    draws = qmc.Sobol(4, seed=1).random(2**12)
    for cause, (middle, share) in zip(causes, ((1.0, 0.07), (0.01, 0.36), (200.0, 0.4), (50.0, 0.07)), strict=True):
        values = cause.values(draws)
        assert np.median(values) == pytest.approx(middle, rel=0.01)
        assert values.std() / values.mean() == pytest.approx(share, rel=0.02)
        assert values.min() > 0.0
        assert "10.1177/0954406217721724" in (cause.of.source or "")
        assert keeps_model(found, cause.key, modal=False)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('"clip.0.gap" = { type = "clip-one-side" }', ["clip.0.gap", "clip.N.ageing", "[scatter.vary.clip.0.gap]"]),
        ('"damping.modal" = { type = "clip-one-side" }', ["damping.modal does not scatter as a clip-one-side"]),
        ('"clip.0.damping" = { type = "clip-one-side" }', ["clip.0.damping is not given", "a number there"]),
        ('"clip.0.ageing" = { type = "clip-one-side", sigma = 0.1 }', ["a clip-one-side distribution has no sigma"]),
        ('"clip.0.ageing" = { type = "clip" }', ["scatter.vary.clip.0.ageing.type"]),
        ('"clip.hook.ageing" = { type = "clip-one-side" }', ["the study has 1 [[clip]]; expected clip.0", "clip.hook"]),
    ],
)
def test_what_does_not_scatter_as_clips_do_is_one_message(line, words, tmp_path):
    clip = f'[[clip]]\ntype = "stop"\n{UP}stiffness = 50.0\n[scatter.vary]\n{line}\n'
    with pytest.raises(InputError, match=r"\w") as error:
        causes_of(tmp_path, clip)
    for word in words:
        assert word in str(error.value)


def causes_of(folder, tables):
    study = clipped(folder, tables).study
    data = study.config.model_dump(mode="json", by_alias=True)
    return make_causes(study.config.scatter, data, {}, {}, study.places, {})
