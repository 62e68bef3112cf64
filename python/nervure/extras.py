"""Packages that only a part of nervure needs: they are imported when they are used."""

import importlib
import sys
from typing import Any

from nervure.errors import InputError


def require(package: str, purpose: str) -> Any:
    """Return a package; raise `InputError` with the line that installs it where it is missing."""
    try:
        return importlib.import_module(package)
    except ImportError as error:
        name = package.partition(".")[0]
        raise InputError(
            f"{purpose} needs the package {name}, which is not installed: `{sys.executable} -m pip install {name}`"
        ) from error
