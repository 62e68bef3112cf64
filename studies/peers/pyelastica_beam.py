"""The bar of CSM1 and CSM3 by PyElastica (Cosserat rod, explicit), for comparison only.

    python pyelastica_beam.py csm3 16 1          csm1 (damped until it rests) or csm3 (swinging for 10 s), elements,
    repeats

Its rods are round: mass, axial, shear and bending stiffness and the turning inertia are set to those of the plate
per metre of depth. The
step is 0.3 of the time in which a wave passes an element. Prints one JSON object.
"""

import json
import sys
from time import perf_counter, process_time

import elastica as ea
import numpy as np

E, NU, RHO, H, LENGTH, GRAVITY, SHEAR = 1.4e6, 0.4, 1000.0, 0.02, 0.35, 2.0, 0.862
PLATE = E / (1 - NU**2)


class System(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping):
    pass


def rod_of(elements: int) -> ea.CosseratRod:
    radius = H / np.sqrt(3)  # the radius of a disc with the plate's inertia to mass
    rod = ea.CosseratRod.straight_rod(
        elements,
        np.zeros(3),
        np.array([1.0, 0, 0]),
        np.array([0, 0, 1.0]),
        LENGTH,
        radius,
        density=RHO * H / (np.pi * radius**2),
        youngs_modulus=PLATE,
        shear_modulus=E / (2 * (1 + NU)),
    )
    shear, bending = SHEAR * E / (2 * (1 + NU)) * H, PLATE * H**3 / 12
    for i, stiffness in enumerate((shear, shear, PLATE * H)):
        rod.shear_matrix[i, i, :] = stiffness
    for i in range(2):
        rod.bend_matrix[i, i, :] = bending
    return rod


def solve(case: str, elements: int) -> dict:
    system, rod = System(), rod_of(elements)
    system.append(rod)
    system.constrain(rod).using(ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    system.add_forcing_to(rod).using(ea.GravityForces, acc_gravity=np.array([0, -GRAVITY, 0]))
    step = 0.3 * LENGTH / elements / np.sqrt(PLATE / RHO)
    end = {"csm1": 4.0, "csm3": 10.0}[case]
    if case == "csm1":
        system.dampen(rod).using(ea.AnalyticalLinearDamper, uniform_damping_constant=10.0, time_step=step)
    system.finalize()
    stepper, steps, time = ea.PositionVerlet(), int(np.ceil(end / step)), np.float64(0.0)
    stride = max(1, int(1e-3 / step))
    record = []
    for i in range(steps):
        time = stepper.step(system, time, step)
        if i % stride == 0:
            record.append((float(time), *rod.position_collection[:2, -1]))
    time, x, y = np.array(record).T
    if not np.isfinite(y).all():
        raise RuntimeError("not finite")
    return {"steps": steps, "values": evaluated(case, time, x - LENGTH, y)}


def evaluated(case: str, time, ux, uy) -> dict:
    if case == "csm1":
        return {"tip_ux.mean": ux[-1], "tip_uy.mean": uy[-1]}
    mean = (uy.max() + uy.min()) / 2
    up = np.nonzero((uy[:-1] < mean) & (uy[1:] >= mean))[0]
    at = time[up] + (mean - uy[up]) / (uy[up + 1] - uy[up]) * (time[up + 1] - time[up])
    window = slice(up[0], up[-1])
    return {
        "tip_uy.mean": (uy[window].max() + uy[window].min()) / 2,
        "tip_uy.amplitude": np.ptp(uy[window]) / 2,
        "tip_uy.frequency_hz": (len(at) - 1) / (at[-1] - at[0]),
    }


def main() -> None:
    case, elements, repeats = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    runs = []
    for _ in range(repeats + 1):
        begin = perf_counter(), process_time()
        found = solve(case, elements)
        runs.append([perf_counter() - begin[0], process_time() - begin[1]])
    print(json.dumps(found | {"runs": runs[1:]}))


if __name__ == "__main__":
    main()
