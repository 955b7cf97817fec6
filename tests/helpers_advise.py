"""Advice on a study that is set up, as `creak advise` gives it."""

from __future__ import annotations

from creak.studies.advise.choice import Choice, Settings, choose
from creak.studies.advise.facts import gather
from creak.studies.prepare.setup import Setup


def settings_of(setup: Setup) -> Settings:
    """What its study says already."""
    c = setup.study.config
    return Settings(setup.reduction, c.time, c.precheck, c.proof, c.reference.until, c.contact)


def advice_on(setup: Setup) -> Choice:
    return choose(settings_of(setup), gather(setup, lambda *_: None))
