"""A filament of no thickness in a stream by Peskin's immersed boundary, for comparison only.

python immersed_filament.py flag 64 0.0015 15          case, points a length, step, end
python immersed_filament.py filament 48 0.003 24

The box, its mean flow and its sponge are those of the scenes flag-stream and filament-hanging; wall and rod are not.
The fluid is pseudo-spectral: second-order Adams–Bashforth, viscosity by its integrating factor. The filament is a chain
of mass points with stiff axial springs and the second difference as curvature, by small steps of Verlet's method. A
spring of stiffness K and a damper hold each point to a marker that goes with the fluid (Kim & Peskin 2007), and their
force is spread by the four-point cosine. Prints time and the free end along x and y, as CSV; lengths and speeds by
those of the filament and the stream, density 1.
"""

import sys
from dataclasses import dataclass

import numpy as np

HOLD, DAMP = 2000.0, 5.0  # Spring and damper between a point and its marker, per length
SPONGE = 20.0  # Largest rate of the sponge
SUBSTEPS = 6  # Of the chain in a step of the fluid


@dataclass(frozen=True)
class Case:
    """A filament of length 1 in a stream of 1."""

    box: tuple[float, float, float, float]  # x from, to; y from, to
    sponge: float  # Where it begins; it ends with the box
    viscosity: float
    mass: float
    bending: float
    axial: float
    gravity: float
    clamped: bool
    angle: float  # At the start
    gust: float  # Velocity across the stream between 0.25 and 0.5


CASES = {
    "flag": Case((-1.0, 4.0, -1.25, 1.25), 3.2, 1e-3, 0.075, 1e-4, 20.0, 0.0, True, 0.0, 0.05),
    "filament": Case((-2.0, 6.0, -4.0, 4.0), 4.8, 5e-3, 1.5, 0.00225, 200.0, 0.5, False, 0.1 * np.pi, 0.0),
}


class Fluid:
    def __init__(self, case: Case, points: int, step: float):
        x0, x1, y0, y1 = case.box
        self.dx, self.origin, self.step = 1 / points, np.array([x0, y0]), step
        nx, ny = round((x1 - x0) * points), round((y1 - y0) * points)
        self.shape = (ny, nx)
        kx, ky = np.fft.rfftfreq(nx, self.dx / (2 * np.pi)), np.fft.fftfreq(ny, self.dx / (2 * np.pi))
        self.k = np.array(np.meshgrid(kx, ky))
        self.k2 = (self.k**2).sum(0)
        self.safe = np.where(self.k2 == 0, 1, self.k2)
        self.decay = np.exp(-case.viscosity * self.k2 * step)
        self.filter = np.exp(-36 * (np.sqrt(self.k2) * self.dx / np.pi) ** 36)
        s = np.clip((x0 + self.dx * np.arange(nx) - case.sponge) / (x1 - case.sponge), 0, 1)
        self.sponge = SPONGE * np.sin(np.pi * s) ** 2
        self.u = np.zeros((2, ny, nx // 2 + 1), complex)
        self.u[0, 0, 0] = nx * ny
        self.before: np.ndarray | None = None

    def real(self) -> np.ndarray:
        return np.fft.irfft2(self.u, s=self.shape)

    def advance(self, u: np.ndarray, force: np.ndarray, across: float) -> None:
        """A step under `force` per area, `[2, ny, nx]`, `u` being the velocity; `across` is the mean flow along y."""
        vorticity = np.fft.irfft2(1j * (self.k[0] * self.u[1] - self.k[1] * self.u[0]), s=self.shape)
        rate = np.array([u[1] * vorticity - self.sponge * (u[0] - 1), -u[0] * vorticity - self.sponge * u[1]]) + force
        now = np.fft.rfft2(rate) * self.filter
        now -= self.k * ((self.k * now).sum(0) / self.safe)
        before = now if self.before is None else self.before
        self.u = self.decay * (self.u + self.step * (1.5 * now - 0.5 * self.decay * before))
        self.before = now
        self.u[:, 0, 0] = np.array([1.0, across]) * self.shape[0] * self.shape[1]

    def weights(self, markers: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows, columns and weights of the four-point cosine around `markers`, `[n, 2]`."""
        place = (markers - self.origin) / self.dx
        first = np.floor(place).astype(int) - 1
        near = first[:, :, None] + np.arange(4)
        w = (1 + np.cos(np.pi / 2 * (place[:, :, None] - near))) / 4
        return near[:, 1, :, None], near[:, 0, None, :], w[:, 1, :, None] * w[:, 0, None, :]


class Chain:
    def __init__(self, case: Case, segments: int):
        self.case, self.ds = case, 1 / segments
        self.along = np.array([np.cos(case.angle), np.sin(case.angle)])
        self.x = np.linspace(0, 1, segments + 1)[:, None] * self.along
        self.v = np.zeros_like(self.x)
        self.share = np.full((segments + 1, 1), self.ds)
        self.share[[0, -1]] /= 2

    def force(self) -> np.ndarray:
        case, ds, x = self.case, self.ds, self.x
        f = np.zeros_like(x)
        f[:, 0] = case.mass * case.gravity * self.share[:, 0]
        e = np.diff(x, axis=0)
        length = np.linalg.norm(e, axis=1, keepdims=True)
        pull = case.axial * (length / ds - 1) * e / length
        f[:-1] += pull
        f[1:] -= pull
        moment = case.bending * (x[2:] - 2 * x[1:-1] + x[:-2]) / ds**3
        f[2:] -= moment
        f[1:-1] += 2 * moment
        f[:-2] -= moment
        if case.clamped:
            f[1] -= 2 * case.bending * (x[1] - x[0] - ds * self.along) / ds**3
        return f

    def advance(self, step: float, markers: np.ndarray, speeds: np.ndarray) -> np.ndarray:
        """A step beside `markers` that go with `speeds`; the mean force on the markers."""
        h, total = step / SUBSTEPS, np.zeros_like(self.x)
        for i in range(SUBSTEPS):
            hold = HOLD * (self.x - markers - (i + 0.5) * h * speeds) + DAMP * (self.v - speeds)
            hold *= self.share
            total += hold / SUBSTEPS
            self.v += h * (self.force() - hold) / (self.case.mass * self.share)
            self.v[0] = 0
            self.x += h * self.v
        return total


def main() -> None:
    case, points, step, end = CASES[sys.argv[1]], int(sys.argv[2]), float(sys.argv[3]), float(sys.argv[4])
    fluid, chain = Fluid(case, points, step), Chain(case, round(1.5 * points))
    markers = chain.x.copy()
    print("time,x,y")
    for i in range(round(end / step)):
        t = i * step
        u = fluid.real()
        rows, columns, weights = fluid.weights(markers)
        speeds = (u[:, rows, columns] * weights).sum((2, 3)).T
        pushed = chain.advance(step, markers, speeds)
        force = np.zeros((2, *fluid.shape))
        for axis in range(2):
            np.add.at(force[axis], (rows, columns), pushed[:, axis, None, None] * weights / fluid.dx**2)
        across = case.gust * np.interp(t + step, [0, 0.25, 0.5, 0.75], [0, 1, 1, 0])
        fluid.advance(u, force, across)
        markers += step * speeds
        print(f"{t + step:.6f},{chain.x[-1, 0]:.8f},{chain.x[-1, 1]:.8f}", flush=i % 200 == 0)


if __name__ == "__main__":
    main()
