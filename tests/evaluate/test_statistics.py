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


@pytest.mark.parametrize("late", [2.0, 5.0, 7.2])
def test_an_impulsive_start_and_the_silence_after_it_stay_out(late):
    """However late the oscillation sets in: a spike, no signal, and then a sine that grows to its size."""
    impulse = 20 * AMPLITUDE * np.exp(-TIME / 0.01)
    values = impulse + MEAN + (SINE - MEAN) / (1 + np.exp(-(TIME - late) / 0.05))
    window, found = evaluated(values)
    assert window.begin > late, window
    assert window.periods >= 3, window
    assert found.frequency_hz == pytest.approx(FREQUENCY, rel=2e-3)
    assert found.amplitude == pytest.approx(AMPLITUDE, rel=2e-2)


def test_a_growing_oscillation_drifts():
    values = SINE * np.exp(0.3 * TIME)
    window, _ = evaluated(values)
    assert 3 <= window.periods <= 5, window
    found = statistics.character(TIME, values, window)
    assert found.state == "drifting"
    assert found.drift == pytest.approx(0.3 * (window.periods - 1) / FREQUENCY, rel=0.15)
    assert found.remark() == f"drifts {found.drift:+.0%}"


def test_a_signal_on_a_slope_drifts():
    values = SINE + 2 * AMPLITUDE * TIME / TIME[-1]
    window = statistics.find_window(TIME, SINE)
    assert statistics.character(TIME, values, window).state == "drifting"


@pytest.mark.parametrize("seed", range(3))
def test_a_signal_without_periods_is_irregular(seed):
    """A sum of sines in no simple ratio, whose crossings are of unequal length."""
    rates = np.random.default_rng(seed).uniform(0.5, 1.5, 6)
    values = sum(np.sin(2 * np.pi * FREQUENCY * rate * TIME + k) for k, rate in enumerate(rates))
    window = statistics.find_window(TIME, values)
    found = statistics.character(TIME, values, window)
    assert found.state in ("irregular", "drifting", "changing"), (window, found)
    assert found.remark()


def test_a_sine_is_periodic_and_has_no_remark():
    window, _ = evaluated(SINE)
    found = statistics.character(TIME, SINE, window)
    assert (found.state, found.remark()) == ("periodic", "")
    assert found.drift is not None and abs(found.drift) < 1e-5
    assert found.noise < 1e-3


@pytest.mark.parametrize("share", [0.02, 0.2])
def test_noise_is_what_lies_above_the_own_harmonics(share):
    """Of white noise, the part between six times the frequency and half the sampling rate."""
    noise = share * AMPLITUDE / np.sqrt(2) * np.random.default_rng(2).normal(size=TIME.size)
    values = SINE + 0.3 * AMPLITUDE * np.sin(2 * np.pi * 4 * FREQUENCY * TIME) + noise
    window = statistics.find_window(TIME, SINE)
    found = statistics.character(TIME, values, window)
    assert found.noise == pytest.approx(share / np.sqrt(1 + 0.3**2), rel=0.05)
    assert found.state == "periodic"
    assert ("noise" in found.remark()) == (share > statistics.NOISY)


def test_rounding_has_no_periods_and_is_called_so():
    """A lift of 5e-15 N beside a drag of 1 N."""
    values = 5e-15 * np.sin(2 * np.pi * FREQUENCY * TIME)
    smallest = statistics.ROUNDING["double"] * 1.0
    window = statistics.find_window(TIME, values, smallest)
    assert window.periods == 0
    assert statistics.character(TIME, values, window, smallest).remark() == "rounding only"


@pytest.mark.parametrize("phase", [0.0, 0.7, np.pi])
def test_a_record_that_ends_with_a_period_does_not_lose_it(phase):
    """The first period of a record has no crossing before it."""
    time = np.linspace(0, 4, 4001)
    window = statistics.find_window(time, np.sin(2 * np.pi * time + phase))
    assert window.periods == 3, window
    assert window.end == pytest.approx(4 - phase / 2 / np.pi, abs=1e-5)


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
    assert statistics.force_filter_width(statistics.Window(4e-3, 6e-3, 0)) == pytest.approx(4e-5)


def test_an_oscillation_that_ended_long_ago_is_no_part_of_the_window():
    """Two periods of 1 s, and then a drift: the end counts, and it has no frequency."""
    time = np.linspace(0.0, 10.0, 4001)
    values = np.where(time < 2.0, 2 * np.sin(2 * np.pi * time), 0.0) - 0.1 * time
    window = statistics.find_window(time, values)
    assert (window.begin, window.end, window.periods) == pytest.approx((20 / 3, 10.0, 0))
    assert statistics.character(time, values, window).state == "changing"


def test_a_start_before_a_drift_is_no_period():
    """A spike at the first instant, and then a drift about 0.70 that crosses its mean once more."""
    spike = np.where(TIME > 0, 10 * np.exp(-TIME / 0.05), 0.0)
    window, found = evaluated(0.70 + 0.05 * np.sin(2 * np.pi * TIME / 7.0) + spike)
    assert window.begin > TIME[-1] / 3, window
    assert abs(found.mean - 0.70) < 0.06 and found.amplitude < 0.06, found


def test_a_drive_leaves_its_first_period_out():
    """Of eight periods, from the first upward crossing to the end."""
    period = (TIME[-1] - 0.1) / 8
    drive = np.sin(2 * np.pi * (TIME - 0.1) / period)
    window = statistics.driven_window(TIME, drive, drive)
    assert (window.periods, window.driven) == (7, True), window
    assert (window.begin, window.end) == pytest.approx((0.1 + period, TIME[-1])), window


def test_of_two_periods_of_a_drive_the_last_is_the_window():
    """Also where the drive rises through its mean early in the first third, as the stroke of `wing-hover` does."""
    for start in (0.05, 0.25, 0.6):
        drive = np.sin(4 * np.pi * (TIME / TIME[-1] - start / 2)) * np.minimum(4 * TIME / TIME[-1], 1)
        window = statistics.driven_window(TIME, drive + 0.01, drive)
        assert (window.periods, window.driven) == (1, True), (start, window)
        assert (window.begin, window.end) == pytest.approx((TIME[-1] / 2, TIME[-1]), rel=1e-3), (start, window)


@pytest.mark.parametrize("driven", [True, False])
def test_the_force_on_a_driven_body_is_that_of_the_harmonics_of_the_drive(driven):
    """0.055 at 1 Hz, under noise of 0.03 at 37.3 Hz."""
    force = 0.4 + 0.055 * np.sin(2 * np.pi * TIME) + 0.03 * np.sin(2 * np.pi * 37.3 * TIME)
    window = statistics.Window(1.0, 7.0, 6, driven)
    found = statistics.of_force(TIME, force, window, 0.0)
    if driven:
        assert_close(found, 0.4, 0.055, 1.0, 0.02)
    else:
        assert found.amplitude > 0.08, found


def test_a_force_that_the_drive_does_not_set_keeps_its_own_frequency():
    force = 0.01 * np.sin(2 * np.pi * TIME) + np.sin(2 * np.pi * 1.7 * TIME)
    found = statistics.of_force(TIME, force, statistics.Window(1.0, 7.0, 6, True), 0.0)
    assert found.amplitude > 0.98 and found.frequency_hz == pytest.approx(1.7, rel=0.02), found
