"""Numbers as a person reads them."""

from __future__ import annotations

import math

_NARROW = "\u202f"  # narrow no-break space between thousands
MINUS = "\u2212"
NOTHING = "\u2013"  # where there is no number


def number(value: float, digits: int = 4) -> str:
    """``value`` to so many significant digits, thousands apart, without needless zeros.

    Whole numbers below 1e15 are written out in full: a count is a count.
    """
    if not math.isfinite(value):
        return str(value)
    if isinstance(value, int) or (value == int(value) and abs(value) < 1e15):
        return f"{int(value):,}".replace(",", _NARROW).replace("-", MINUS)
    if 1e-3 <= abs(value) < 1e6:
        decimals = max(digits - 1 - math.floor(math.log10(abs(value))), 0)
        text = f"{value:,.{decimals}f}"
        if "." in text:
            text = text.rstrip("0").rstrip(".")
    else:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        text = f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"
    return text.replace(",", _NARROW).replace("-", MINUS)


def fixed(value: float, decimals: int) -> str:
    """So many decimals, for columns that are read downwards."""
    return f"{value:,.{decimals}f}".replace(",", _NARROW).replace("-", MINUS)


def percent(share: float) -> str:
    """A share of one; never rounded to none or all of it where it is not."""
    if not math.isfinite(share):
        return str(share)
    value = 100.0 * share
    text = fixed(value, 1)
    if value > 100.0 and text == "100.0":
        text = "> 100"
    if value < 100.0 and text == "100.0":
        text = "> 99.9"
    if value > 0.0 and text == "0.0":
        text = "< 0.1"
    return f"{text.removesuffix('.0')}{_NARROW}%"


def count(amount: int, thing: str) -> str:
    """``1 file``, ``2 files``."""
    return f"{number(amount)} {thing}{'' if amount == 1 else 's'}"
