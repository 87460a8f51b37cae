"""An emitted controller behind the interface of the Python references."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from servogen.controllers.design import Declaration, Operation, Port, Status, Value
from servogen.precision import FloatArray


class CompiledController:
    """One instance of an emitted controller; ``call`` as in ``controllers.design.Reference``."""

    def __init__(self, module: Any, declaration: Declaration) -> None:
        self.declaration = declaration
        self._ffi, self._lib = module.ffi, module.lib
        p = declaration.prefix
        # whole doubles, so that the state is aligned for anything in it
        self.memory = self._ffi.new("double[]", 1 + getattr(self._lib, f"{p}_bytes")() // 8)
        self._entry = {
            op.name: getattr(self._lib, f"{p}_{op.name}") for op in declaration.operations
        }
        self._in = {
            op.name: self._ffi.new(f"{p}_{op.name}_in *")
            for op in declaration.operations
            if op.inputs
        }
        self._out = {
            op.name: self._ffi.new(f"{p}_{op.name}_out *")
            for op in declaration.operations
            if op.outputs
        }
        getattr(self._lib, f"{p}_init")(self.memory)

    def call(
        self, operation: str, inputs: Mapping[str, Value] | None = None
    ) -> tuple[Status, dict[str, Value]]:
        op = self.declaration.operation(operation)
        arguments = [self.memory]
        if op.inputs:
            self._fill(op, self._in[operation], inputs or {})
            arguments.append(self._in[operation])
        if op.outputs:
            arguments.append(self._out[operation])
        returned = self._entry[operation](*arguments)
        status = Status(returned) if op.returns_status else Status.OK
        return status, self._read(op, self._out.get(operation))

    def _fill(self, op: Operation, struct: Any, inputs: Mapping[str, Value]) -> None:
        for port in op.inputs:
            value = inputs[port.name]
            if port.size:
                target = np.frombuffer(
                    self._ffi.buffer(self._ffi.addressof(struct, port.name)), self._dtype(port)
                )
                target[:] = value
            else:
                setattr(struct, port.name, int(np.asarray(value)) if port.integer else float(value))

    def _read(self, op: Operation, struct: Any) -> dict[str, Value]:
        outputs: dict[str, Value] = {}
        for port in op.outputs:
            if port.size:
                buffer = self._ffi.buffer(self._ffi.addressof(struct, port.name))
                outputs[port.name] = np.frombuffer(buffer, self._dtype(port)).copy()
            else:
                outputs[port.name] = getattr(struct, port.name)
        return outputs

    def _dtype(self, port: Port) -> np.dtype[Any]:
        return np.dtype(np.int32) if port.integer else self.declaration.precision.dtype

    def repeat(self, operation: str, count: int) -> FloatArray:
        """(count, outputs) of an operation without inputs, called ``count`` times at C speed."""
        op = self.declaration.operation(operation)
        p = f"{self.declaration.prefix}_{operation}"
        array = self._ffi.new(f"{p}_out[]", count)
        getattr(self._lib, f"{p}_repeat")(self.memory, count, array)
        flat = np.frombuffer(self._ffi.buffer(array), self.declaration.precision.dtype)
        return flat.reshape(count, len(op.outputs)).copy()
