"""The bar of CSM1 and CSM3 by PyElastica (Cosserat rod, explicit), for comparison only.

python pyelastica_beam.py csm3 16 1      csm1 (damped until it rests) or csm3 (swinging for 10 s), elements, repeats

Its rods are round: mass, axial, shear and bending stiffness and the turning inertia are set to those of the plate per
metre of depth. The step is 0.3 of the time in which a wave passes an element. Prints one JSON object.
"""

import json
import sys
from time import perf_counter, process_time
from typing import Any

import elastica as ea
import numpy as np

E, NU, RHO, H, LENGTH, GRAVITY, SHEAR = 1.4e6, 0.4, 1000.0, 0.02, 0.35, 2.0, 0.862
PLATE = E / (1 - NU**2)


class System(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping):
    pass


def rod_of(elements: int) -> ea.CosseratRod:
    radius = H / np.sqrt(3)  # the radius of a disc with the plate's inertia to mass
    axes = np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    density, shear_modulus = RHO * H / (np.pi * radius**2), E / (2 * (1 + NU))
    moduli = {"youngs_modulus": PLATE, "shear_modulus": shear_modulus}
    rod = ea.CosseratRod.straight_rod(elements, *axes, LENGTH, radius, density=density, **moduli)
    for i, stiffness in enumerate((SHEAR * shear_modulus * H, SHEAR * shear_modulus * H, PLATE * H)):
        rod.shear_matrix[i, i, :] = stiffness
    for i in range(2):
        rod.bend_matrix[i, i, :] = PLATE * H**3 / 12
    return rod


def solve(case: str, elements: int) -> dict[str, Any]:
    system, rod = System(), rod_of(elements)
    system.append(rod)
    system.constrain(rod).using(ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    system.add_forcing_to(rod).using(ea.GravityForces, acc_gravity=np.array([0, -GRAVITY, 0]))
    step = 0.3 * LENGTH / elements / np.sqrt(PLATE / RHO)
    if case == "csm1":
        system.dampen(rod).using(ea.AnalyticalLinearDamper, uniform_damping_constant=10.0, time_step=step)
    system.finalize()
    steps, now = int(np.ceil({"csm1": 4.0, "csm3": 10.0}[case] / step)), np.float64(0.0)
    stepper, stride, record = ea.PositionVerlet(), max(1, int(1e-3 / step)), []
    for i in range(steps):
        now = stepper.step(system, now, step)
        if i % stride == 0:
            record.append((float(now), *rod.position_collection[:2, -1]))
    time, x, y = np.array(record).T
    if not np.isfinite(y).all():
        raise RuntimeError("not finite")
    if case == "csm1":
        return {"dofs": elements, "values": {"tip_ux.mean": x[-1] - LENGTH, "tip_uy.mean": y[-1]}}
    middle = (y.max() + y.min()) / 2
    up = np.nonzero((y[:-1] < middle) & (y[1:] >= middle))[0]
    at = time[up] + (middle - y[up]) / (y[up + 1] - y[up]) * (time[up + 1] - time[up])
    swing = y[up[0] : up[-1]]
    values = {
        "tip_uy.mean": (swing.max() + swing.min()) / 2,
        "tip_uy.amplitude": np.ptp(swing) / 2,
        "tip_uy.frequency_hz": (len(at) - 1) / (at[-1] - at[0]),
    }
    return {"dofs": elements, "values": values}


if __name__ == "__main__":
    case, elements, repeats = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    runs = []
    for _ in range(repeats + 1):  # the first compiles
        wall, cpu = perf_counter(), process_time()
        found = solve(case, elements)
        runs.append([perf_counter() - wall, process_time() - cpu])
    print(json.dumps(found | {"runs": runs[1:]}))
