"""Schemes that iterate, on problems whose convergence is known, and the balance of the interface in FSI3."""

import json

import numpy as np
import pytest
from cosim import coupling
from test_runs import results, run


def fixed_point(matrix, offset):
    """x~(x) = A x + b and its fixed point."""
    solution = np.linalg.solve(np.eye(len(offset)) - matrix, offset)
    return lambda x: matrix @ x + offset, solution


def iterate(acceleration, answer, x, tolerance, limit=200):
    """Number of evaluations until |x~ - x| ≤ tolerance, and the last answer."""
    acceleration.begin()
    for evaluation in range(1, limit + 1):
        found = answer(x)
        acceleration.learn(found - x, found)
        if np.linalg.norm(found - x) <= tolerance:
            return evaluation, found
        x = acceleration.guess(x, found)
    raise AssertionError(f"|x~ - x| = {np.linalg.norm(found - x):g} after {limit} evaluations")


def added_mass(eigenvalues, seed=1):
    """An interface map with the given eigenvalues, in a basis that is not orthogonal."""
    n = len(eigenvalues)
    random = np.random.default_rng(seed)
    basis = np.eye(n) + 0.3 * random.standard_normal((n, n)) / np.sqrt(n)
    return basis @ np.diag(eigenvalues) @ np.linalg.inv(basis), random.standard_normal(n)


@pytest.mark.parametrize("different", [1, 2, 4])
def test_iqn_ils_needs_two_evaluations_more_than_there_are_eigenvalues(different):
    """In exact arithmetic it is GMRES on a linear problem (Haelterman et al. 2009): with k different eigenvalues the
    residual is nothing after k differences, k + 1 evaluations, and one more finds that out."""
    values = np.repeat([-100.0, -10.0, -1.0, 0.5][:different], 8)
    matrix, offset = added_mass(values)
    answer, solution = fixed_point(matrix, offset)
    evaluations, found = iterate(coupling.IqnIls(offset.size, offset.size), answer, 0 * offset, 1e-8)
    assert evaluations == different + 2
    assert found == pytest.approx(solution, abs=1e-7)


def test_reused_windows_save_the_evaluations():
    matrix, offset = added_mass(np.repeat([-100.0, -10.0, -1.0, 0.5], 8))
    acceleration = coupling.IqnIls(offset.size, offset.size)
    needed = []
    for step in range(4):
        answer, solution = fixed_point(matrix, (1 + step) * offset)
        evaluations, found = iterate(acceleration, answer, 0 * offset, 1e-7)
        needed.append(evaluations)
        assert found == pytest.approx(solution, abs=1e-6)
    assert needed == [6, 4, 2, 2], "the second step finds again what the filter took for noise in the first"


def test_filter_deletes_differences_that_say_nothing_new():
    acceleration = coupling.IqnIls(3, 3)
    acceleration.begin()
    for residual in ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1e-5, 0.0], [0.5, 0.0, 0.2]):
        acceleration.learn(np.array(residual), np.array(residual))
    acceleration.guess(np.zeros(3), np.zeros(3))
    assert (acceleration.columns, acceleration.deleted) == (2, 1)


def test_differences_are_kept_for_their_number_of_windows_and_no_longer():
    matrix, offset = added_mass(np.linspace(-3.0, 0.5, 32))
    answer, _ = fixed_point(matrix, offset)
    acceleration = coupling.IqnIls(offset.size, offset.size)
    for step in range(coupling.WINDOWS_REUSED + 5):
        iterate(acceleration, answer, np.full(32, float(step)), 1e-6)
        assert acceleration.columns <= 32
        assert acceleration.step_of.min(initial=acceleration.step) >= acceleration.step - coupling.WINDOWS_REUSED


def test_aitken_is_exact_for_one_eigenvalue():
    matrix, offset = added_mass(np.full(8, -10.0))
    answer, solution = fixed_point(matrix, offset)
    evaluations, found = iterate(coupling.Aitken(), answer, 0 * offset, 1e-8)
    assert evaluations == 3
    assert found == pytest.approx(solution, abs=1e-7)


def test_aitken_fails_where_iqn_ils_converges():
    matrix, offset = added_mass(np.linspace(-300.0, 0.5, 32))
    answer, _ = fixed_point(matrix, offset)
    assert iterate(coupling.IqnIls(32, 32), answer, 0 * offset, 1e-6)[0] < 40
    with pytest.raises(AssertionError, match="after 60 evaluations"):
        iterate(coupling.Aitken(), answer, 0 * offset, 1e-6, limit=60)
