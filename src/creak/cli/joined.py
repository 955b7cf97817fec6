"""Parameters of a command that several options make: the command takes what they make, Typer sees the options."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import wraps
from typing import Any

from typer.models import ParameterInfo


@dataclass(frozen=True)
class _Joined:
    make: Callable[..., Any]
    instead: dict[str, Any] = field(default_factory=dict)

    def options(self) -> list[inspect.Parameter]:
        """Parameters of `make` whose defaults are options."""
        found = inspect.signature(self.make, eval_str=True).parameters.values()
        own = [p.replace(default=self.instead.get(p.name, p.default)) for p in found]
        return [p for p in own if isinstance(p.default, ParameterInfo)]


def joined(make: Callable[..., Any], **instead: Any) -> Any:
    """The default of a parameter that `make` makes of its own options; `instead` has other options for some of them."""
    return _Joined(make, instead)


def command(call: Callable[..., None]) -> Callable[..., None]:
    """A command as Typer takes it: options stand where it has what is `joined` of them."""
    own = inspect.signature(call, eval_str=True)
    made = {name: p.default for name, p in own.parameters.items() if isinstance(p.default, _Joined)}

    @wraps(call)
    def run(**given: Any) -> None:
        whole = {name: one.make(**{o.name: given.pop(o.name) for o in one.options()}) for name, one in made.items()}
        call(**given, **whole)

    told = [o for name, p in own.parameters.items() for o in (made[name].options() if name in made else [p])]
    run.__signature__ = own.replace(parameters=told)  # type: ignore[attr-defined]
    run.__annotations__ = {p.name: p.annotation for p in told}
    return run
