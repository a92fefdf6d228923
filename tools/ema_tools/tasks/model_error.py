"""The error of a model on a record, as every command states it: the weighted residual with today's CSJ and BLK and the nuisance parameters at their best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.fit.evidence import Evidence, raw_cost, settled
from ema_tools.fit.nuisance import moved
from ema_tools.fit.refit import fitted_from
from ema_tools.library.faults import FAULTS
from ema_tools.results.parts import ErrorsEntry
from ema_tools.select.baseline import gather
from ema_tools.select.healthy_records import check_once
from ema_tools.select.holdout import weighted
from ema_tools.select.known_machine import KnownMachine, live
from ema_tools.select.sensors import Suspect, odd_signal, suspect


@dataclass(frozen=True)
class ModelError:
    """Rms of the whitened residual; 1 is sensor noise alone where all signals are noisy.

    `given`: the model as its file has it; `fitted`: with CSJ, BLK and nuisance parameters at their best, which are `today` by full name; `noise_level`: of a record with nothing new.
    """

    given: float
    fitted: float
    noise_level: float
    today: Mapping[str, float]
    evidence: Evidence = field(repr=False)

    @property
    def explains(self) -> bool:
        """Whether the model leaves no more than a record with nothing new."""
        return bool(ErrorsEntry(self.given, self.fitted, self.noise_level).explained)

    @cached_property
    def sensor(self) -> Suspect | None:
        """The sensor whose own error would explain what the model does not; sought when asked for."""
        return None if self.explains else suspect(self.evidence) or odd_signal(self.evidence)


def model_error(actuator: Actuator, record: Record, baseline: Sequence[Record] = ()) -> ModelError:
    """The error of `actuator` on `record`, given two or more baseline records of its command where there are any. Raises InputError as `gather` does."""
    evidence = gather(actuator, record, baseline, live(record, *baseline))
    values, cost = _with_faults(evidence) if evidence.relative else _of_unit(evidence)
    today = {name: values[name] for name in FAULTS.values() if name in values}
    given = weighted(raw_cost(evidence), evidence)
    # the model as given is one of those that the fit chooses from
    return ModelError(given, min(given, weighted(cost, evidence)), weighted(evidence.expected_cost(), evidence), today, evidence)


def error_where_known(actuator: Actuator, record: Record, baseline: Sequence[Record], asked: bool) -> ModelError | None:
    """`model_error`, or None for a record that cannot tell it; raises InputError where its baseline records were `asked` for."""
    try:
        check_once(baseline)
        return model_error(actuator, record, baseline)
    except InputError:
        if asked:
            raise
        return None


def _with_faults(evidence: Evidence) -> tuple[Mapping[str, float], float]:
    """CSJ and BLK fitted beside the run-to-run variation, and the cost."""
    known = KnownMachine(evidence)
    base = known.base({})
    start = {name: base.values[name] for name in known.faults}
    fit = fitted_from(evidence, start)
    return fit.values, fit.cost


def _of_unit(evidence: Evidence) -> tuple[Mapping[str, float], float]:
    """The unit's own parameters, CSJ and BLK among them, as far from the data sheet as is credible, and the cost."""
    view = settled(evidence, {})
    return moved(evidence.actuator, evidence.spread, view.deviations), view.cost
