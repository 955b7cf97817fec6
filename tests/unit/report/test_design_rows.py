"""Clips and supports of a study in the words of the page."""

from __future__ import annotations

from creak.report.words.method import _clip, _support
from creak.studies.file.design.clip_tables import ClipTable
from creak.studies.file.design.node_tables import SupportTable


def test_clips_and_supports_are_told():
    stop = ClipTable(type="stop", nodes="TIP", axis=(0, 0, 1), stiffness=40.0, ageing=0.8)
    assert _clip(stop) == "stop, TIP to ground, stiffness 40, 80 % left by age"
    pair = ClipTable(use="A-pillar", at=[(0, 0, 0)], parts=["FRAME", "PANEL"], axis=(0, 0, 1))
    assert _clip(pair) == "A-pillar of the library, FRAME to PANEL"
    assert _support(SupportTable(nodes="*", free=["z"])) == "*: z freed"
    assert _support(SupportTable(nodes="ROOT", free=["z"], hold=["x", "y"])) == "ROOT: z freed and x, y held"
