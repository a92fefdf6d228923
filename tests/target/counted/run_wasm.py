"""Runs a program for WebAssembly's system interface by wasmtime, which counts the instructions, and hands on what it prints and its exit code.

    python3 tests/target/counted/run_wasm.py PROGRAM.wasm [ARGUMENT ...]

The program asks for the count by the function `counted` of `ema` (ema_counter_wasm.c). Needs the Python package wasmtime.
"""

from __future__ import annotations

import sys

import wasmtime

# Fuel is spent by one for an instruction, apart from the few that do nothing.
FUEL = 1 << 62


def main() -> int:
    """Entry point."""
    settings = wasmtime.Config()
    settings.consume_fuel = True
    engine = wasmtime.Engine(settings)
    store = wasmtime.Store(engine)
    store.set_fuel(FUEL)
    system = wasmtime.WasiConfig()
    system.argv = sys.argv[1:]
    system.inherit_stdout()
    system.inherit_stderr()
    store.set_wasi(system)
    linker = wasmtime.Linker(engine)
    linker.define_wasi()

    def counted() -> int:
        low = (FUEL - int(store.get_fuel())) & 0xFFFFFFFF
        return low - (1 << 32) if low >> 31 else low

    linker.define_func("ema", "counted", wasmtime.FuncType([], [wasmtime.ValType.i32()]), counted)
    program = linker.instantiate(store, wasmtime.Module.from_file(engine, sys.argv[1]))
    try:
        program.exports(store)["_start"](store)
    except wasmtime.ExitTrap as ended:
        return int(ended.code)
    return 0


if __name__ == "__main__":
    sys.exit(main())
