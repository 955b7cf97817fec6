"""A piece of an instrument panel with several places that rattle or squeak: the example with something to rank."""

from creak_thesis.cockpit.study import FILES, write_cockpit

__all__ = ["FILES", "write_cockpit"]
