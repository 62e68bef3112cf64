"""Unpacked FMUs in fmpy, with their variables and the messages of their loggers."""

from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Slave


class Unpacked:
    """An FMU in a folder; `load` loads its library, again after `freeLibrary`."""

    def __init__(self, folder: Path | str, name: str = "unit", guid: str | None = None):
        self.folder = Path(folder)
        self.description = fmpy.read_model_description(str(folder), validate=False)
        self.variables = self.description.modelVariables
        self.messages: list[str] = []
        self.place: dict[str, Any] = {
            "guid": guid or self.description.guid,
            "unzipDirectory": str(folder),
            "modelIdentifier": self.description.coSimulation.modelIdentifier,
            "instanceName": name,
        }
        self.load()

    def load(self) -> None:
        super().__init__(**self.place)

    def note(self, *said: Any) -> None:
        """Keep the message of a call of the logger, its last argument."""
        self.messages.append(said[-1].decode())


class FMU2Unpacked(Unpacked, FMU2Slave):  # fmpy takes the version of FMI from the name of the class
    """An FMU of FMI 2.0; `log` has its logger."""

    def __init__(self, *arguments: Any, **keywords: Any):
        super().__init__(*arguments, **keywords)
        self.log = fmi2CallbackFunctions(logger=fmi2CallbackLoggerTYPE(self.note))


class FMU3Unpacked(Unpacked, FMU3Slave):
    """An FMU of FMI 3.0."""

    def begin(self) -> None:
        """Make an instance that logs."""
        self.instantiate(loggingOn=True, logMessage=self.note)
