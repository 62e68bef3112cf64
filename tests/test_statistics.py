"""Statistics of signals whose mean, amplitude and frequency are known exactly."""

import numpy as np
import pytest

from nervure.evaluate import statistics

TIME = np.arange(0, 8, 2e-4)
FREQUENCY, MEAN, AMPLITUDE = 5.46, 1.47, 34.99
SINE = MEAN + AMPLITUDE * np.sin(2 * np.pi * FREQUENCY * TIME + 0.3)


def evaluated(values, main=None):
    window = statistics.find_window(TIME, values if main is None else main)
    return window, statistics.evaluate(TIME, values, window)


def assert_close(found, mean, amplitude, frequency, relative):
    assert found.mean == pytest.approx(mean, abs=relative * amplitude)
    assert found.amplitude == pytest.approx(amplitude, rel=relative)
    assert found.frequency_hz == pytest.approx(frequency, rel=relative)


def test_a_sine_gives_its_own_numbers():
    window, found = evaluated(SINE)
    assert_close(found, MEAN, AMPLITUDE, FREQUENCY, 1e-5)
    assert_close(statistics.fit(TIME, SINE, window), MEAN, AMPLITUDE, FREQUENCY, 2e-6)


def test_the_window_holds_whole_periods():
    window, _ = evaluated(SINE)
    assert window.periods == 42, "43 upward crossings in 43.7 periods that begin above the mean"
    assert (window.end - window.begin) * FREQUENCY == pytest.approx(window.periods, abs=1e-5)


def test_start_up_stays_out_of_the_window():
    window, found = evaluated(SINE * np.clip((TIME - 1) / 3, 0, 1))
    assert window.begin > 3.7, window
    assert window.periods > 20, window
    assert found.amplitude == pytest.approx(AMPLITUDE, rel=1e-5)


def test_a_growing_oscillation_is_seen_as_one():
    values = SINE * np.exp(0.3 * TIME)
    window, _ = evaluated(values)
    assert 5 <= window.periods < 10, window
    assert statistics.drift(TIME, values, window) > 0.05


def test_a_steady_oscillation_does_not_drift():
    window, _ = evaluated(SINE)
    assert statistics.drift(TIME, SINE, window) == pytest.approx(0, abs=1e-5)


def test_double_frequency_is_found_in_the_window_of_the_main_signal():
    drag = 460.5 + 27.74 * np.cos(4 * np.pi * FREQUENCY * TIME)
    window, found = evaluated(drag, main=SINE)
    assert_close(found, 460.5, 27.74, 2 * FREQUENCY, 1e-4)
    assert_close(statistics.fit(TIME, drag, window), 460.5, 27.74, 2 * FREQUENCY, 1e-5)


def test_noise_widens_the_extremes_but_not_the_fit_or_the_frequency():
    noise = np.random.default_rng(1).normal(0, 1.0, TIME.size)
    window, found = evaluated(SINE + noise)
    assert found.amplitude > 1.03 * AMPLITUDE
    assert found.frequency_hz == pytest.approx(FREQUENCY, rel=1e-3)
    assert_close(statistics.fit(TIME, SINE + noise, window), MEAN, AMPLITUDE, FREQUENCY, 2e-3)


def test_ripple_does_not_count_as_periods():
    _, found = evaluated(SINE + 0.4 * AMPLITUDE * np.sin(2 * np.pi * 14 * FREQUENCY * TIME), main=SINE)
    assert found.frequency_hz == pytest.approx(FREQUENCY, rel=1e-3)


def test_fewer_than_five_periods_are_what_there_is():
    few = TIME < 0.6
    window = statistics.find_window(TIME[few], SINE[few])
    assert window.periods == 2, "3 upward crossings in 3.3 periods"
    found = statistics.evaluate(TIME[few], SINE[few], window)
    assert found.frequency_hz == pytest.approx(FREQUENCY, rel=1e-4)


@pytest.mark.parametrize("values", [np.full_like(TIME, 3.0), 3.0 - np.exp(-4 * TIME)], ids=["constant", "settling"])
def test_a_steady_signal_is_evaluated_over_its_last_third_and_has_no_frequency(values):
    window, found = evaluated(values)
    assert window.periods == 0
    assert window.begin == pytest.approx(TIME[-1] * 2 / 3)
    assert found.mean == pytest.approx(3.0, abs=1e-6)
    assert found.frequency_hz is None


def test_the_box_filter_keeps_straight_lines_and_weakens_a_sine_by_its_sinc():
    width = 5e-3
    line = 2 + 3 * TIME
    assert statistics.box_filter(TIME, line, width) == pytest.approx(line, abs=1e-9)
    window = statistics.find_window(TIME, SINE)
    filtered = statistics.evaluate(TIME, statistics.box_filter(TIME, SINE, width), window)
    assert filtered.amplitude == pytest.approx(AMPLITUDE * np.sinc(FREQUENCY * width), rel=1e-5)


def test_the_force_filter_is_narrow_against_a_period():
    assert statistics.force_filter_width(statistics.Window(0, 10, 5)) == 5e-3
    assert statistics.force_filter_width(statistics.Window(0, 0.5, 5)) == pytest.approx(2e-3)
