"""Enumerations that callers may also name by their values."""

import enum
from typing import Any


class Choice(str, enum.Enum):
    """Base of enumerations. ValueError for an unknown value lists the known ones."""

    @classmethod
    def _missing_(cls, value: Any) -> "Choice":
        known = ", ".join(repr(member.value) for member in cls)
        raise ValueError(f"{value!r} is no {cls.__name__}: expected one of {known}")
