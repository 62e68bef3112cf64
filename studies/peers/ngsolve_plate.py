"""A plate of no thickness in a stream by NGSolve: Taylor–Hood elements (P3, P2) on a mesh with a slit, as a reference.

python ngsolve_plate.py 100 0 30 60 90 > plate_re100.csv        Reynolds number and angles of attack, °

The stream of speed 1 starts at once around a plate of chord 1 in a periodic box, whose mean velocity is held by a
uniform force. Momentum of the box is constant, so that force times the area is the force on the plate; convection has
the form that keeps it. Pressure jumps across the plate and across half a circle over it, where the jump tends to 0.
SBDF2, viscous and pressure terms implicit, convection extrapolated; the step grows after the start, when the flow at
the edges is fastest.

The values are those of the fine mesh. `*_mesh` is the fine less the coarse one, of which all elements are twice as
large: the error of the fine one at first order, as that of the square root at the edges. `*_step` is the error of the
step at second order, from half the step on the coarse mesh. "mean" is the mean over t = 1 to 3.9, "steady" the solution
by Newton's method.
"""

import sys
from collections.abc import Callable
from math import cos, hypot, radians, sin
from typing import Any

import ngsolve as ng
import numpy as np
from netgen import occ
from ngsolve import BilinearForm, CoefficientFunction, GridFunction, InnerProduct, dx

BOX, CENTRE = (6.0, 4.0), (1.7, 2.0)  # Chords
AREA = BOX[0] * BOX[1]
ORDER = 3
COARSE, FINE = (0.12, 2e-3), (0.06, 1e-3)  # Elements along the plate and at its edges; others have up to 4 times more
STEP, END = 2.5e-3, 4.0
FRACTIONS, PHASE = (16, 8, 4, 2), 16  # Of the step by which it grows after the start, and the number of steps of each
TIMES = np.arange(5, 41) / 10
COMPRESSIBLE = 1e-8  # Compressibility, which fixes the level of the pressure and lets a factor do without pivots
TOLERANCE, ITERATIONS = 1e-8, 20  # Of Newton's method


def mesh_of(angle: float, along: float, edge: float) -> ng.Mesh:
    """Return a mesh with a plate at an angle (rad), whose front is up, and with the half circle over it."""
    tangent, normal = (cos(angle), -sin(angle)), (sin(angle), cos(angle))
    front, back, top = (
        occ.Pnt(*(c + share * d for c, d in zip(CENTRE, axis, strict=True)), 0)
        for share, axis in ((-0.5, tangent), (0.5, tangent), (0.5, normal))
    )
    over = occ.Face(occ.Wire([occ.Segment(front, back), occ.ArcOfCircle(back, top, front)]))
    rest = occ.Rectangle(*BOX).Face() - over
    over.faces.name, rest.faces.name = "over", "rest"
    shape = occ.Glue([rest, over])
    for part in shape.edges:
        if hypot(part.center.x - CENTRE[0], part.center.y - CENTRE[1]) < 1e-9:
            part.name, part.maxh = "plate", along
    for vertex in shape.vertices:
        if min(hypot(vertex.p.x - end.x, vertex.p.y - end.y) for end in (front, back)) < 1e-9:
            vertex.maxh = edge
    for name, axis, length in zip("xy", (occ.X, occ.Y), BOX, strict=True):
        shift = occ.gp_Trsf.Translation(length * axis)
        shape.edges.Min(axis).Identify(shape.edges.Max(axis), name, occ.IdentificationType.PERIODIC, shift)
    return ng.Mesh(occ.OCCGeometry(shape, dim=2).GenerateMesh(maxh=4 * along, grading=0.25))


class Flow:
    """The equations on a mesh."""

    def __init__(self, mesh: ng.Mesh, re: float):
        velocity = ng.VectorH1(mesh, order=ORDER, dirichlet="plate")
        pressures = (ng.H1(mesh, order=ORDER - 1, definedon=part) for part in ("over", "rest"))
        self.re, self.mesh = re, mesh
        self.space = space = ng.Periodic(velocity) * ng.Periodic(next(pressures)) * ng.Periodic(next(pressures))
        self.free = space.FreeDofs()
        (u, *_), (v, *_) = space.TnT()
        self.convection = BilinearForm(space, nonassemble=True)
        self.convection += -InnerProduct(ng.OuterProduct(u, u), ng.Grad(v)) * dx
        self.pushes = []
        for direction in ((1, 0), (0, 1)):
            push = ng.LinearForm(space)
            push += InnerProduct(CoefficientFunction(direction), v) * dx
            self.pushes.append(push.Assemble().vec)

    def implicit(self, rate: float) -> Any:
        """Return the terms that are implicit, with a rate of change."""
        (u, *p), (v, *q) = self.space.TnT()
        form = (rate * InnerProduct(u, v) + InnerProduct(ng.Grad(u), ng.Grad(v)) / self.re) * dx
        for part, one, other in zip(("over", "rest"), p, q, strict=True):
            form += -(ng.div(u) * other + ng.div(v) * one + COMPRESSIBLE * one * other) * dx(part)
        return form

    def held(self, matrix: Any, inverse: str) -> Callable[[Any, Any, tuple[float, float]], np.ndarray]:
        """Return the function that solves for a right side and a mean velocity; it returns the force on the plate."""
        solve = matrix.Inverse(self.free, inverse=inverse)
        answers = [push.CreateVector() for push in self.pushes]
        for answer, push in zip(answers, self.pushes, strict=True):
            answer.data = solve * push
        means = np.array([[InnerProduct(push, answer) for answer in answers] for push in self.pushes])

        def solved(right: Any, into: Any, mean: tuple[float, float]) -> np.ndarray:
            into.data = solve * right
            lack = [AREA * m - InnerProduct(push, into) for m, push in zip(mean, self.pushes, strict=True)]
            force = np.linalg.solve(means, lack)
            for size, answer in zip(force.tolist(), answers, strict=True):
                into.data += size * answer
            return AREA * force

        return solved

    def started(self, step: float) -> tuple[np.ndarray, GridFunction]:
        """Return time and the coefficients of drag and lift, `[steps, 3]`, and the flow at the end."""
        (u, *_), (v, *_) = self.space.TnT()
        mass = BilinearForm(self.space)
        mass += InnerProduct(u, v) * dx
        mass.Assemble()
        flow = GridFunction(self.space)
        flow.components[0].Set(CoefficientFunction((1, 0)))
        change, right = flow.vec.CreateVector(), flow.vec.CreateVector()
        past: list[tuple[Any, Any]] = []  # Flows and their convection, the last one first
        rows, time = [], 0.0
        for fraction in (*FRACTIONS, 1):
            own = step / fraction
            past = past[1::2]  # The next step is twice as long
            for i in range(PHASE if fraction > 1 else round((END - time) / own)):
                now, advection = flow.vec.CreateVector(), flow.vec.CreateVector()
                now.data = flow.vec
                self.convection.Apply(now, advection)
                past = [(now, advection), *past[:2]]
                second = len(past) > 1
                if i == 0 or len(past) == 2:
                    form = BilinearForm(self.space)
                    form += self.implicit((1.5 if second else 1.0) / own)
                    solve = self.held(form.Assemble().mat, "sparsecholesky")
                if second:
                    before, former = past[1]
                    change.data = (2.0 / own) * now - (0.5 / own) * before
                    right.data = mass.mat * change - 2.0 * advection + former
                else:
                    change.data = (1.0 / own) * now
                    right.data = mass.mat * change - advection
                force = solve(right, flow.vec, (1.0, 0.0))
                time += own
                rows.append([time, *(2 * force)])
        return np.array(rows), flow

    def steady(self, flow: GridFunction) -> np.ndarray:
        """Return the coefficients of the steady flow, from a flow near it, by Newton's method."""
        (u, *_), (v, *_) = self.space.TnT()
        form = BilinearForm(self.space)
        form += self.implicit(0.0)
        form += -InnerProduct(ng.OuterProduct(u, u), ng.Grad(v)) * dx
        residual, change = flow.vec.CreateVector(), flow.vec.CreateVector()
        for _ in range(ITERATIONS):
            form.Apply(flow.vec, residual)
            form.AssembleLinearization(flow.vec)
            force = self.held(form.mat, "umfpack")(residual, change, (0.0, 0.0))
            flow.vec.data -= change
            if change.Norm() < TOLERANCE * flow.vec.Norm():
                return -2 * force
        raise RuntimeError(f"the steady flow is not found in {ITERATIONS} iterations")


def rows_of(re: float, angle: float, size: tuple[float, float], step: float) -> np.ndarray:
    """Return the coefficients at `TIMES`, their mean, and along the stream those of the steady flow, `[:, 2]`."""
    flow = Flow(mesh_of(radians(angle), *size), re)
    series, last = flow.started(step)
    time, coefficients = series[:, 0], series[:, 1:]
    part = (time > 1 - step / 2) & (time < 3.9 + step / 2)
    found = [np.interp(TIMES, time, column) for column in coefficients.T]
    rows = np.vstack([np.transpose(found), coefficients[part].mean(0)])
    print(f"{angle:g}°, {flow.mesh.ne} elements, step {step:g}: mean {rows[-1].round(5)}", file=sys.stderr, flush=True)
    return np.vstack([rows, flow.steady(last)]) if angle == 0 else rows


def main(re: float, angles: list[float]) -> None:
    print("angle,time,cd,cl,cd_mesh,cl_mesh,cd_step,cl_step")
    for angle in angles:
        fine, coarse, half = (rows_of(re, angle, *how) for how in ((FINE, STEP), (COARSE, STEP), (COARSE, STEP / 2)))
        errors = np.hstack([fine, fine - coarse, (half - coarse) * 4 / 3])
        for time, row in zip([*(f"{t:.1f}" for t in TIMES), "mean", "steady"], errors):
            print(f"{angle:g},{time}," + ",".join(f"{round(x, 5) + 0.0:.5f}" for x in row), flush=True)


if __name__ == "__main__":
    ng.SetNumThreads(1)
    main(float(sys.argv[1]), [float(angle) for angle in sys.argv[2:]])
