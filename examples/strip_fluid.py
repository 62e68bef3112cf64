"""An analytic fluid in place of the fluid: added mass and linear drag, station by station.

The strips are independent and alike. A rigid plate of chord L that moves across in an inviscid fluid, in the plane,
carries rho pi L²/4 of it (Lamb, Hydrodynamics, § 71); spread evenly that is

    m_a = rho pi L/4    per length of the beam,

so that every mode of a beam of mass mu in vacuo has the frequency sqrt(mu/(mu + m_a)) of that in vacuo, and with the
linear drag c per length decays at the rate c/(2 (mu + m_a)). A flexing plate carries less in its higher modes, and
nothing along itself: both are left out.

Under the momentum load the fluid also carries the mass of the fluid that the beam displaces, rho h. The load on
station k at the end of a step is

    f_k = -l_k [(rho h + m_a) v_k' + c v_k],   v' = c0 v(t + H) - c1 v(t) + c2 v(t - H),

and what is announced is that for v(t + H) = v(t) and its slope in v(t + H), the impedance l_k [(rho h + m_a) c0 + c]:
the rod solves for the added mass implicitly, however light it is. The coming step is taken to be as long as the last.
"""

import math
from typing import Any

import numpy as np
from contract import ContractUnit, backward_differences, station_lengths
from pythonfmu.enums import Fmi2Causality


class StripFluid(ContractUnit):
    """Takes density, chord, thickness and first step from the scene; walls, cylinders and inflow mean nothing to it."""

    description = "Added mass and linear drag per station"
    STATE = ("x", "y", "vx", "vy", "now", "before", "h_before", "load", "impedance", "total", "linear_drag")

    def __init__(self, **keywords: Any) -> None:
        super().__init__(**keywords)
        beam, density = self.scene["beam"], self.scene["fluid"]["density"]
        self.lengths = station_lengths(beam)
        self.added = density * math.pi * beam["length"] / 4
        self.displaced = density * beam["thickness"]
        self.linear_drag = 0.0

        n = self.lengths.size
        self.x, self.y = np.zeros(n), np.zeros(n)
        self.velocity, self.now, self.before, self.load = (np.zeros((2, n)) for _ in range(4))
        self.vx, self.vy = self.velocity
        self.impedance = np.zeros(n)
        self.total = np.zeros(2)
        self.h_before = 0.0

        def set_drag(value: float) -> None:
            self.linear_drag = value
            self._announce(self.scene["time"]["communication_step"])

        self.register("linear_drag", "kg/(m2.s)", Fmi2Causality.parameter, lambda: self.linear_drag, set_drag)
        for name, unit in (("x", "m"), ("y", "m"), ("vx", "m/s"), ("vy", "m/s")):
            self.register_array(name, unit, Fmi2Causality.input, getattr(self, name))
        for name, unit, values in (
            ("force_x", "N/m", self.load[0]),
            ("force_y", "N/m", self.load[1]),
            ("impedance", "kg/(m.s)", self.impedance),
        ):
            self.register_array(name, unit, Fmi2Causality.output, values)
        self.register("drag", "N/m", Fmi2Causality.output, lambda: self.total[0])
        self.register("lift", "N/m", Fmi2Causality.output, lambda: self.total[1])
        self._announce(self.scene["time"]["communication_step"])

    def do_step(self, current_time: float, step_size: float) -> bool:
        c0, c1, c2 = backward_differences(step_size, self.h_before)
        acceleration = c0 * self.velocity - c1 * self.now + c2 * self.before
        self.total[:] = -(self.added * acceleration + self.linear_drag * self.velocity) @ self.lengths
        self.before[:], self.now[:] = self.now, self.velocity
        self.h_before = step_size
        self._announce(step_size)
        return True

    def _announce(self, h: float) -> None:
        """Loads and impedance for a step of length `h` (s) that begins now."""
        c0, c1, c2 = backward_differences(h, self.h_before)
        mass = self.displaced + self.added
        acceleration = (c0 - c1) * self.now + c2 * self.before
        self.load[:] = -self.lengths * (mass * acceleration + self.linear_drag * self.now)
        self.impedance[:] = self.lengths * (mass * c0 + self.linear_drag)
