"""A plate of aspect 2 in a steady stream by PteraSoftware's rings of vortices, for comparison only.

python pterasoftware_plate.py 30 12 5        angle (°), panels along the chord, timed runs

The flow has no viscosity and leaves the plate at its trailing edge. Prints one JSON object: coefficients of drag and
lift, and wall and CPU time of each run, s, with the making of its panels.
"""

import json
import sys
from time import perf_counter, process_time

from pterasoftware.geometry.airfoil import Airfoil
from pterasoftware.geometry.airplane import Airplane
from pterasoftware.geometry.wing import Wing
from pterasoftware.geometry.wing_cross_section import WingCrossSection
from pterasoftware.operating_point import OperatingPoint
from pterasoftware.problems import SteadyProblem
from pterasoftware.steady_ring_vortex_lattice_method import SteadyRingVortexLatticeMethodSolver

SPAN = 2.0  # By the chord


def solve(angle: float, panels: int) -> dict[str, float]:
    def section(y: float, along: int | None) -> WingCrossSection:
        return WingCrossSection(
            airfoil=Airfoil(name="naca0001"),
            num_spanwise_panels=along,
            spanwise_spacing=along and "uniform",
            Lp_Wcsp_Lpp=(0.0, y, 0.0),
        )

    wing = Wing(
        wing_cross_sections=[section(0.0, round(SPAN) * panels), section(SPAN, None)],
        Ler_Gs_Cgs=(0.0, -SPAN / 2, 0.0),
        num_chordwise_panels=panels,
        chordwise_spacing="uniform",
    )
    plate = Airplane(wings=[wing], s_ref=SPAN, c_ref=1.0, b_ref=SPAN)
    stream = OperatingPoint(rho=1.0, vCg__E=1.0, alpha=angle)
    solver = SteadyRingVortexLatticeMethodSolver(SteadyProblem([plate], stream))
    solver.run()
    forward, _, down = solver.airplanes[0].forceCoefficients_W
    return {"cd": float(-forward), "cl": float(-down)}


if __name__ == "__main__":
    angle, panels, repeats = float(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    runs = []
    for _ in range(repeats + 1):  # the first compiles
        wall, cpu = perf_counter(), process_time()
        values = solve(angle, panels)
        runs.append([perf_counter() - wall, process_time() - cpu])
    print(json.dumps({"values": values, "runs": runs[1:]}))
