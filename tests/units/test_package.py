"""What an FMU carries to be read."""

import zipfile
from pathlib import Path

import fmpy
import pytest
from lxml import etree

from nervure.units import package
from nervure.units.describe import describe
from tests.conftest import COUPLED

pytestmark = pytest.mark.usefixtures("libraries")
both = pytest.mark.parametrize("kind", COUPLED)


@both
def test_fmu_explains_itself(kind, small_fsi3, tmp_path):
    with zipfile.ZipFile(package.pack(describe(kind, small_fsi3), tmp_path)) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    names = etree.fromstring(files["modelDescription.xml"]).xpath("//ScalarVariable/@name")
    page = files["documentation/index.html"].decode("utf-8")
    assert [name for name in names if "[" not in name and f"<td>{name}<td>" not in page] == []
    assert "<td>x[1] … x[21]<td>" in page and "<h2>Equations</h2>" in page
    assert {"documentation/licenses/LICENSE-MIT", "documentation/licenses/LICENSE-APACHE"} <= files.keys()
    assert files["model.png"].startswith(b"\x89PNG")


@both
def test_each_array_is_one_terminal(kind, small_fsi3, tmp_path):
    with zipfile.ZipFile(package.pack(describe(kind, small_fsi3), tmp_path)) as archive:
        terminals = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        variables = set(etree.fromstring(archive.read("modelDescription.xml")).xpath("//ScalarVariable/@name"))
    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    etree.XMLSchema(file=str(schema)).assertValid(terminals)
    sizes = {terminal.get("name"): len(terminal) for terminal in terminals.iter("Terminal")}
    exchanged = {"x", "y", "vx", "vy", "force_x", "force_y", "impedance"}
    assert sizes == dict.fromkeys(exchanged | ({"pressure_jump"} if kind == "fluid" else set()), 21)
    assert set(terminals.xpath("//@variableName")) <= variables
