"""The cylinder 2D-1 and 2D-2 by NGSolve: Taylor–Hood elements (P3, P2) on a curved mesh, for comparison only.

python ngsolve_cylinder.py 2d1 0.05 1        flow, mesh size in m (a sixth of it on the cylinder), repeats

2D-1 is Newton's method for the steady equations. 2D-2 is SBDF2, viscous and pressure terms implicit, convection
extrapolated, with one factorisation (step 0.01 s/m times the mesh size, 6 s from a parabolic start, last five lift
periods). Forces are the residual of the momentum equation tested with a velocity that is one on the cylinder. Prints
one JSON object; wall and CPU time are those of the solution, with mesh and factorisation, without imports.
"""

import json
import sys
from time import perf_counter, process_time
from typing import Any

import ngsolve as ng
import numpy as np
from netgen.occ import Circle, OCCGeometry, Rectangle
from ngsolve import BilinearForm, CoefficientFunction, GridFunction, InnerProduct, dx
from ngsolve.solvers import Newton

NU, WIDTH = 1e-3, 0.41
STEP_BY_SIZE, END = 1e-2, 6.0  # s/m, s


def space_of(size: float) -> ng.FESpace:
    channel, circle = Rectangle(2.2, WIDTH).Face(), Circle((0.2, 0.2), 0.05).Face()
    channel.edges.name = "wall"
    circle.edges.name, circle.edges.maxh = "cylinder", size / 6
    shape = channel - circle
    for edge in shape.edges:
        edge.name = {0: "inlet", 2200: "outlet"}.get(round(1000 * edge.center.x), edge.name)
    mesh = ng.Mesh(OCCGeometry(shape, dim=2).GenerateMesh(maxh=size, grading=0.2)).Curve(3)
    return ng.VectorH1(mesh, order=3, dirichlet="wall|cylinder|inlet") * ng.H1(mesh, order=2)


def stokes(u: Any, p: Any, v: Any, q: Any) -> Any:
    return NU * InnerProduct(ng.Grad(u), ng.Grad(v)) - ng.div(u) * q - ng.div(v) * p


def unit_fields(space: ng.FESpace) -> list[Any]:
    """Vectors of the test velocities (1, 0) and (0, 1) on the cylinder."""
    fields = [GridFunction(space), GridFunction(space)]
    for field, direction in zip(fields, ((1, 0), (0, 1)), strict=True):
        field.components[0].Set(CoefficientFunction(direction), definedon=space.mesh.Boundaries("cylinder"))
    return [field.vec for field in fields]


def started(space: ng.FESpace, peak: float) -> GridFunction:
    field = GridFunction(space)
    inflow = CoefficientFunction((4 * peak * ng.y * (WIDTH - ng.y) / WIDTH**2, 0))
    field.components[0].Set(inflow, definedon=space.mesh.Boundaries("inlet"))
    return field


def steady(size: float) -> dict[str, Any]:
    space = space_of(size)
    (u, p), (v, q) = space.TnT()
    form = BilinearForm(space)
    form += (stokes(u, p, v, q) + InnerProduct(ng.Grad(u) * u, v)) * dx
    flow = started(space, 0.3)
    Newton(form, flow, maxerr=1e-12, inverse="umfpack", printing=False)
    residual = flow.vec.CreateVector()
    form.Apply(flow.vec, residual)
    # 2/(Ubar² D) with Ubar = 0.2, D = 0.1
    cd, cl = (-500 * InnerProduct(residual, field) for field in unit_fields(space))
    mesh, pressure = space.mesh, flow.components[1]
    dp = pressure(mesh(0.15 - 2e-5, 0.2)) - pressure(mesh(0.25 + 2e-5, 0.2))
    return {"dofs": space.ndof, "values": {"cd_mean": cd, "cl_mean": cl, "dp_mean": dp}}


def periodic(size: float) -> dict[str, Any]:
    space, step = space_of(size), STEP_BY_SIZE * size
    (u, p), (v, q) = space.TnT()
    linear, mass, implicit = BilinearForm(space), BilinearForm(space), BilinearForm(space)
    linear += stokes(u, p, v, q) * dx
    mass += InnerProduct(u, v) * dx
    implicit += (1.5 / step * InnerProduct(u, v) + stokes(u, p, v, q)) * dx
    for form in (linear, mass, implicit):
        form.Assemble()
    convection = BilinearForm(space, nonassemble=True)
    convection += InnerProduct(ng.Grad(u) * u, v) * dx
    flow, free = started(space, 1.5), space.FreeDofs()
    flow.vec.data -= linear.mat.Inverse(free, inverse="umfpack") @ linear.mat * flow.vec  # Stokes flow to begin with
    solve = implicit.mat.Inverse(free, inverse="umfpack")
    now, before, residual, change, advection, former = (flow.vec.CreateVector() for _ in range(6))
    before.data = flow.vec
    convection.Apply(flow.vec, former)
    tests, steps = unit_fields(space), round(END / step)
    forces = np.empty((steps, 2))
    for i in range(steps):
        now.data = flow.vec
        convection.Apply(now, advection)
        change.data = 2 * now - 0.5 * before
        residual.data = 2 * advection - former + linear.mat * now
        residual.data += (1.5 / step) * (mass.mat * now) - (1 / step) * (mass.mat * change)
        flow.vec.data = now - solve * residual
        # What is left of the momentum equation at the nodes of the cylinder is the force on it.
        change.data = flow.vec - now
        residual.data += implicit.mat * change
        forces[i] = [-20 * InnerProduct(residual, test) for test in tests]
        before.data, former.data = now, advection
    lift, time = forces[:, 1], step * np.arange(1, steps + 1)
    crossings = np.nonzero((time[1:] > END / 2) & (lift[:-1] < 0) & (lift[1:] >= 0))[0]
    if len(crossings) < 6:
        raise RuntimeError("the wake does not shed")
    at = time[crossings] - step * lift[crossings + 1] / (lift[crossings + 1] - lift[crossings]) + step
    last = slice(crossings[-6], crossings[-1])
    values = {"cd_max": forces[last, 0].max(), "cl_peak_to_peak": np.ptp(lift[last]), "st": 0.1 * 5 / (at[-1] - at[-6])}
    return {"dofs": space.ndof, "values": values}


if __name__ == "__main__":
    flow, size, repeats = sys.argv[1], float(sys.argv[2]), int(sys.argv[3])
    ng.SetNumThreads(1)
    runs = []
    for _ in range(repeats + (flow == "2d1")):
        wall, cpu = perf_counter(), process_time()
        found = {"2d1": steady, "2d2": periodic}[flow](size)
        runs.append([perf_counter() - wall, process_time() - cpu])
    print(json.dumps(found | {"runs": runs[-repeats:]}))
