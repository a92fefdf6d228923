"""Tables of the page."""

from __future__ import annotations

from html import escape

from ema_tools.words.page import text as words
from ema_tools.words.page.results import BALANCES, FAULTS, ShownComparison, ShownIdentification

_LABELS = {"csj_Nm": ("CSJ", "Nm"), "blk_mm": ("BLK", "mm")}
_CHANNELS = {
    "position_mm": ("Rod position", "mm"),
    "motor_position_mm": ("Motor position at the rod", "mm"),
    "speed_mm_s": ("Rod speed", "mm/s"),
    "current_A": ("Motor current", "A"),
    "voltage_V": ("Motor voltage", "V"),
}
CHANNEL_TITLES = {name: title for name, (title, _) in _CHANNELS.items()}
_BALANCES = {
    "mechanical": ("Mechanical", "Nm", "torque of the motor against what the mechanics take"),
    "electrical": ("Electrical", "V", "applied voltage against resistance, inductance and back-EMF"),
    "kinematic": ("Kinematic", "mm", "rod position against motor position"),
    "controller": ("Controller", "V", "applied command against the control law"),
}


_SUB, _HERE = ' class="sub"', ' class="here"'
_PAPER_HERE = '<th scope="col">paper</th><th scope="col">here</th>'


def beside_paper(results: list[ShownIdentification]) -> str:
    """Truth, estimate and error of every case, here and in the paper."""
    rows = []
    for result in results:
        case, paper = result.case, result.paper
        assert case is not None
        for index, name in enumerate(FAULTS):
            label, unit = _LABELS[name]
            actual, here = case.shift_percent(name), result.faults[name]
            cells = [
                f"<td>{getattr(case, name):g} {unit}</td>",
                _cell(f"{getattr(paper, 'paper_' + name):g}" if paper else None),
                _cell(words.number(here.estimate, 5), here=True),
                _cell(f"{words.signed(paper.paper_shift_percent(name) - actual)} %" if paper else None),
                _cell(f"{words.signed(here.shift_percent - actual)} %", here=True),
            ]
            head = ""
            if index == 0:
                head = f'<th scope="rowgroup" rowspan="2" class="left">{escape(result.label)}</th>'
                time = f"<br>{words.duration(result.wall_s)}" if result.wall_s is not None else ""
                cells += [
                    _cell(f"{paper.paper_iterations}<br>{words.duration(paper.paper_wall_s)}" if paper else None, 2),
                    _cell(f"{result.evaluations}{time}", 2, here=True),
                    _cell(words.shift(paper.paper_reduction_percent, 2) if paper else None, 2),
                    _cell(words.reduction(result.before_mm2s, result.after_mm2s), 2, here=True),
                ]
            rows.append(f'<tr{_SUB if index else ""}>{head}<th scope="row">{label}</th>{"".join(cells)}</tr>')
    return (
        '<div class="scroll" role="region" aria-label="Table: estimates here and in the paper" tabindex="0"><table class="grouped">'
        "<caption>Error: estimate minus truth, in % of the healthy value. Reduction: of the integrated squared position error.</caption>"
        '<colgroup><col><col><col></colgroup><colgroup span="2"></colgroup><colgroup span="2"></colgroup><colgroup span="2"></colgroup><colgroup span="2"></colgroup>'
        '<thead><tr class="groups"><th rowspan="2" class="left" scope="col">Case</th><th rowspan="2" class="left" scope="col">Fault</th><th rowspan="2" scope="col">Truth</th>'
        '<th colspan="2" scope="colgroup">Found</th><th colspan="2" scope="colgroup">Error</th>'
        '<th colspan="2" scope="colgroup">Runs, time</th><th colspan="2" scope="colgroup">Reduction</th></tr>'
        f"<tr>{_PAPER_HERE * 4}</tr></thead><tbody>" + "".join(rows) + "</tbody></table></div>"
    )


def _cell(text: str | None, rows: int = 1, here: bool = False) -> str:
    """A number's cell over `rows` rows; a dash where there is none."""
    span = f' rowspan="{rows}"' if rows > 1 else ""
    return f"<td{span}{_HERE if here else ''}>{text if text is not None else '–'}</td>"


def compared_tables(result: ShownComparison) -> str:
    """Error per channel, and the four balances."""
    rows = []
    for name, (rmse, relative) in result.channels.items():
        label, unit = _CHANNELS.get(name, (name, ""))
        share = None if relative is None else f"{words.number(relative)} %"
        rows.append(f'<tr><th scope="row">{escape(label)}</th><td>{words.number(rmse)} {unit}</td>{_cell(share)}</tr>')
    channels = (
        '<div class="scroll" role="region" aria-label="Table: error per channel" tabindex="0"><table><caption>Measured minus simulated; a few rows at the ends of the record are left out.</caption>'
        '<thead><tr><th class="left" scope="col">Channel</th><th scope="col">rms</th><th scope="col">of the measured</th></tr></thead><tbody>'
        + "".join(rows)
        + "</tbody></table></div>"
    )
    rows = []
    for name in (*BALANCES, *(extra for extra in result.balances if extra not in BALANCES)):
        if name not in result.balances:
            continue
        label, unit, meaning = _BALANCES.get(name, (name, "", ""))
        value = result.balances[name]
        head = f'<th scope="row">{escape(label)}</th><td class="reason">{escape(meaning)}</td>'
        if isinstance(value, str):
            rows.append(f'<tr>{head}<td colspan="2" class="reason">{escape(value)}</td></tr>')
        else:
            rows.append(f"<tr>{head}<td>{words.number(value[0])} {unit}</td><td>{words.number(value[1])} %</td></tr>")
    balances = (
        '<div class="scroll" role="region" aria-label="Table: balances" tabindex="0"><table><caption>Each balance uses measured signals alone; its residual accuses one group of blocks.</caption>'
        '<thead><tr><th class="left" scope="col">Balance</th><th class="left" scope="col">What it weighs</th><th scope="col">rms</th><th scope="col">of the driving side</th></tr></thead><tbody>'
        + "".join(rows)
        + "</tbody></table></div>"
    )
    return channels + balances
