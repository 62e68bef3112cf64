"""The units of a scene as one file of System Structure and Parameterization (SSP 1.0)."""

import re
from pathlib import Path

import fmpy
from lxml import etree
from lxml.builder import ElementMaker

from nervure.errors import SceneError
from nervure.resources import COUPLERS
from nervure.scene import Scene
from nervure.units import package
from nervure.units.describe import describe_all, unit_kinds
from nervure.units.fmu import prefixes

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"


def structure(name: str, fmus: dict[str, Path], end: float, wings: int = 0) -> bytes:
    """Return SystemStructure.ssd of the units `fmus` by name, rods before the `wings`: each input is connected to the
    output of the same name; for several rods, the fluid's names begin with `beam[1].` and so on."""
    names = {"ssd": SSD, "ssc": SSC}
    ssd, ssc = ElementMaker(namespace=SSD, nsmap=names), ElementMaker(namespace=SSC, nsmap=names)
    rods = [unit for unit in fmus if unit not in ("body", *COUPLERS)]
    beams = dict(zip(rods, prefixes(len(rods) - wings, wings), strict=True))
    components, outputs, inputs = [], dict[str, tuple[str, str]](), list[tuple[str, str, str]]()
    for unit, path in fmus.items():
        variables = fmpy.read_model_description(str(path), validate=False).modelVariables
        # By the name at the fluid.
        beam = beams.get(unit, "")
        outputs |= {beam + v.name: (unit, v.name) for v in variables if v.causality == "output"}
        inputs += [(beam + v.name, unit, v.name) for v in variables if v.causality == "input"]
        exchanged = [v for v in variables if v.causality in ("input", "output")]
        connectors = [ssd.Connector(ssc(v.type), name=v.name, kind=v.causality) for v in exchanged]
        about = {"name": unit, "type": "application/x-fmu-sharedlibrary", "source": f"resources/{path.name}"}
        components.append(ssd.Component(ssd.Connectors(*connectors), **about))
    connections = [
        ssd.Connection(startElement=source, startConnector=output, endElement=unit, endConnector=name)
        for variable, unit, name in inputs
        for source, output in [outputs.get(variable, ("", ""))]
        if source
    ]
    # Some readers want an identifier.
    system = ssd.System(ssd.Elements(*components), ssd.Connections(*connections), name=re.sub(r"\W", "_", name))
    experiment = ssd.DefaultExperiment(startTime="0.0", stopTime=repr(float(end)))
    root = ssd.SystemStructureDescription(system, experiment, version="1.0", name=name)
    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))


def pack(scene: Scene, folder: Path, fmus: dict[str, Path] | None = None) -> Path:
    """Write `NAME.ssp` with the units of `scene` into `folder` and return its path; `fmus` are the FMUs by unit, by
    default packed into `folder` first."""
    kinds = unit_kinds(scene)
    if len(kinds) < 2:
        only = next(iter(kinds))
        raise SceneError(f"the scene {scene.name} has only one unit, the {only}: there is nothing to connect")
    if "body" in kinds:
        raise SceneError(
            f"the scene {scene.name} has a flyer: what it carries is read before each step, which a system structure "
            "cannot say"
        )
    fmus = fmus or {name: package.pack(unit, folder) for name, unit in describe_all(scene).items()}
    contents = {"SystemStructure.ssd": structure(scene.name, fmus, scene.time.end, [*kinds.values()].count("wing"))}
    contents |= {f"resources/{path.name}": path.read_bytes() for path in fmus.values()}
    return package.write_archive(folder / f"{scene.name}.ssp", contents)
