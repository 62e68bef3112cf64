"""Estimates of errors from values of known convergence."""

import numpy as np
import pytest

from nervure.evaluate.statistics import Window
from nervure.verification.estimate import combine, estimate, statistical_error

SIZES = (1.0, 2**0.5, 2.0)


def share(values, sizes=SIZES, noise=0.0):
    return estimate(sizes, values, [noise] * len(sizes))


@pytest.mark.parametrize("order", [1.0, 1.5, 2.0])
def test_three_values_show_their_order_and_half_of_their_error_is_corrected(order):
    found = share([3.0 + 0.2 * h**order for h in SIZES])
    print(found.order, order, found.error(1.0), found.error(2.0), found.uncertainty)
    assert found.kind == "converging" and found.order == pytest.approx(order, abs=0.02)
    assert found.error(1.0) == pytest.approx(0.1, rel=0.02)
    assert found.error(2.0) == pytest.approx(0.1 + 0.2 * (2**order - 1), rel=0.02)
    agreed = max(0.2 * (h**order - 1) / (h**2 - 1) for h in SIZES[1:])
    assert found.uncertainty == pytest.approx(0.75 * 0.2 + 0.5 * agreed, rel=0.02)


@pytest.mark.parametrize("terms", [(0.05, 0.02), (0.0, 0.1), (0.03, 0.0)])
def test_five_values_that_follow_an_expansion_show_their_whole_error(terms):
    sizes = [2 ** (i / 2) for i in range(5)]
    found = share([1.0 + terms[0] * h + terms[1] * h**2 for h in sizes], sizes)
    print(found.terms, found.error(1.0), sum(terms))
    assert found.error(1.0) == pytest.approx(sum(terms), rel=0.02)
    assert found.uncertainty == pytest.approx(0.5 * sum(terms), rel=0.02)


def test_a_coarse_run_of_another_flow_does_not_spoil_what_finer_ones_show():
    finer = [1.0 + 0.01 * h**2 for h in SIZES]
    alone, beside = share(finer), share([*finer, 1.3], [*SIZES, 4.0])
    print(alone.uncertainty, beside.uncertainty)
    assert beside.error(1.0) == alone.error(1.0) and beside.uncertainty <= 2 * alone.uncertainty


def test_runs_that_agree_by_chance_are_not_trusted():
    chance, more = share([1.0, 1.0001, 1.0]), share([1.0, 1.0001, 1.0, 1.08], [*SIZES, 2 * 2**0.5])
    print(chance.uncertainty, more.uncertainty)
    assert more.uncertainty >= 0.5 * 0.08 / 7 > chance.uncertainty


def test_values_that_go_to_and_fro_are_not_converging():
    found = share([1.0, 1.1, 0.98])
    print(found.kind, found.order, found.uncertainty)
    assert found.kind in ("oscillating", "scattered") and found.order is None
    assert found.uncertainty >= 0.1


def test_differences_below_the_noise_are_noise():
    found = share([1.0, 1.01, 0.99], noise=0.05)
    print(found.kind, found.uncertainty)
    assert found.kind == "noise" and not found.terms and 0.05 <= found.uncertainty <= 0.1


@pytest.mark.parametrize("order", [1.01, 1.4, 2.0])
def test_the_bar_of_two_runs_holds_the_limit_of_orders_from_1_to_2(order):
    found = share([5.0 - 0.3, 5.0 - 0.3 * 2**order], (1.0, 2.0))
    limit = 5.0 - 0.3 - found.error(1.0)
    print(limit, found.uncertainty)
    assert abs(limit - 5.0) <= found.uncertainty


@pytest.mark.parametrize("order", [1.5, 2.0])
@pytest.mark.parametrize("count", [2, 4])
def test_a_parameter_that_was_varied_outwards_has_the_error_of_the_scene_in_its_bar(order, count):
    """As the box: the finest runs beside a coarse one do not correct the scene, whose size is 1."""
    sizes = [(2 / 3) ** k for k in range(count)]
    share = estimate(sizes, [1 + 0.3 * size**order for size in sizes], [0.0] * count)
    first = estimate([0.5, 1.0], [1.3, 1.3], [0.0, 0.0])
    value, limit, bar = combine({"cells": first, "box": share})
    assert abs(limit - 1) <= bar < 0.8 and value == 1.3
    assert share.bar(0.5 * sizes[-1]) < share.bar(sizes[-1]) == share.uncertainty < share.bar(2.0) / 2


def test_the_bar_holds_the_limit_of_scattered_values_in_nine_of_ten_draws():
    random, held, widths = np.random.default_rng(1), 0, []
    for _ in range(300):
        order, size = random.uniform(0.9, 2.1), random.uniform(-0.2, 0.2)
        values = [1.0 + size * h**order + 0.03 * abs(size) * random.standard_normal() for h in SIZES]
        value, limit, bar = combine({"cells": share(values)})
        held += abs(limit - 1.0) <= bar
        widths.append(bar / abs(value - 1.0))
    print(held / 300, np.median(widths))
    assert held >= 270 and np.median(widths) <= 3.0


def test_parameters_add_up_and_steps_in_proportion_count_once():
    shares = {name: share([1.0 + a, 1.0 + 2 * a], (1.0, 2.0)) for name, a in {"cells": 0.1, "c_eta": 0.03}.items()}
    _, limit, bar = combine(shares)
    _, again, same = combine({**shares, "step": share([1.0, 1.5], (1.0, 2.0))})
    own = [shares[name].uncertainty for name in shares]
    print(limit, again, bar, np.hypot(*own))
    assert (limit, bar) == (again, same) and bar == pytest.approx(np.hypot(*own))
    assert limit == pytest.approx(1.1 - shares["cells"].error(1.0))


def test_the_error_of_a_mean_is_that_of_its_periods():
    random, held, periods = np.random.default_rng(2), 0, 12
    time = np.linspace(0, periods, periods * 100 + 1)
    for _ in range(100):
        sizes, shifts = 1 + 0.1 * random.standard_normal(periods + 1), 0.05 * random.standard_normal(periods + 1)
        values = sizes[time.astype(int)] * np.sin(2 * np.pi * time) + shifts[time.astype(int)]
        found = statistical_error(time, values, Window(0.0, float(periods), periods), "mean")
        middles = [(v.max() + v.min()) / 2 for v in np.split(values[:-1], periods)]
        held += abs(np.mean(middles)) <= found
    print(held)
    assert held >= 85


def test_a_steady_signal_that_still_drifts_has_the_drift_as_its_error():
    time = np.linspace(0, 10, 101)
    drifting = statistical_error(time, 1 + 0.1 * np.exp(-time / 5), Window(5.0, 10.0, 0), "mean")
    resting = statistical_error(time, np.ones_like(time), Window(5.0, 10.0, 0), "mean")
    print(drifting, resting)
    assert 0.01 < drifting < 0.03 and resting == 0.0


@pytest.mark.parametrize("what", ["mean", "amplitude"])
def test_one_period_scatters_by_what_half_a_period_changes(what):
    time = np.linspace(0, 20, 401)
    fading = 0.1 * np.exp(-time / 10)
    for drift in (0.0, 1.0):
        more = drift * fading
        values = np.sin(np.pi * time / 5) + more if what == "mean" else np.sin(np.pi * time / 5) * (1 + more)
        found = statistical_error(time, values, Window(10.0, 20.0, 1), what)
        print(found)
        assert 0.01 < found < 0.02 if drift else found == pytest.approx(0.0, abs=1e-12)
