"""python -S -E probe.py LIBRARY GUID RESOURCES LIMIT: use a unit in so many megabytes, with nothing but ctypes.

Says where it came to an end; a process that is ended by a signal says nothing.
"""

import ctypes
import resource
import sys

MOST_STATES = 20_000

library, guid, resources, limit = sys.argv[1:]
unit = ctypes.CDLL(library)
said: list[bytes] = []
LOG = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 2, ctypes.c_int, *[ctypes.c_char_p] * 2)


class Callbacks(ctypes.Structure):
    _fields_ = [("logger", LOG)] + [(f"pointer{k}", ctypes.c_void_p) for k in range(4)]


def log(_environment, _name, _status, _category, message):
    said[:] = [message]


callbacks = Callbacks(logger=LOG(log))
unit.fmi2Instantiate.restype = ctypes.c_void_p
unit.fmi2DoStep.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int]
resource.setrlimit(resource.RLIMIT_AS, (int(limit) << 20, int(limit) << 20))


def end(where: str) -> None:
    assert said and (b"memory" in said[0] or b"bytes" in said[0]), (where, said)
    print(f"without memory for {where}")
    sys.exit()


component = ctypes.c_void_p(
    unit.fmi2Instantiate(b"unit", 1, guid.encode(), resources.encode(), ctypes.byref(callbacks), 0, 0)
)
if not component:
    end("an instance")
for name in ("EnterInitializationMode", "ExitInitializationMode"):
    assert unit[f"fmi2{name}"](component) == 0, said
states: list[ctypes.c_void_p] = []
size = ctypes.c_size_t()
while len(states) < MOST_STATES:
    state = ctypes.c_void_p()
    if unit.fmi2GetFMUstate(component, ctypes.byref(state)) != 0:
        break
    states.append(state)
    assert unit.fmi2SerializedFMUstateSize(component, state, ctypes.byref(size)) == 0 or said
assert unit.fmi2DoStep(component, 0.0, 1e-5, 0) == 0, said
for state in states:
    assert unit.fmi2FreeFMUstate(component, ctypes.byref(state)) == 0, said
assert unit.fmi2DoStep(component, 1e-5, 1e-5, 0) == 0, said
if len(states) < MOST_STATES:
    end("a state")
print("with memory for all")
