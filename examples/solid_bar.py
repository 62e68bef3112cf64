"""A two-dimensional elastic bar by finite elements of scikit-fem, in place of the rod.

A Saint Venant–Kirchhoff solid in plane strain, total Lagrangian: with F = 1 + grad u and E = ½ (Fᵀ F − 1),

    ∫ (rho_s − rho_f) (u'' − g)·w dA + ∫ F S : grad w dA = Σ_k [f_k − D_k (v_k(t + H) − v_k(t))]·w_k,

    S = lambda tr(E) 1 + 2 mu E,

by quadratic elements of four sides and two-step backward differences. Station k moves with the mean over its section,
by Simpson's rule, and w_k is the same of the test function: the power of the loads is that at the stations. The mass of
the displaced fluid is left out, as the momentum load asks. A root on a cylinder has its arc.

What this bar does differently from the rod is what beam theory leaves out. It needs scikit-fem and SciPy (both BSD).
In other masters than `nervure`, run it with OPENBLAS_NUM_THREADS=1: its matrices are too small for threads.
"""

import math
from typing import Any

import numpy as np
from contract import ContractUnit, backward_differences, root_of
from pythonfmu.enums import Fmi2Causality
from scipy.linalg import LinAlgError, solveh_banded
from skfem import Basis, ElementQuad2, ElementVector, MeshQuad, MeshQuad2

ACROSS, AT_ROOT = 2, 2
"""Elements across the bar, and how often the first ones are halved towards the root, in whose corners the stress is
singular: the tip of CSM1 is then off by 0.07 % of its way, without halving by 0.25 %."""

NODES = 2 * ACROSS + 1
SIMPSON = np.array([1, *[4, 2] * (ACROSS - 1), 4, 1]) / (6 * ACROSS)
"""Mean over a section by its nodes."""

TOLERANCE, MOST_ITERATIONS = 1e-11, 20
"""Of Newton's method: the last update of a node in lengths of the bar."""


class Bar:
    """The solid, along x from a clamped root: straight at x = 0, or the arc through (0, 0) of a circle behind it.

    The state is `u`, `v`, `u_before`, `v_before` `[columns, NODES, 2]`, m and m/s, of the nodes column by column, and
    `h_before`, s.
    """

    def __init__(
        self,
        length: float,
        thickness: float,
        segments: int,
        density: float,
        youngs_modulus: float,
        poisson_ratio: float,
        arc_radius: float = math.inf,
    ) -> None:
        lame = youngs_modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))
        shear = youngs_modulus / (2 * (1 + poisson_ratio))
        self.law = np.array([[lame + 2 * shear, lame, 0.0], [lame, lame + 2 * shear, 0.0], [0.0, 0.0, shear]])
        self.length, self.density = length, density
        along, across = np.linspace(0.0, length, segments + 1), thickness * np.linspace(-0.5, 0.5, ACROSS + 1)
        self.stations = np.r_[0, 2 * (AT_ROOT + np.arange(1, segments + 1))]
        """Columns of nodes at the stations."""
        along = np.r_[0.0, along[1] / 2.0 ** np.arange(AT_ROOT, 0, -1), along[1:]]
        straight = MeshQuad2.from_mesh(MeshQuad.init_tensor(along, across))
        x, y = straight.doflocs
        back = arc_radius - np.sqrt(arc_radius**2 - y**2) if math.isfinite(arc_radius) else 0.0
        arched = MeshQuad2(np.array([x - back * (1 - x / length), y]), straight.t)
        element = ElementVector(ElementQuad2())
        basis = Basis(arched, element, intorder=5)

        # Numbers of the degrees of freedom by column, height and axis: the matrices are narrow bands.
        x, y = np.round(Basis(straight, element, intorder=5).doflocs / length, 9)
        number = np.empty(basis.N, int)
        number[np.lexsort((np.arange(basis.N) % 2, y, x))] = np.arange(basis.N)
        self.dofs = number[basis.element_dofs].T  # [elements, 18]
        self.clamped = 2 * NODES
        shapes = [field for (field,) in basis.basis]
        self.gradients = np.array([np.asarray(shape.grad) for shape in shapes]).transpose(3, 0, 1, 2, 4).copy()
        """Of the shape functions, `[elements, 18, components, axes, points]`."""
        self.weights = basis.dx  # [elements, points]
        values = np.array([np.asarray(shape) for shape in shapes])
        self.forcing = np.zeros((basis.N, 2))  # ∫ w dA by axis
        np.add.at(self.forcing, self.dofs.T, np.einsum("jaep,ep->jea", values, self.weights))

        rows, columns = np.repeat(self.dofs, 18, axis=1), np.tile(self.dofs, 18)
        self.upper = rows <= columns
        self.width = int((columns - rows).max())
        self.band = self._place(rows[self.upper], columns[self.upper])
        self.mass = density * self._assemble(np.einsum("iaep,jaep,ep->eij", values, values, self.weights))
        # The dampers of a station couple the nodes of its section.
        nodes = 2 * (NODES * self.stations[:, None, None] + np.arange(NODES)[:, None]) + np.arange(2)
        rows, columns = np.broadcast_arrays(nodes[:, :, None], nodes[:, None])
        self.dampers = rows <= columns
        self.damper_band = self._place(rows[self.dampers], columns[self.dampers])
        self.u, self.v, self.u_before, self.v_before = (np.zeros((basis.N // self.clamped, NODES, 2)) for _ in range(4))
        self.h_before = 0.0

    def _place(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Where the entries of the upper half of a matrix are in its flat band."""
        return np.asarray((self.width + rows - columns) * self.forcing.shape[0] + columns)

    def _assemble(self, blocks: np.ndarray) -> np.ndarray:
        """Band `[width + 1, dofs]` of the sum of the elements' matrices."""
        size = self.forcing.shape[0]
        flat = np.bincount(self.band, blocks.reshape(len(blocks), -1)[self.upper], (self.width + 1) * size)
        return flat.reshape(self.width + 1, size)

    def elastic(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Elastic force on each degree of freedom, N/m, and the elements' stiffness; points of an element come last."""
        f = np.einsum("ej,ejabp->eabp", u.reshape(-1)[self.dofs], self.gradients, optimize=True)
        f[:, [0, 1], [0, 1]] += 1.0
        xx, yy = (0.5 * ((f[:, :, axis] ** 2).sum(axis=1) - 1.0) for axis in (0, 1))
        green = np.stack([xx, yy, f[:, 0, 0] * f[:, 0, 1] + f[:, 1, 0] * f[:, 1, 1]], axis=1)
        sxx, syy, sxy = np.moveaxis(np.einsum("st,etp->esp", self.law, green) * self.weights[:, None], 1, 0)
        # Change of the strain by each shape function: the symmetric part of Fᵀ grad w.
        gx, gy = self.gradients[:, :, :, 0], self.gradients[:, :, :, 1]  # [elements, 18, axes, points]
        fx, fy = f[:, None, :, 0], f[:, None, :, 1]
        strain = np.stack([(fx * gx).sum(2), (fy * gy).sum(2), (fx * gy).sum(2) + (fy * gx).sum(2)], axis=2)
        force = np.einsum("ejsp,esp->ej", strain, np.stack([sxx, syy, sxy], axis=1))
        stressed = np.stack([gx * sxx[:, None, None] + gy * sxy[:, None, None],
                             gx * sxy[:, None, None] + gy * syy[:, None, None]], axis=3)  # fmt: skip
        material = np.einsum("st,ejtp->ejsp", self.law, strain * self.weights[:, None, None])
        by_element = (len(f), 18, -1)
        blocks = strain.reshape(by_element) @ np.swapaxes(material.reshape(by_element), 1, 2)
        blocks += self.gradients.reshape(by_element) @ np.swapaxes(stressed.reshape(by_element), 1, 2)
        return np.bincount(self.dofs.ravel(), force.ravel(), self.forcing.shape[0]), blocks

    def times_mass(self, a: np.ndarray) -> np.ndarray:
        """Mass times the accelerations of the nodes, N/m."""
        a = a.reshape(-1)
        product: np.ndarray = self.mass[-1] * a
        for off in range(1, self.width + 1):
            entries = self.mass[-1 - off, off:]
            product[:-off] += entries * a[off:]
            product[off:] += entries * a[:-off]
        return product

    def step(self, h: float, force: np.ndarray, impedance: np.ndarray, gravity: np.ndarray) -> None:
        """Step by `h` s under the loads `force` `[stations, 2]`, N/m, on stations that keep their velocity, with the
        impedance `[stations]`, kg/(m s), and `gravity` `[2]`, m/s²; raises `ArithmeticError` where there is no shape.
        """
        c0, c1, c2 = backward_differences(h, self.h_before)
        known_v, known_a = c2 * self.u_before - c1 * self.u, c2 * self.v_before - c1 * self.v
        reference, weight = self.sections(self.v), self.density * self.forcing @ gravity
        damper = c0 * impedance[:, None, None, None] * np.outer(SIMPSON, SIMPSON)[..., None] * np.ones(2)
        damper_band = np.bincount(self.damper_band, damper[self.dampers], self.mass.size).reshape(self.mass.shape)
        u = self.u + h * self.v
        u[0] = 0.0
        for _ in range(MOST_ITERATIONS):
            v = c0 * u + known_v
            internal, blocks = self.elastic(u)
            loads = force - impedance[:, None] * (self.sections(v) - reference)
            missing = weight - internal - self.times_mass(c0 * v + known_a)
            missing.reshape(u.shape)[self.stations] += SIMPSON[:, None] * loads[:, None]
            stiffness = self._assemble(blocks) + c0**2 * self.mass + damper_band
            try:
                update = solveh_banded(stiffness[:, self.clamped :], missing[self.clamped :])
            except (LinAlgError, ValueError) as error:
                raise ArithmeticError(f"the bar has no stable shape near this one: {error}") from error
            u[1:] += update.reshape(-1, NODES, 2)
            if np.abs(update).max() < TOLERANCE * self.length:
                break
        else:
            raise ArithmeticError(f"Newton's method did not converge in {MOST_ITERATIONS} iterations")
        self.u_before[:], self.v_before[:], self.h_before = self.u, self.v, h
        self.u[:], self.v[:] = u, c0 * u + known_v

    def sections(self, field: np.ndarray) -> np.ndarray:
        """Mean of a field of the nodes over the section of each station, `[stations, 2]`."""
        return np.asarray(SIMPSON @ field[self.stations])


class SolidBar(ContractUnit):
    """Its stations are the points of the scene's beam, so that the fluid sees what it would of the rod."""

    description = "Saint Venant-Kirchhoff bar in plane strain by quadratic finite elements"
    STATE = ("u", "v", "u_before", "v_before", "h_before", "x", "y", "vx", "vy", "force_x", "force_y", "impedance")

    def __init__(self, **keywords: Any) -> None:
        super().__init__(**keywords)
        beam, rod, fluid = self.scene["beam"], self.scene["rod"], self.scene["fluid"]
        unknown = [f"rod.{key}" for key in ("damping", "root_motion") if rod.get(key)]
        unknown += ["beam.rest_angles"] if beam.get("rest_angles") else []
        if unknown or "plane_strain" not in rod["material"]:
            raise ValueError(f"the solid bar knows no {', '.join(unknown) or 'rod.material but plane_strain'}")
        material = rod["material"]["plane_strain"]
        density = material["density"] - fluid["density"]
        if density < 0.0:
            raise ValueError("the bar must be at least as heavy as the fluid that it displaces")
        on_cylinder = beam["root"].get("on_cylinder")
        radius = fluid["cylinders"][on_cylinder["cylinder"]]["radius"] if on_cylinder else math.inf
        self.bar = Bar(beam["length"], beam["thickness"], beam["segments"], density, material["youngs_modulus"],
                       material["poisson_ratio"], radius)  # fmt: skip
        root, tangent = root_of(self.scene)
        self.turned = np.array([tangent, [-tangent[1], tangent[0]]])  # Rows: along and across
        self.gravity = self.turned @ (rod.get("gravity") or [0.0, 0.0])
        self.rest = root + np.linspace(0.0, beam["length"], beam["segments"] + 1)[:, None] * tangent

        self.x, self.y = self.rest.T.copy()
        self.vx, self.vy, self.force_x, self.force_y, self.impedance = (np.zeros_like(self.x) for _ in range(5))
        for name, unit in (("force_x", "N/m"), ("force_y", "N/m"), ("impedance", "kg/(m.s)")):
            self.register_array(name, unit, Fmi2Causality.input, getattr(self, name))
        for name, unit in (("x", "m"), ("y", "m"), ("vx", "m/s"), ("vy", "m/s")):
            self.register_array(name, unit, Fmi2Causality.output, getattr(self, name))
        tip_x, tip_y = self.rest[-1]
        for name, unit, read in (
            ("tip.ux", "m", lambda: self.x[-1] - tip_x),
            ("tip.uy", "m", lambda: self.y[-1] - tip_y),
            ("tip.vx", "m/s", lambda: self.vx[-1]),
            ("tip.vy", "m/s", lambda: self.vy[-1]),
        ):
            self.register(name, unit, Fmi2Causality.output, read)

    def do_step(self, current_time: float, step_size: float) -> bool:
        force = np.column_stack([self.force_x, self.force_y]) @ self.turned.T
        self.bar.step(step_size, force, self.impedance, self.gravity)
        self.x[:], self.y[:] = (self.rest + self.bar.sections(self.bar.u) @ self.turned).T
        self.vx[:], self.vy[:] = (self.bar.sections(self.bar.v) @ self.turned).T
        return True


def _of_bar(name: str) -> property:
    """A part of the state that the bar has."""
    return property(lambda unit: getattr(unit.bar, name), lambda unit, value: setattr(unit.bar, name, value))


for _name in ("u", "v", "u_before", "v_before", "h_before"):
    setattr(SolidBar, _name, _of_bar(_name))
