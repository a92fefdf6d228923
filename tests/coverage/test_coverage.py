"""What is counted, what is a gap, and that each way in which counts, table and page can disagree is told."""

from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from typing import Any

import mcdc
import page
import reached

CODE = "src/plant/code.c"
LINES = ["int f(int a, int b)", "{", "    if ((a > 0) && (b > 0)) {", "        return HELD(a);", "    }", "    return g(a);", "}"]


def function(
    records: list[list[Any]], conditions: list[list[int]], expansions: list[list[int]], names: list[str], name: str = "f"
) -> dict[str, Any]:
    """One function as llvm-cov exports it: conditions and expansions as (line, column, end line, end column, file, expanded file)."""
    branches = [[*row[:4], 1, 1, row[4], 0, mcdc.CONDITION] for row in conditions]
    regions = [[*row[:4], 1, row[4], row[5], mcdc.EXPANSION] for row in expansions]
    return {
        "name": name,
        "filenames": names,
        "branches": branches,
        "regions": regions,
        "mcdc_records": [[*row[:4], 0, 5, row[4]] for row in records],
    }


class Tree(unittest.TestCase):
    """A project of one file in a temporary folder."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name).resolve()
        self.code = self.write(CODE, "\n".join(LINES) + "\n")

    def write(self, path: str, text: str) -> Path:
        """Make one file of the project."""
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        return file

    def table(self, text: str) -> list[page.Explained]:
        """The table of explanations with this text."""
        return page.read_table(self.write(page.TABLE, text))


class Reached(unittest.TestCase):
    """reached.py"""

    @staticmethod
    def library(count: int, branches: list[int]) -> dict[reached.Place, reached.Line]:
        """A library of one line, with a line that is no code behind it."""
        line = {"line_number": 3, "count": count, "branches": [{"count": taken} for taken in branches], "gcovr/noncode": False}
        return reached.read(
            {"files": [{"file": CODE, "lines": [line, {"line_number": 4, "count": 0, "branches": [], "gcovr/noncode": True}]}]}
        )

    def test_libraries_are_joined_line_by_line(self) -> None:
        """Each library adds what it ran."""
        joined = reached.join([self.library(0, [0, 0]), self.library(2, [2, 0])])
        self.assertEqual(joined, {(CODE, 3): reached.Line(True, [True, False])})

    def test_other_branches_are_not_the_same(self) -> None:
        """A library in which the line has another number of branches says that it ran, and nothing of its branches."""
        joined = reached.join([self.library(0, [0, 0]), self.library(2, [2, 1, 1])])
        self.assertEqual(joined, {(CODE, 3): reached.Line(True, [False, False])})


class Conditions(Tree):
    """mcdc.py"""

    def read(self, *functions: dict[str, Any]) -> dict[mcdc.Key, mcdc.Decision]:
        """The decisions of these functions."""
        return mcdc.read({"data": [{"functions": list(functions)}]})

    def plain(self, shown: list[bool], name: str = "f") -> dict[str, Any]:
        """The decision in the third line."""
        return function([[3, 9, 3, 28, shown]], [[3, 9, 3, 16, 0], [3, 20, 3, 27, 0]], [], [str(self.code)], name)

    def test_conditions_are_named_by_their_code(self) -> None:
        """One of two was not shown."""
        (decision,) = self.read(self.plain([True, False])).values()
        self.assertEqual((decision.count, decision.missed, decision.missing()), (2, 1, ["(b > 0)"]))

    def test_a_function_of_a_header_counts_once(self) -> None:
        """Each file that includes it adds what it showed."""
        (decision,) = self.read(self.plain([True, False], "one.c:f"), self.plain([False, True], "two.c:f")).values()
        self.assertEqual((decision.count, decision.missed), (2, 0))

    def test_what_is_known_when_compiling_is_not_counted(self) -> None:
        """It has no branches, and llvm says that it was not shown."""
        (decision,) = self.read(function([[3, 9, 3, 28, [False, True]]], [[3, 20, 3, 27, 0]], [], [str(self.code)])).values()
        self.assertEqual((decision.count, decision.missed), (1, 0))

    def test_a_condition_of_a_macro_belongs_to_the_decision_that_calls_it(self) -> None:
        """The branch lies in the macro's own lines."""
        called = function(
            [[3, 9, 3, 28, [True, False]]], [[3, 9, 3, 16, 0], [1, 1, 1, 4, 1]], [[3, 20, 3, 27, 0, 1]], [str(self.code), str(self.code)]
        )
        (decision,) = self.read(called).values()
        self.assertEqual((decision.count, decision.missing()), (2, ["int"]))

    def test_each_use_of_a_macro_is_a_decision(self) -> None:
        """Two uses of the macro in the third line."""
        conditions = [[3, 9, 3, 16, 1], [3, 20, 3, 27, 1], [3, 9, 3, 16, 2], [3, 20, 3, 27, 2]]
        uses = [[4, 16, 4, 23, 0, 1], [6, 12, 6, 16, 0, 2]]
        twice = function([[3, 9, 3, 28, [True, True]], [3, 9, 3, 28, [True, False]]], conditions, uses, [str(self.code)] * 3)
        self.assertEqual([decision.missed for decision in self.read(twice).values()], [0, 1])

    def test_the_same_numbers_in_another_file(self) -> None:
        """A macro of another file stands in lines and columns that lie within the decision's own."""
        names = [str(self.code), str(self.write("src/plant/other.h", "\n".join(LINES) + "\n"))]
        conditions = [[3, 9, 3, 16, 0], [3, 20, 3, 27, 0], [3, 20, 3, 27, 1]]
        both = function([[3, 9, 3, 28, [True, True]], [3, 12, 3, 28, [False, True]]], conditions, [[6, 12, 6, 16, 0, 1]], names)
        self.assertEqual({Path(key[0]).name: decision.count for key, decision in self.read(both).items()}, {"code.c": 2, "other.h": 1})

    def test_what_does_not_fit_is_refused(self) -> None:
        """More decisions than places, a condition that belongs to none, and one that is known when compiling but was shown."""
        bad = [
            function([[3, 9, 3, 28, [True]], [3, 9, 3, 28, [True]]], [[3, 9, 3, 16, 0]], [], [str(self.code)]),
            function([[3, 9, 3, 28, [True]]], [[3, 9, 3, 16, 0], [6, 12, 6, 16, 0]], [], [str(self.code)]),
            function([[3, 9, 3, 28, [True, True]]], [[3, 9, 3, 16, 0]], [], [str(self.code)]),
        ]
        for one in bad:
            with self.subTest(one), self.assertRaisesRegex(mcdc.ReadError, "f: its . decisions and their conditions do not fit together"):
                self.read(one)


class Page(Tree):
    """page.py"""

    ROW = f'[[gap]]\nfile = "{CODE}"\ncode = "(a > 0)"\nbranches = 1\nwhy = "it is so"\n'

    def setUp(self) -> None:
        super().setUp()
        lines = {(CODE, number): reached.Line(True, [True] * 20) for number in (1, 2, 4)}
        lines[(CODE, 3)] = reached.Line(True, [True, False])
        lines.update({(CODE, number): reached.Line(True, [True] * 20) for number in (5, 6, 7)})
        self.found = page.measured_lines(self.root, lines)

    def test_an_explained_gap_is_no_problem(self) -> None:
        """Nor is what was reached."""
        self.assertEqual(page.problems_of(self.found, self.table(self.ROW)), [])

    def test_a_gap_needs_its_explanation(self) -> None:
        """The line is named."""
        (problem,) = page.problems_of(self.found, [])
        self.assertIn("1 of the branches of `if ((a > 0) && (b > 0)) {` not reached", problem)

    def test_an_explanation_needs_its_gap(self) -> None:
        """Of the line, of the kind, and of the number."""
        for row in (self.ROW.replace("a > 0", "c > 0"), self.ROW + "lines = 1\n", self.ROW.replace("= 1", "= 2")):
            with self.subTest(row):
                self.assertTrue(any("are explained" in problem for problem in page.problems_of(self.found, self.table(row))))

    def test_kinds_of_the_other_measurement_are_left_to_it(self) -> None:
        """Conditions are not known here."""
        self.assertEqual(page.problems_of(self.found, self.table(self.ROW + "conditions = 3\n")), [])

    def test_two_explanations_of_one_line(self) -> None:
        """Which of them counts is not clear."""
        (first, *_) = page.problems_of(self.found, self.table(self.ROW + self.ROW))
        self.assertIn("both about", first)

    def test_limits(self) -> None:
        """Too little, and nothing at all."""
        self.found.counts["branches"][CODE].add(100, 0)
        self.assertTrue(
            any("% of branches are reached, not 99 %" in problem for problem in page.problems_of(self.found, self.table(self.ROW)))
        )
        nothing = page.measured_lines(self.root, {})
        self.assertEqual(
            [problem.split(":")[0] for problem in page.problems_of(nothing, [])], ["no lines were counted", "no branches were counted"]
        )

    def test_a_row_that_says_nothing(self) -> None:
        """Each is named by its number."""
        bad = {"is no key": "branch = 1\n", "give file, code and why": 'why = " "\n', "say how many": "lines = 0\n"}
        for text, change in bad.items():
            key = change.split(" ")[0]
            row = "".join(line for line in self.ROW.splitlines(keepends=True) if not line.startswith(key)) + change
            with self.subTest(text), self.assertRaisesRegex(page.PageError, f"gap 1: .*{text}"):
                self.table(row)

    def test_the_page_holds_what_was_measured(self) -> None:
        """A digit that is another is named; the other measurement's section stays."""
        table = self.table(self.ROW)
        text = page.section("lines", self.found, table, "gcc 1.2")
        other = page.section("mcdc", page.Measured({"conditions": {CODE: page.Count(4, 4)}}), [], "clang 3.4")
        whole = page.with_section(page.with_section("", "lines", text), "mcdc", other)
        self.assertIn(f"| `{CODE}` | 0 | 100.0 | 1 | 99.2 |", whole)
        self.assertIn("| it is so |", whole)
        self.assertIn(f"| `{CODE}` | 0 | 100.0 |\n\n### What is not reached of conditions\n\nNothing.\n", whole)
        self.assertEqual(page.page_problems(whole, "lines", text), [])
        self.assertEqual(page.page_problems(whole, "mcdc", other), [])
        (problem,) = page.page_problems(whole.replace("| 99.2 |", "| 99.3 |"), "lines", text)
        self.assertIn("coverage_write", problem)
        (problem,) = page.page_problems("", "lines", text)
        self.assertIn("# Coverage", problem)

    def test_a_condition_is_named_in_the_page(self) -> None:
        """The code of what was not shown."""
        decision = mcdc.Decision([True, False], 0, ["(a > 0)", "(b > 0)"])
        found = page.measured_mcdc(self.root, {(str(self.code), "f", (3, 9, 3, 28), 0): decision})
        table = self.table(self.ROW.replace("branches", "conditions"))
        self.assertEqual(found.total("conditions"), page.Count(2, 1))
        self.assertIn(
            f"| `{CODE}`: `(a > 0)` | 1 of the conditions, `(b > 0)` | it is so |", page.section("mcdc", found, table, "clang 3.4")
        )


if __name__ == "__main__":
    unittest.main()
