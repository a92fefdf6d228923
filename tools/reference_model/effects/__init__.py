"""The optional effects: one module per row of `ema_effects.def`, found by its name.

What a module must hold depends on its site; `effect` is the named tuple of its parameters, `point` a
`reference_model.point.Point`.

| site | functions |
|---|---|
| PARAMETER | `change_values(effect, values) -> dict` of the values that it changes |
| FRICTION | `level_change_Nm(effect, level_Nm, point)` |
| TORQUE | `torque_Nm(effect, point)` |
| LOAD | `load_Nm(effect, point)`, against extension |
| VOLTAGE | `voltage_change_V(effect, point)` |
| MOTOR | `motor_change(effect, point)`, relative, of torque constant and back-EMF |
| PRESLIDING | `share`, `slope_per_rad`, `fastest_rate_per_s`: see presliding |
| READING | `reading_mm(effect, point)`, added to the rod sensor's; `point.motor_mm` is the rod's position |
| WINDING, GREASE | `change(effect, memory)`, relative, of the resistance, or of dry and viscous friction; `rate_per_s(effect, memory, heat_W)` of the memory |
| TRANSMISSION | `shaft_inertia_kgm2`, `rest`, `reaction_Nm`, `rates`, `rod`, `fastest_rate_per_s`: see transmission_compliance |

Functions of a moving site are decorated with `compiled`; PARAMETER ones are plain Python. `EXAMPLE` holds the values that
the effect's reference vector records: fields of the effect, and `section.field` for what else must differ.
"""

from __future__ import annotations

import importlib
from types import ModuleType

from ema_tools.library.definitions import project_definitions

SITE_FUNCTIONS = {
    "PARAMETER": ("change_values",),
    "FRICTION": ("level_change_Nm",),
    "TORQUE": ("torque_Nm",),
    "LOAD": ("load_Nm",),
    "VOLTAGE": ("voltage_change_V",),
    "MOTOR": ("motor_change",),
    "PRESLIDING": ("share", "slope_per_rad", "fastest_rate_per_s"),
    "READING": ("reading_mm",),
    "WINDING": ("change", "rate_per_s"),
    "GREASE": ("change", "rate_per_s"),
    "TRANSMISSION": ("shaft_inertia_kgm2", "rest", "reaction_Nm", "rates", "rod", "fastest_rate_per_s"),
}


def module_of(name: str) -> ModuleType:
    """The reference of the effect `name`.

    Raises LookupError when the module or a function of its site is missing.
    """
    site = project_definitions().effect(name).site
    path = f"{__name__}.{name}"
    try:
        module = importlib.import_module(path)
    except ModuleNotFoundError as error:
        if error.name != path:
            raise
        raise LookupError(f"{name}: ema_effects.def has it, reference/effects/{name}.py is missing: write it") from None
    if site not in SITE_FUNCTIONS:
        raise LookupError(f"{name}: site {site} is unknown: use one of {', '.join(SITE_FUNCTIONS)}")
    for needed in (*SITE_FUNCTIONS[site], "EXAMPLE"):
        if not hasattr(module, needed):
            raise LookupError(f"reference/effects/{name}.py: no {needed}, which site {site} needs: write it")
    return module


def example_of(name: str) -> dict[str, float]:
    """The values, by full name, that show the effect `name`."""
    example: dict[str, float] = module_of(name).EXAMPLE
    return {key if "." in key else f"{name}.{key}": float(value) for key, value in example.items()}
