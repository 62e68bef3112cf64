"""Saved states and repeated runs: everything is bit-identical."""

import ctypes
import zlib

import numpy as np
import pytest

from nervure.errors import UnitError
from nervure.resources import ROOT
from nervure.scene import read, validate
from nervure.simulation.session import Session
from tests.conftest import output

STEPS = 20


def advance(scheme, begin, count, h=2e-4):
    """Step `scheme` from step `begin` and return what it shows: all outputs after each step, and the fields."""
    shown = []
    for i in range(begin, begin + count):
        scheme.step(i * h, h)
        shown += [scheme.rods[0].outputs.copy(), scheme.fluid.outputs.copy()]
    fields = [scheme.fluid.field(name).ravel() for name in ("u", "v", "p", "vorticity")]
    return np.concatenate(shown + fields)


def assert_same_bits(first, second):
    different = np.flatnonzero(first.view(np.uint64) != second.view(np.uint64))
    pairs = [(first[i], second[i]) for i in different[:3]]
    assert different.size == 0, f"{different.size} of {first.size} values differ, the first {pairs}"


def test_the_flow_reaches_the_rod(small_fsi3, start):
    scheme = start(small_fsi3)
    advance(scheme, 0, STEPS)
    assert np.abs(output(scheme.rods[0], "vx")).max() > 0
    assert np.abs(output(scheme.fluid, "force_x")).max() > 0


def test_a_repeated_run_is_the_same(small_fsi3, start):
    assert_same_bits(advance(start(small_fsi3), 0, STEPS), advance(start(small_fsi3), 0, STEPS))


def test_a_restored_state_continues_the_same_way(small_fsi3, start):
    scheme = start(small_fsi3)
    advance(scheme, 0, STEPS)
    before = scheme.rods[0].outputs.copy(), scheme.fluid.outputs.copy()
    scheme.rods[0].save()
    scheme.fluid.save()
    first = advance(scheme, STEPS, STEPS)
    scheme.rods[0].restore()
    scheme.fluid.restore()
    scheme.rods[0].outputs[:], scheme.fluid.outputs[:] = before
    assert_same_bits(first, advance(scheme, STEPS, STEPS))


def test_a_restored_unit_shows_what_it_showed_when_saved(small_fsi3, start):
    scheme = start(small_fsi3)
    advance(scheme, 0, STEPS)
    for unit in (scheme.rods[0], scheme.fluid):
        before = unit.outputs.copy()
        unit.save()
        unit.step(STEPS * 2e-4, 2e-4)
        assert (unit.outputs != before).any()
        unit.restore()
        unit.get()
        assert_same_bits(before, unit.outputs)


def test_a_serialized_state_continues_the_same_way_in_another_instance(small_fsi3, start):
    one, other = start(small_fsi3), start(small_fsi3)
    advance(one, 0, STEPS)
    for source, target in ((one.rods[0], other.rods[0]), (one.fluid, other.fluid)):
        source.save()
        text = source.fmu.serializeFMUstate(source.state)
        target.fmu.deSerializeFMUstate(text, target.state)
        target.restore()
        target.outputs[:] = source.outputs
    assert_same_bits(advance(one, STEPS, STEPS), advance(other, STEPS, STEPS))


def test_a_state_of_another_size_has_another_layout(small_fsi3, start):
    """Whoever changes what a state holds raises STATE_LAYOUT of the unit or the format version of the export, so that
    the states of before are refused."""
    scheme = start(small_fsi3)
    found = {}
    for unit in (scheme.rods[0], scheme.fluid):
        state = unit.serialize()
        assert state[8] == 3, state[8]
        name = state[14 : 14 + state[12]].decode()
        found[unit.name] = name[name.index("layout") :], len(state) - 14 - state[12]
    assert found == {"rod": ("layout 1)", 3158), "fluid": ("layout 11)", 509099)}


def test_a_state_in_single_precision_continues_the_same_way_and_is_half_as_large(small_fsi3, start):
    double = start(small_fsi3)
    small_fsi3["fluid"]["precision"] = "single"
    single = start(small_fsi3)
    advance(single, 0, STEPS)
    single.rods[0].save()
    single.fluid.save()
    before = single.rods[0].outputs.copy(), single.fluid.outputs.copy()
    first = advance(single, STEPS, STEPS)
    single.rods[0].restore()
    single.fluid.restore()
    single.rods[0].outputs[:], single.fluid.outputs[:] = before
    assert_same_bits(first, advance(single, STEPS, STEPS))
    state = single.fluid.serialize()
    assert len(state) < 0.55 * len(double.fluid.serialize())


def test_a_corrupted_state_is_refused(small_fsi3, start):
    rod = start(small_fsi3).rods[0]
    rod.save()
    text = bytearray(rod.fmu.serializeFMUstate(rod.state))
    text[len(text) // 2] ^= 1
    buffer = ctypes.create_string_buffer(bytes(text), len(text))
    state = ctypes.c_void_p()
    function = rod.fmu.dll["fmi2DeSerializeFMUstate"]
    function.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p]
    assert function(rod.fmu.component, buffer, len(text), ctypes.byref(state)) == 3


def test_interleaved_instances_do_not_disturb_each_other(small_fsi3, start):
    alone = advance(start(small_fsi3), 0, STEPS)
    one, other = start(small_fsi3), start(small_fsi3)
    advance(other, 0, 3)
    for i in range(STEPS - 1):
        advance(one, i, 1)
        advance(other, 3 + i, 1)
    last = advance(one, STEPS - 1, 1)
    assert_same_bits(alone[-last.size :], last)


@pytest.mark.parametrize("scheme", ["explicit", {"iterated": {"tolerance": 1e-4, "max_iterations": 50}}])
def test_two_half_runs_are_one_run(small_fsi3, start, scheme):
    small_fsi3["coupling"] = {"load": "pressure_jump", "scheme": scheme}
    small_fsi3["fluid"]["mask"] = {"cosine": {"c_eta": 1e-3, "half_width": 1.0}}
    whole, halves = start(small_fsi3), start(small_fsi3)
    first = advance(whole, 0, STEPS)
    advance(halves, 0, STEPS // 2)
    second = advance(halves, STEPS // 2, STEPS // 2)
    assert_same_bits(first[-second.size :], second)


def test_a_forged_state_with_a_work_that_is_no_number_is_refused(libraries):
    """The checksum is right: the last number of the state of contact is the work on the last rod."""
    with Session(validate(read(str(ROOT / "examples" / "rods-crossing.json")))) as session:
        session.start()
        unit = session.units["contact"]
        state = unit.serialize()
        begin = 14 + int.from_bytes(state[12:14], "little") + 38  # Of the length of the payload
        for value, words in ((np.nan, "model.exchange.work has NaN"), (-np.inf, "model.exchange.work has -inf")):
            payload = state[begin + 12 : -8] + np.float64(value).tobytes()
            forged = state[: begin + 8] + zlib.crc32(payload).to_bytes(4, "little") + payload
            with pytest.raises(UnitError, match=words):
                unit.deserialize(forged)
        unit.deserialize(state)
        assert unit.serialize() == state
