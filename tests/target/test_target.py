"""The checks of the target themselves: programs and answers that must not pass. Python's standard library alone."""

from __future__ import annotations

import dataclasses
import json
import struct
import tempfile
import unittest
from pathlib import Path

import budgets
import builds
import emulate
import example
import make_image
import make_records
import object_coverage
import same_answer
import stack

GOOD_UNITY = "test_x.c:1:test_y:PASS\n\n-----------------------\n3 Tests 0 Failures 0 Ignored \nOK\n"


class Emulated(unittest.TestCase):
    """What counts as a success of a Unity program."""

    def test_a_good_run(self) -> None:
        self.assertEqual(emulate.unity_verdict(emulate.Run(GOOD_UNITY, 0)), "")

    def test_bad_runs(self) -> None:
        bad = {
            "nothing printed": ("", 0),
            "cut short": ("test_x.c:1:test_y:PASS\n", 0),
            "no tests": (GOOD_UNITY.replace("3 Tests", "0 Tests"), 0),
            "a failure": (GOOD_UNITY.replace("0 Failures", "1 Failures"), 0),
            "exit code": (GOOD_UNITY, 97),
            "time": (GOOD_UNITY, emulate.TIMED_OUT),
        }
        for name, (output, code) in bad.items():
            with self.subTest(name):
                self.assertNotEqual(emulate.unity_verdict(emulate.Run(output, code)), "")

    def test_a_missing_program_is_named(self) -> None:
        with self.assertRaisesRegex(FileNotFoundError, "none.elf not found: build it first"):
            emulate.run("mps2-an386", Path("none.elf"), [])


def answer(**changed: str) -> str:
    """A complete answer as ema_answer prints it."""
    values = dict.fromkeys(same_answer.SHARED, "0") | {"rows": "10000", "model_steps": "2000000"} | changed
    count = dict.fromkeys(same_answer.OF_A_VALUE, 2)
    lines = [f"{name} {values[name]}" for name in same_answer.SHARED for _ in range(count.get(name, 1))]
    return "\n".join([*lines, "slices 12"])


class Answers(unittest.TestCase):
    """What counts as an answer."""

    def test_a_good_answer(self) -> None:
        _, slices = same_answer.shared_part(answer(), "good")
        self.assertEqual(slices, 12)

    def test_bad_answers(self) -> None:
        bad = {
            "empty": "",
            "half": "\n".join(answer().splitlines()[:8]),
            "no slices": answer().replace("slices 12", ""),
            "rows": answer(rows="9999"),
            "no search": answer(model_steps="20000"),
        }
        for name, output in bad.items():
            with self.subTest(name), self.assertRaises(same_answer.WrongAnswerError):
                same_answer.shared_part(output, name)

    def test_a_value_too_few(self) -> None:
        with self.assertRaisesRegex(same_answer.WrongAnswerError, "2 lines `estimate` instead of 4"):
            same_answer.shared_part(answer(), "unit", same_answer.VALUES["u"])

    def test_the_stored_answer(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        file = Path(folder.name) / "stored.json"
        names = [name for name in same_answer.SHARED if name not in ("case", "seed", "format", "rows")]
        good = {name: ["0"] * (2 if name in same_answer.OF_A_VALUE else 1) for name in names} | {"model_steps": ["2000000"]}
        bad = {
            "estimate is 0 1": good | {"estimate": ["0", "1"]},
            "reasons is 4": good | {"reasons": ["4"]},
            "no verdict": {name: value for name, value in good.items() if name != "verdict"},
        }
        file.write_text(json.dumps({"answer": good}), encoding="utf-8")
        same_answer.check_stored(file, answer())
        for why, stored in bad.items():
            file.write_text(json.dumps({"answer": stored}), encoding="utf-8")
            with self.subTest(why), self.assertRaisesRegex(same_answer.WrongAnswerError, why):
                same_answer.check_stored(file, answer())

    def test_one_bit_differs(self) -> None:
        ours, _ = same_answer.shared_part(answer(estimate="3e999995 0.3"), "host")
        theirs, _ = same_answer.shared_part(answer(estimate="3e999994 0.3"), "target")
        same_answer.compare(ours, ours, "same")
        with self.assertRaisesRegex(same_answer.WrongAnswerError, "3e999994"):
            same_answer.compare(ours, theirs, "other")


class Records(unittest.TestCase):
    """Tables of recordings."""

    def recording(self, text: str) -> Path:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = Path(folder.name) / "case.csv"
        path.write_text(text, encoding="utf-8")
        return path

    def test_rows(self) -> None:
        path = self.recording("# a remark\ntime_s,position_mm,current_A,command_mm\n0,0.1,3,-2\n")
        bits = tuple(struct.unpack("<I", struct.pack("<f", value))[0] for value in (-2.0, 0.1, 3.0))
        self.assertEqual(make_records.rows_of(path), [bits])

    def test_a_source_of_its_own(self) -> None:
        text = make_records.source(self.recording("command_mm,position_mm,current_A\n1,0,0\n"), "ace_record.h")
        wanted = [
            '#include "ace_record.h"',
            "const uint32_t ace_record_rows = 1U;",
            "const uint32_t ace_record[1][3] = {",
            "    {0x3F800000U, 0x00000000U, 0x00000000U},",
        ]
        self.assertEqual([line for line in text.splitlines() if line], [*wanted, "};"])

    def test_refused(self) -> None:
        for text, why in (("time_s,command_mm\n0,1\n", "no column position_mm"), ("command_mm,position_mm,current_A\n", "no rows")):
            with self.subTest(why), self.assertRaisesRegex(ValueError, why):
                make_records.rows_of(self.recording(text))


class Images(unittest.TestCase):
    """Images of configurations as arrays."""

    def test_a_source(self) -> None:
        lines = [line for line in make_image.source(bytes(range(25))).splitlines() if line]
        self.assertEqual(lines[2:4], ["const size_t ace_image_bytes = 25U;", "_Alignas(uint32_t) const uint8_t ace_image[25] = {"])
        self.assertEqual(lines[4:], ["    " + ", ".join(f"{k}U" for k in range(24)) + ",", "    24U,", "};"])

    def test_one_bit(self) -> None:
        self.assertEqual(make_image.flipped(b"\x00\xff", 9), b"\x00\xfd")
        for bit in (-1, 16):
            with self.subTest(bit), self.assertRaisesRegex(ValueError, "16 bits"):
                make_image.flipped(b"\x00\xff", bit)


def node(name: str, size: int, kind: str = "static") -> str:
    """A function of a call graph as gcc writes it."""
    return f'node: {{ title: "{name}" label: "{name}\\nfile.c:1:1\\n{size} bytes ({kind})" }}'


def call(caller: str, callee: str) -> str:
    """A call in it."""
    return f'edge: {{ sourcename: "{caller}" targetname: "{callee}" label: "file.c:2:3" }}'


class Stacks(unittest.TestCase):
    """Bounds from call graphs."""

    def graph(self, *lines: str) -> stack.Graph:
        graph = stack.Graph()
        graph.add("\n".join(lines))
        return graph

    def test_the_deepest_chain(self) -> None:
        graph = self.graph(
            node("ema_a", 8), node("b.c:b", 100), node("c.c:c", 24), call("ema_a", "b.c:b"), call("ema_a", "c.c:c"), call("c.c:c", "memcpy")
        )
        self.assertEqual(graph.worst("ema_a"), (108, ("ema_a", "b")))
        self.assertEqual(graph.worst("c.c:c"), (24 + stack.LIBRARY_BYTES["memcpy"], ("c", "memcpy")))

    def test_no_bound(self) -> None:
        bad = {
            "recursion": (node("ema_a", 8), node("b", 8), call("ema_a", "b"), call("b", "ema_a")),
            "pointer": (node("ema_a", 8), call("ema_a", stack.INDIRECT)),
            "not in the call graph": (node("ema_a", 8), call("ema_a", "malloc")),
        }
        for why, lines in bad.items():
            with self.subTest(why), self.assertRaisesRegex(stack.StackError, why):
                self.graph(*lines).worst("ema_a")
        with self.assertRaisesRegex(stack.StackError, "unknown size"):
            self.graph(node("ema_a", 8, "dynamic"))

    def test_a_library_that_is_not_known(self) -> None:
        graph = self.graph(node("ema_a", 8), call("ema_a", "memcpy"), call("ema_a", "__builtin_memset"), call("ema_a", "__divti3"))
        graph.own = True
        self.assertEqual(graph.worst("ema_a")[0], 8)
        with self.assertRaisesRegex(stack.StackError, "not in the call graph"):
            self.graph(node("ema_a", 8), call("ema_a", "__divti3")).worst("ema_a")

    def test_nothing_to_look_at(self) -> None:
        with tempfile.TemporaryDirectory() as folder, self.assertRaisesRegex(stack.StackError, "no call graph"):
            stack.load(Path(folder))


LOOKED = """healthy chirp free slice 70000 of 203 step 4000 of 13 start 17000
healthy noise seized slice 80000 of 210 step 9000 of 30 start 17001
presliding chirp free slice 90000 of 290 step 29000 of 114 start 31890
session healthy wrong_sign slice 86000
combinations pairs of 40 slice 88000 refused 0
looked everywhere
"""
LEVELS = (budgets.Level("-O0", 60_000, 700), budgets.Level("-O2", 29_000, 500))


def measured(**changed: float) -> budgets.Measured:
    """A measurement inside every target, apart from what is changed and what MISSED excuses."""
    counts: dict[str, float] = {
        "size_ema_session_t": 7000,
        "size_ema_session_config_t": 200,
        budgets.RECORD: 40000,
        "size_ema_actuator_t": 700,
    }
    counts |= {
        f"model_step_{name}_{which}": 300
        for name in ("healthy", "effect_stribeck_friction", "effect_cogging_torque", "effect_torque_ripple")
        for which in ("mean", "most")
    }
    counts |= {
        f"{name}_{which}": 300
        for name in (
            "selftest",
            "session_init",
            "session_feed",
            "session_result",
            "session_result_done",
            "slice_1",
            "slice_200",
            "slice_1000",
        )
        for which in ("mean", "most")
    }
    counts |= {
        f"identify_int16_{slice_}{what}": value
        for slice_ in budgets.SLICES
        for what, value in (("", 70_000_000), ("_steps", 160_000 if slice_ == 1 else 200_000))
    }
    counts |= {f"size_ema_{name}_t": 300 for name in ("guarded", "command", "onboard")} | {
        "size_table": 90_000,
        "table_products": 184,
        "table_bin_rows": 40,
    }
    counts |= {f"{budgets.STEP}{name}_mean": limit for name, (_, limit) in budgets.STEPS.items()}
    counts["size_ema_guarded_t"] = 7300
    counts |= {
        f"{name}_{which}": 300
        for name in (
            "guarded_init",
            "guarded_feed",
            "guarded_result",
            "guarded_slice_1",
            "guarded_slice_200",
            "guarded_function_slice_200",
            "onboard_start",
            "onboard_slice_200",
            "onboard_result",
        )
        for which in ("mean", "most")
    }
    counts |= {
        f"guarded_{what}": value
        for what, value in (
            ("identify", 500_000_000),
            ("steps", 1_500_000),
            ("function_identify", 700_000_000),
            ("function_steps", 2_000_000),
        )
    }
    counts |= {f"{name}_{which}": 3000 for name in ("unit_slice_8", "unit_slice_200", "model_step_unit") for which in ("mean", "most")}
    counts |= {"unit_identify_8": 5.1e8, "unit_identify_200": 5e8, "unit_steps": 2.4e5, "unit_runs": 26, "stack_unit_run": 400}
    counts |= {
        f"squares_{count}_{name}_{which}": 400 for count in (2, 8) for name in ("init", "slice_200", "result") for which in ("mean", "most")
    }
    counts |= {f"squares_{count}_{what}": 40_000 for count in (2, 8) for what in ("whole", "runs", "steps")} | {
        "size_ema_least_squares_t": 10_700
    }
    counts |= {f"trend_{name}_{which}": 1500 for name in ("update", "law", "result", "save") for which in ("mean", "most")}
    counts |= {"trend_whole": 40_000_000, "size_ema_trend_t": 604, "size_ema_forecast_t": 396}
    counts |= {"onboard_whole": 4_000_000} | changed
    return budgets.Measured(
        "12.2.1",
        counts,
        28_000,
        24_000,
        "-flto",
        20_000,
        16_500,
        {"ema_session_run": (500, ("ema_session_run",))},
        28_000,
        25_200,
        30_000,
        LEVELS,
        budgets.worst_of(LOOKED),
    )


class Builds(unittest.TestCase):
    """The table of builds."""

    def built(
        self, answer: str = "a", used: int | None = 640, slice: int | None = 120_000, work: int | None = 306
    ) -> tuple[builds.Machine, str, builds.Built]:
        return builds.MACHINES[0], "-Os", builds.Built(90_000, 800, used, slice, work, answer)

    def test_rows(self) -> None:
        rows = builds.table([self.built(), self.built(answer="b", slice=130_000), self.built(answer="", used=None, slice=None, work=None)])
        self.assertRegex(rows[2], r"\| 90 000 \| 800 \| 640 \| 120 000 \| equal \|$")
        self.assertRegex(rows[3], r"130 000 \| \*\*other\*\* \|$")
        self.assertRegex(rows[4], r"\| 800 \| - \| - \| by the page's own test \|$")

    def test_work_is_the_same_everywhere(self) -> None:
        self.assertEqual(builds.work_of([self.built(), self.built(work=None)]), 306)
        for rows in ([self.built(), self.built(work=307)], [self.built(work=None)]):
            with self.subTest(len(rows)), self.assertRaisesRegex(builds.BuildError, "same in every build"):
                builds.work_of(rows)

    def test_the_end_of_the_program(self) -> None:
        self.assertEqual(builds.MOST.findall("x\nmost slice 121672 work 306 stack 424\n"), [("121672", "306", "424")])


class ObjectCoverage(unittest.TestCase):
    """What of the object code was reached."""

    def function(self) -> object_coverage.Function:
        return object_coverage.Function("ema_a", "a", 8, {0: 2, 2: 2, 4: 4}, {2})

    def test_blocks(self) -> None:
        function = self.function()
        known = {("ema_a", 8): function}
        object_coverage.take(
            known, [("ema_a", 0x100, 8), ("ema_a", 0x200, 12), ("main", 0x300, 8)], "100 104 1 0\n300 304 1 1\n200 204 0 1\n"
        )
        self.assertEqual((function.reached, function.fell, function.branched), ({0, 2}, {2}, set()))
        self.assertEqual((function.missed(), function.ways_missed()), (1, 1))
        object_coverage.take(known, [("ema_a", 0x400, 8)], "400 404 0 1\n404 408 0 1\n")
        self.assertEqual((function.missed(), function.ways_missed()), (0, 0))
        self.assertEqual(object_coverage.problems_of([function]), [])

    def test_too_little(self) -> None:
        self.assertRegex(" ".join(object_coverage.problems_of([self.function()])), "0.0 % of the instructions.*0.0 % of the ways")
        self.assertIn("`ema_a` | 3 | 3", object_coverage.document([self.function()], 1, "12.2.1"))

    def test_instructions(self) -> None:
        lines = ("   2:\td001      \tbeq.n\t8 <ema_a+0x8>", "   4:\tf000 f800 \tbl\t0 <ema_b>", "   8:\t00000000 \t.word\t0x00000000")
        found = [object_coverage.INSTRUCTION.match(line) for line in lines]
        self.assertEqual([match[3] for match in found if match], ["beq.n", "bl"] + ([".word"] if found[2] else []))
        self.assertTrue(all(object_coverage.CONDITIONAL.match(word) for word in ("beq.n", "bne.w", "cbz", "cbnz", "blt")))
        self.assertFalse(any(object_coverage.CONDITIONAL.match(word) for word in ("b.n", "bl", "bx", "blx", "bic")))


class Budgets(unittest.TestCase):
    """The document and its targets."""

    def test_its_own_document(self) -> None:
        self.assertEqual(budgets.problems_of(measured(), budgets.document(measured())), [])

    def test_another_number(self) -> None:
        for name in (
            "session_feed_mean",
            "guarded_slice_200_most",
            "onboard_start_mean",
            "size_ema_onboard_t",
            "onboard_whole",
            "unit_slice_8_most",
            "squares_8_slice_200_mean",
            "trend_law_most",
            "trend_whole",
        ):
            with self.subTest(name):
                self.assertRegex(" ".join(budgets.problems_of(measured(**{name: 1e6}), budgets.document(measured()))), "is now")

    def test_no_document(self) -> None:
        self.assertRegex(" ".join(budgets.problems_of(measured(), "")), "no document")

    def test_a_missed_target(self) -> None:
        slow = measured(identify_int16_200=1_100_000_000)
        self.assertRegex(" ".join(budgets.problems_of(slow, budgets.document(slow))), "mend it")
        large = measured(size_table=140_000)
        self.assertRegex(" ".join(budgets.problems_of(large, budgets.document(large))), "table of signatures.*mend it")

    def test_a_reason_too_many(self) -> None:
        small = dataclasses.replace(measured(), code=20_000, bare=10_000)
        self.assertRegex(" ".join(budgets.problems_of(small, budgets.document(small))), "take it out")

    def test_a_fixed_build(self) -> None:
        small = dataclasses.replace(measured(), fixed=15_000)
        self.assertRegex(" ".join(budgets.problems_of(small, budgets.document(small))), "by all `-DEMA_ONLY_`: met.*take it out")

    def test_the_longest_slice(self) -> None:
        worst = budgets.worst_of(LOOKED)
        self.assertEqual([(run.name, run.slice) for run in worst.slices()], [("presliding", 90_000), ("healthy", 80_000)])
        self.assertEqual(
            [(run.name, run.step, run.seized) for run in worst.steps()], [("presliding", 29_000, False), ("healthy", 9_000, True)]
        )
        for line in (
            "session healthy noise slice 127000",
            "healthy jumps free slice 127000 of 200 step 9000 of 30 start 17000",
            "combinations all of 6 slice 127000 refused 0",
        ):
            late = dataclasses.replace(measured(), worst=budgets.worst_of(f"{line}\n{LOOKED}"))
            self.assertRegex(" ".join(budgets.problems_of(late, budgets.document(late))), "longest slice.*mend it")
        for output in ("", LOOKED.replace("looked everywhere\n", ""), "looked everywhere\n"):
            with self.subTest(output), self.assertRaises(budgets.BudgetError):
                budgets.worst_of(output)

    def test_the_page(self) -> None:
        page = "before\n<!-- budgets: x -->\n<!-- end of budgets -->\nafter\n"
        once = budgets.with_summary(page, measured())
        self.assertRegex(once, r"(?s)^before\n<!-- budgets: x -->\n\| what .*27\.3 KiB.*\|\n<!-- end of budgets -->\nafter\n$")
        self.assertEqual(budgets.with_summary(once, measured()), once)
        self.assertNotEqual(budgets.with_summary(once, measured(slice_200_most=301)), once)
        with self.assertRaisesRegex(budgets.BudgetError, "no marks"):
            budgets.with_summary("before\nafter\n", measured())

    def test_counting_that_stopped(self) -> None:
        for output in ("", "session_feed_mean 300\n", f"session_feed_mean 0\n{budgets.COUNTED_ALL}\n"):
            with self.subTest(output), self.assertRaises(budgets.BudgetError):
                budgets.counts_of(output)


REPORT = {
    "status": "ok",
    "ticks": "15000",
    "ticks_searching": "5000",
    "late_ticks": "0",
    "tick_us": "41",
    "slices": "10000",
    "overruns": "0",
    "slice_us": "900",
    "allowed_us": "2000",
    "verdict": "1",
    "adequate": "1",
    "reasons": "00000000",
    "finding": "adequate",
    "effect": "none",
    "size": "0 0",
}
HIDDEN = {"verdict": "2", "adequate": "0", "reasons": "00000132", "finding": "missing", "effect": "inverter_dead_time", "size": "0 0.297"}


def report(**changed: str) -> str:
    """What the example firmware prints when all is well, apart from what is changed."""
    values = REPORT | {"first": "0.3001", "second": "0.0411", "shift": "6.6"} | changed
    pairs = [
        f"estimate 0 {values.pop('first')}",
        f"estimate 0 {values.pop('second')}",
        f"shift_percent 0 {values.pop('shift')}",
        "shift_percent 0 7",
    ]
    return "\n".join([*(f"{name} {value}" for name, value in values.items()), *pairs])


class Example(unittest.TestCase):
    """The example firmware's report."""

    def test_a_good_report(self) -> None:
        self.assertEqual(example.problems_of(report(), example.OK), [])
        self.assertEqual(example.problems_of(report(**HIDDEN), example.OK, example.MACHINES[2]), [])

    def test_bad_reports(self) -> None:
        bad = [
            {"late_ticks": "1"},
            {"overruns": "3"},
            {"slice_us": "0"},
            {"slice_us": "2001"},
            {"ticks": "10000", "ticks_searching": "0"},
            {"verdict": "0"},
            {"adequate": "0"},
            {"first": "0.31"},
            {"second": "0.04"},
            {"status": "late"},
            {"slices": "1"},
            {"tick_us": "0"},
            {"reasons": "00000010"},
            {"finding": "missing"},
            {"effect": "jam_spot"},
        ]
        for changed in bad:
            with self.subTest(changed):
                self.assertEqual(len(example.problems_of(report(**changed), example.OK)), 1)
        with self.assertRaises(ValueError):
            example.problems_of("", example.OK)

    def test_a_recorded_unit(self) -> None:
        _, worn, hidden = example.UNIT
        two_more = "\nestimate 0 0.0001\nestimate 0 0.97\nshift_percent 0 -50\nshift_percent 0 1"
        good = report(shift="21.5").replace("shift_percent 0 7", "shift_percent 0 51")
        self.assertEqual(example.problems_of(good + two_more, example.OK, worn), [])
        self.assertEqual(len(example.problems_of(good, example.OK, worn)), 1)
        self.assertEqual(len(example.problems_of(report(shift="24") + two_more, example.OK, worn)), 1)
        self.assertEqual(example.problems_of(report(**HIDDEN) + two_more, example.OK, hidden), [])
        self.assertEqual(example.row_of(good + two_more, worn), f"| {worn.title} | +21.5 % | +51.0 % | adequate | `FAULT` |")

    def test_the_row_of_the_page(self) -> None:
        self.assertEqual(example.row_of(report(), example.WORN), f"| {example.WORN.title} | +6.6 % | +7.0 % | adequate | `FAULT` |")
        row = example.row_of(report(**HIDDEN), example.MACHINES[2])
        self.assertTrue(row.endswith("| missing: `inverter_dead_time`, 0.297 | `UNDECIDED` |"), row)

    def test_bad_reports_of_a_hidden_effect(self) -> None:
        bad = [
            {"verdict": "1"},
            {"verdict": "0"},
            {"adequate": "1"},
            {"reasons": "00000032"},
            {"finding": "unknown"},
            {"effect": "none"},
            {"effect": "jam_spot"},
            {"size": "0 0.2"},
            {"shift": "4.9"},
        ]
        for changed in bad:
            with self.subTest(changed):
                self.assertEqual(len(example.problems_of(report(**HIDDEN | changed), example.OK, example.MACHINES[2])), 1)


if __name__ == "__main__":
    unittest.main()
