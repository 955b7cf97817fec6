"""A table of the study file, and the numbers it may hold."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, field_validator

from creak.model.magnitude import LARGEST, SMALLEST


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


class Table(BaseModel):
    """A table of the study; unknown keys are errors. The texts below the keys are the descriptions of its schema
    (`studies.file.schema`)."""

    model_config = ConfigDict(extra="forbid", frozen=True, str_strip_whitespace=True)

    @field_validator("*")
    @classmethod
    def _no_zero_bytes(cls, value: Any) -> Any:
        """No file that creak writes can keep them."""
        texts = [value] if isinstance(value, str) else value if isinstance(value, dict | list) else []
        if any(isinstance(text, str) and "\0" in text for text in texts):
            raise ValueError("holds a zero byte (\\u0000)")
        return value
