"""Accelerators of an iterated scheme, which make the next guess: Aitken's relaxation and IQN-ILS."""

import numpy as np

FIRST_RELAXATION = 0.1
"""Relaxation before any residual is known: small enough for an added mass of ten rods."""

AITKEN_START = (FIRST_RELAXATION, 0.5)
"""Range of Aitken's relaxation at the start of a step; within it, the last value of the step before is kept."""

MAX_COLUMNS, WINDOWS_REUSED = 60, 15  # Largest number of differences that IQN-ILS keeps, and of steps it keeps them
FILTER = 1.2e-3  # Least part of a difference that must be independent of the younger ones (QR2 of preCICE)


class Aitken:
    """Relaxation by the secant of the last two residuals (Küttler & Wall 2008, Comput. Mech. 43, 61)."""

    columns = deleted = dropped = 0

    def __init__(self) -> None:
        self.relaxation = FIRST_RELAXATION
        self.last_residual: np.ndarray | None = None

    def begin(self) -> None:
        """Begin a step."""
        self.relaxation = float(np.clip(self.relaxation, *AITKEN_START))
        self.last_residual = None

    def learn(self, residual: np.ndarray, _answer: np.ndarray) -> None:
        """Learn from the residual of the displacements, `[2n]`, and the answer that gave it, `[4n]`."""
        if self.last_residual is not None:
            change = residual - self.last_residual
            self.relaxation *= -float(self.last_residual @ change) / float(change @ change)
        self.last_residual = residual

    def guess(self, given: np.ndarray, answer: np.ndarray) -> np.ndarray:
        """Return the next guess of the stations."""
        relaxed: np.ndarray = given + self.relaxation * (answer - given)
        return relaxed

    def memory(self) -> dict[str, np.ndarray]:
        return {"relaxation": np.array([self.relaxation])}

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        self.relaxation = float(memory["relaxation"][0])


class IqnIls:
    """Interface quasi-Newton by least squares (Degroote, Bathe & Vierendeels 2009, Comput. Struct. 87, 793).

    With the differences of successive iterations, V = [r_i - r_{i-1}] and W = [x~_i - x~_{i-1}], of this step and
    earlier ones, the next guess is x~ + c W, where c minimizes |r + c V|. V holds displacements only: a velocity is no
    length, and the displacements alone have to agree. A QR decomposition, youngest differences first, finds c and the
    differences that are nearly dependent, which are deleted (Haelterman et al. 2016, Comput. Struct. 171, 9).
    """

    def __init__(self, displacements: int, stations: int):
        self.v, self.w = np.empty((0, displacements)), np.empty((0, stations))
        self.max_columns = min(MAX_COLUMNS, displacements)
        self.step_of = np.empty(0, int)
        """Number of the step of each difference."""
        self.step = 0
        self.deleted = self.dropped = 0
        self.last: tuple[np.ndarray, np.ndarray] | None = None
        """Residual and answer of the last iteration of the step."""

    @property
    def columns(self) -> int:
        return len(self.v)

    def begin(self) -> None:
        self.step += 1
        self.last = None
        self.deleted = 0
        self.dropped = self._keep(self.step_of >= self.step - WINDOWS_REUSED)

    def learn(self, residual: np.ndarray, answer: np.ndarray) -> None:
        if self.last is not None:
            last_residual, last_answer = self.last
            self.v = np.vstack([residual - last_residual, self.v])
            self.w = np.vstack([answer - last_answer, self.w])
            self.step_of = np.r_[self.step, self.step_of]
            self.dropped += self._keep(np.arange(self.columns) < self.max_columns)
        self.last = residual, answer.copy()

    def guess(self, given: np.ndarray, answer: np.ndarray) -> np.ndarray:
        assert self.last, "a residual comes before a guess"
        residual, _ = self.last
        while self.columns:
            q, r = np.linalg.qr(self.v.T)
            new = np.abs(np.diagonal(r)) > FILTER * np.linalg.norm(self.v, axis=1)
            if new.all():
                found: np.ndarray = answer + np.linalg.solve(r, -(q.T @ residual)) @ self.w
                return found
            self.deleted += self._keep(new)
        relaxed: np.ndarray = given + FIRST_RELAXATION * (answer - given)
        return relaxed

    def _keep(self, kept: np.ndarray) -> int:
        """Delete the other differences and return their number."""
        if kept.all():
            return 0
        self.v, self.w, self.step_of = self.v[kept], self.w[kept], self.step_of[kept]
        return int(np.count_nonzero(~kept))

    def memory(self) -> dict[str, np.ndarray]:
        return {"v": self.v, "w": self.w, "step_of": self.step_of, "step": np.array([self.step])}

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        self.v, self.w, self.step_of = memory["v"], memory["w"], memory["step_of"]
        if not len(self.v) == len(self.w) == len(self.step_of):
            raise ValueError(f"there are {len(self.v)}, {len(self.w)} and {len(self.step_of)} differences")
        self.step = int(memory["step"][0])
