"""A rigid body in prescribed motion by NGSolve, for comparison only: Taylor–Hood elements (P3, P2) on a curved mesh
that moves with the body.

python ngsolve_body.py oscillating 0.4 0.005 15 20      case, mesh size near the body, step, end, outer radius
python ngsolve_body.py hover 0.4 0.005 16 15

The unknown is the velocity in the axes of the body:

    du/dt + (u − w)·grad u + omega e_z × u = −grad p + nu laplace u,   div u = 0

with w the velocity of these axes, u = w on the body and 0 on the outer circle. SBDF2, viscous and pressure terms
implicit, the rest extrapolated, with one factorisation; the start is the projection of a fluid at rest. Forces are the
residual of the momentum equation tested with a velocity that is one on the body. Prints time and force along x and y
at every step, as CSV; density 1.
"""

import sys
from collections.abc import Callable
from math import cos, pi, sin

import ngsolve as ng
from netgen.occ import Circle, Glue, OCCGeometry, WorkPlane
from ngsolve import BilinearForm, CoefficientFunction, GridFunction, InnerProduct, Parameter, dx

LEAK = 1e-9  # Of the pressure into the continuity equation, which fixes its constant

Pose = tuple[float, float, float, float]
"""Angle (rad), its rate, and velocity of the pivot along x and y."""


def oscillating(t: float) -> Pose:
    return 0.0, 0.0, -cos(2 * pi * t / 5), 0.0


def hover(t: float) -> Pose:
    omega = 2 * pi * 0.25
    return pi / 2 + pi / 4 * sin(omega * t), pi / 4 * omega * cos(omega * t), -1.4 * omega * sin(omega * t), 0.0


CASES: dict[str, tuple[Callable[[float], Pose], float, float]] = {
    "oscillating": (oscillating, 0.01, 3.0),
    "hover": (hover, 1.4 * 2 * pi * 0.25 / 75, 4.0),
}
"""Motion, viscosity, and radius of the fine part of the mesh."""


def mesh_of(case: str, size: float, fine: float, radius: float) -> ng.Mesh:
    outer, near = Circle((0, 0), radius).Face(), Circle((0, 0), fine).Face()
    body = WorkPlane().Ellipse(0.5, 0.06).Face() if case == "hover" else Circle((0, 0), 0.5).Face()
    outer.edges.name, body.edges.name = "far", "body"
    body.edges.maxh = size / (10 if case == "hover" else 8)
    ring, inner = outer - near, near - body
    inner.faces.maxh, ring.faces.maxh = size, radius / 6
    geometry = OCCGeometry(Glue([inner, ring]), dim=2)
    return ng.Mesh(geometry.GenerateMesh(maxh=radius / 6, grading=0.25)).Curve(3)


def main(case: str, size: float, step: float, end: float, radius: float) -> None:
    motion, nu, fine = CASES[case]
    mesh = mesh_of(case, size, fine, radius)
    space = ng.VectorH1(mesh, order=3, dirichlet="body|far") * ng.H1(mesh, order=2)
    (u, p), (v, q) = space.TnT()
    stokes = nu * InnerProduct(ng.Grad(u), ng.Grad(v)) - ng.div(u) * q - ng.div(v) * p - LEAK * p * q
    omega, vx, vy = Parameter(0.0), Parameter(0.0), Parameter(0.0)
    axes = CoefficientFunction((vx - omega * ng.y, vy + omega * ng.x))
    mass, implicit, start = BilinearForm(space), BilinearForm(space), BilinearForm(space)
    mass += InnerProduct(u, v) * dx
    implicit += (1.5 / step * InnerProduct(u, v) + stokes) * dx
    start += (1e6 * InnerProduct(u, v) + stokes) * dx
    for form in (mass, implicit, start):
        form.Assemble()
    convection = BilinearForm(space, nonassemble=True)
    convection += (InnerProduct(ng.Grad(u) * (u - axes), v) + omega * (u[0] * v[1] - u[1] * v[0])) * dx
    flow, boundary, free = GridFunction(space), GridFunction(space), space.FreeDofs()
    tests = [GridFunction(space), GridFunction(space)]
    for test, direction in zip(tests, ((1, 0), (0, 1)), strict=True):
        test.components[0].Set(CoefficientFunction(direction), definedon=mesh.Boundaries("body"))

    def place(t: float) -> float:
        """Set the velocity of the axes and of the boundaries at t; the angle."""
        angle, rate, x, y = motion(t)
        omega.Set(rate)
        vx.Set(cos(angle) * x + sin(angle) * y)
        vy.Set(cos(angle) * y - sin(angle) * x)
        both = mesh.BoundaryCF({"body": axes, "far": CoefficientFunction((0.0, 0.0))})
        boundary.components[0].Set(both, definedon=mesh.Boundaries("body|far"))
        return angle

    place(0.0)
    now, before, residual, change, advection, former = (flow.vec.CreateVector() for _ in range(6))
    flow.vec.data = boundary.vec
    residual.data = start.mat * flow.vec
    flow.vec.data -= start.mat.Inverse(free, inverse="umfpack") * residual
    before.data = flow.vec
    convection.Apply(flow.vec, former)
    solve = implicit.mat.Inverse(free, inverse="umfpack")
    print("time,drag,lift")
    for i in range(round(end / step)):
        now.data = flow.vec
        place(i * step)
        convection.Apply(now, advection)
        angle = place((i + 1) * step)
        change.data = 2 * now - 0.5 * before
        flow.vec.data = boundary.vec
        residual.data = implicit.mat * flow.vec + 2 * advection - former
        residual.data -= (1 / step) * (mass.mat * change)
        flow.vec.data -= solve * residual
        # What is left of the momentum equation at the nodes of the body is the force on it.
        residual.data = implicit.mat * flow.vec + 2 * advection - former
        residual.data -= (1 / step) * (mass.mat * change)
        along, across = (-InnerProduct(residual, test.vec) for test in tests)
        drag, lift = cos(angle) * along - sin(angle) * across, sin(angle) * along + cos(angle) * across
        print(f"{(i + 1) * step:.9g},{drag:.9g},{lift:.9g}", flush=True)
        before.data, former.data = now, advection


if __name__ == "__main__":
    ng.SetNumThreads(1)
    main(sys.argv[1], *map(float, sys.argv[2:6]))
