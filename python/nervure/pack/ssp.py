"""The units of a scene as one file for masters that read System Structure and Parameterization (SSP 1.0)."""

import re
from pathlib import Path

import fmpy
from lxml import etree

from nervure.errors import SceneError
from nervure.pack import package
from nervure.scene import Scene

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"


def structure(name: str, fmus: dict[str, Path], end: float) -> bytes:
    """SystemStructure.ssd of the units `fmus` by name: every input is connected with the output of the same name."""
    root = etree.Element(
        f"{{{SSD}}}SystemStructureDescription", nsmap={"ssd": SSD, "ssc": SSC}, version="1.0", name=name
    )
    # A name of SSP is an identifier in some readers.
    system = etree.SubElement(root, f"{{{SSD}}}System", name=re.sub(r"\W", "_", name))
    elements = etree.SubElement(system, f"{{{SSD}}}Elements")
    outputs: dict[str, str] = {}
    inputs: list[tuple[str, str]] = []
    for unit, path in fmus.items():
        about = {"name": unit, "type": "application/x-fmu-sharedlibrary", "source": f"resources/{path.name}"}
        component = etree.SubElement(elements, f"{{{SSD}}}Component", **about)
        connectors = etree.SubElement(component, f"{{{SSD}}}Connectors")
        for variable in fmpy.read_model_description(str(path), validate=False).modelVariables:
            if variable.causality == "output":
                outputs[variable.name] = unit
            elif variable.causality == "input":
                inputs.append((variable.name, unit))
            else:
                continue
            connector = etree.SubElement(connectors, f"{{{SSD}}}Connector", name=variable.name, kind=variable.causality)
            etree.SubElement(connector, f"{{{SSC}}}{variable.type}")
    connections = etree.SubElement(system, f"{{{SSD}}}Connections")
    for variable, unit in inputs:
        if source := outputs.get(variable):
            ends = {"startElement": source, "startConnector": variable, "endElement": unit, "endConnector": variable}
            etree.SubElement(connections, f"{{{SSD}}}Connection", **ends)
    etree.SubElement(root, f"{{{SSD}}}DefaultExperiment", startTime="0.0", stopTime=repr(float(end)))
    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))


def pack(scene: Scene, folder: Path) -> Path:
    """Write the units of `scene` and `NAME.ssp` with both of them into `folder` and return the path of the latter."""
    kinds = package.kinds(scene)
    if len(kinds) < 2:
        raise SceneError(f"the scene {scene.name} has only one unit, the {kinds[0]}: there is nothing to connect")
    fmus = {kind: package.pack(kind, scene, folder) for kind in kinds}
    contents = {"SystemStructure.ssd": structure(scene.name, fmus, scene.time.end)}
    contents |= {f"resources/{path.name}": path.read_bytes() for path in fmus.values()}
    return package.write_archive(folder / f"{scene.name}.ssp", contents)
