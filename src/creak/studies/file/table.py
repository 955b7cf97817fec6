"""A table of the study file, and the numbers it may hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, get_args, get_origin

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from creak.given import LARGEST, SMALLEST


def _of_size(value: float) -> float:
    if abs(value) > LARGEST or 0.0 < abs(value) < SMALLEST:
        raise ValueError(f"is not between {SMALLEST:g} and {LARGEST:g} in size")
    return value


Size = AfterValidator(_of_size)
Finite = Annotated[float, Field(allow_inf_nan=False), Size]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False), Size]
NonNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False), Size]
Dof = Literal["x", "y", "z", "rx", "ry", "rz"]
DOFS: tuple[Dof, ...] = ("x", "y", "z", "rx", "ry", "rz")


def _kinds(annotation: Any) -> set[Any]:
    """The types that an annotation is made of, and those of the values that it names."""
    inner = get_args(annotation)
    if get_origin(annotation) is Literal:
        return {type(value) for value in inner}
    return {kind for one in inner for kind in _kinds(one)} if inner else {annotation}


def _is_table(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _is_or_holds_truth(value: Any, *, inside: bool) -> bool:
    """Whether a value, a list, or (`inside`) a mapping holds true or false; tables look after their own."""
    if isinstance(value, Mapping) and inside:
        return any(_is_or_holds_truth(v, inside=inside) for v in value.values())
    if isinstance(value, list | tuple):
        return any(_is_or_holds_truth(v, inside=inside) for v in value)
    return isinstance(value, bool | np.bool_)


class Table(BaseModel):
    """A table of the study; unknown keys are errors. The texts below the keys are the descriptions of its schema
    (`studies.file.schema`)."""

    model_config = ConfigDict(extra="forbid", frozen=True, str_strip_whitespace=True)

    @model_validator(mode="before")
    @classmethod
    def _no_truth_for_a_number(cls, data: Any) -> Any:
        """Pydantic takes true for 1."""
        wrong = []
        for name, field in cls.model_fields.items() if isinstance(data, Mapping) else ():
            key, kinds = field.alias or name, _kinds(field.annotation)
            value = data.get(key)
            if not kinds & {bool, Any} and _is_or_holds_truth(value, inside=not any(map(_is_table, kinds))):
                kind = PydanticCustomError("truth", "is true or false, which says nothing here")
                wrong.append(InitErrorDetails(type=kind, loc=(key,), input=value))
        if wrong:
            raise ValidationError.from_exception_data(cls.__name__, wrong)
        return data

    @field_validator("*")
    @classmethod
    def _no_zero_bytes(cls, value: Any) -> Any:
        """No file that creak writes can keep them."""
        texts = [value] if isinstance(value, str) else value if isinstance(value, dict | list) else []
        if any(isinstance(text, str) and "\0" in text for text in texts):
            raise ValueError("holds a zero byte (\\u0000)")
        return value
