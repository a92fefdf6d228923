"""Tables of the page."""

from __future__ import annotations

from html import escape

from ema_tools.words.page import text as words
from ema_tools.words.page.results import FAULTS, ShownIdentification

_LABELS = {"csj_Nm": ("CSJ", "Nm"), "blk_mm": ("BLK", "mm")}
_CHANNELS = {
    "position_mm": ("Rod position", "mm"),
    "motor_position_mm": ("Motor position at the rod", "mm"),
    "speed_mm_s": ("Rod speed", "mm/s"),
    "current_A": ("Motor current", "A"),
    "voltage_V": ("Motor voltage", "V"),
}
CHANNEL_TITLES = {name: title for name, (title, _) in _CHANNELS.items()}

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
