"""A tuple of arrays and records that is converted for machine code once, not at each call.

numba takes longer to convert all of them than for most runs over samples.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numba import typeof, types
from numba.core.datamodel import models
from numba.extending import NativeValue, intrinsic, register_model, unbox

from brake_monitor.compiled.machine_code import compiled

MOST_BYTES = 1 << 14  # several times what a core of four wheelsets takes
ROOM = types.Array(types.uint8, 1, "C")


class HeldType(types.NamedTuple):  # type: ignore[misc] # numba is not typed
    """The type of a NamedTuple like any other, but for how it is taken over from Python: see `_load`."""


register_model(HeldType)(models.TupleModel)


class HeldTuple:
    """A NamedTuple as it is in machine code; what it consists of must stay where it is."""

    def __init__(self, values: Any) -> None:
        self._values = values  # alive as long as this is
        self._room = np.zeros(MOST_BYTES, dtype=np.uint8)
        kind = typeof(values)
        self.kind = HeldType(kind.types, kind.instance_class)
        self.address: int = self._room.ctypes.data
        _machine_code(kind)(values, self._room)


@cache
def _machine_code(kind: Any) -> Callable[..., None]:
    dispatcher = compiled(_write_down)
    dispatcher.compile((kind, ROOM))
    entry_point: Callable[..., None] = dispatcher.overloads[kind, ROOM].entry_point
    return entry_point


def _write_down(values: Any, room: Any) -> None:
    _store(values, room)


@intrinsic  # type: ignore[untyped-decorator]
def _store(_: Any, values: Any, room: Any) -> Any:
    """Put the values, as machine code represents them, into the room."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        native, array = arguments
        assert context.get_abi_sizeof(native.type) <= MOST_BYTES
        place = context.make_array(signature.args[1])(context, builder, array).data
        builder.store(native, builder.bitcast(place, native.type.as_pointer()))
        return context.get_dummy_value()

    return types.void(values, room), code


@unbox(HeldType)  # type: ignore[untyped-decorator]
def _load(kind: Any, held: Any, code: Any) -> Any:
    """Load the values of a HeldTuple; only by code that counts no references, since none were counted for it."""
    assert not code.context.enable_nrt
    address = code.pyapi.object_getattr_string(held, "address")
    place = code.pyapi.long_as_voidptr(address)
    code.pyapi.decref(address)
    native = code.context.get_value_type(kind)
    return NativeValue(code.builder.load(code.builder.bitcast(place, native.as_pointer())))
