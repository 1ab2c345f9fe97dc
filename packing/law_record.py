"""What a packing records of the contact law that it was made with: its name and its numbers.

Laws of `packing.contact_law` are found again by their names; those of others are not imported on
the word of a file.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

from packing.arguments.numbers import shown
from packing.contact_law.contact_law import ContactLaw
from packing.contact_law.hertz import Hertz
from packing.plain_values import plain_value


def law_record(law: ContactLaw) -> dict[str, Any]:
    """``{"law": "module.Name", ...}`` with the fields of a frozen dataclass.

    ValueError for what is no frozen dataclass, or has a field that no file could hold.
    """
    name = f"{type(law).__module__}.{type(law).__qualname__}"
    parameters = getattr(type(law), "__dataclass_params__", None)
    if not is_dataclass(law) or not getattr(parameters, "frozen", False):
        raise ValueError(f"contact = {law!r}: a law of a scene is a frozen dataclass")
    try:
        hash(law)
    except TypeError as why:
        raise ValueError(f"contact = {law!r}: a law of a scene can be hashed ({why})") from None
    numbers = {f.name: getattr(law, f.name) for f in fields(law)}
    return {"law": name} | {k: plain_value(f"{k} of contact", v) for k, v in numbers.items()}


_KNOWN = {f"{kind.__module__}.{kind.__qualname__}": kind for kind in (Hertz,)}


def recorded_law(record: dict[str, Any]) -> ContactLaw:
    """The law of a `law_record`; ValueError for one that is not of `packing.contact_law`."""
    kind = _KNOWN.get(str(record.get("law")))
    if kind is None:
        raise ValueError(
            f"the packing was made with the contact law {shown(record.get('law'))}, which is not "
            "known here: give it yourself"
        )
    return kind(**{k: v for k, v in record.items() if k != "law"})
