"""Tests ema_tests.c: it reports a failure, a source without tests and an unknown name by its exit code. Python's standard library alone."""

from __future__ import annotations

import subprocess
import sys
import unittest

PROGRAM = sys.argv.pop()


def run(*names: str) -> tuple[int, str]:
    """Runs the sample program with names of sources. Returns its exit code and all that it prints."""
    done = subprocess.run([PROGRAM, *names], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    return done.returncode, done.stdout


class Runner(unittest.TestCase):
    """The program of three sources: one passes, one fails, one is empty."""

    def test_one_source_runs_alone_with_its_own_set_up(self) -> None:
        code, output = run("sample_passing")
        self.assertEqual(code, 0)
        self.assertEqual(output.count("Tests"), 1)

    def test_sources_run_in_the_order_asked(self) -> None:
        code, output = run("sample_failing", "sample_passing")
        self.assertEqual(code, 1)
        self.assertLess(output.index("failed as intended"), output.index("test_its_own_set_up_came_first"))

    def test_a_failure_is_not_hidden_by_a_later_success(self) -> None:
        self.assertEqual(run("sample_failing", "sample_passing")[0], 1)
        self.assertEqual(run("sample_passing", "sample_failing")[0], 1)

    def test_a_source_without_tests_fails(self) -> None:
        code, output = run("sample_empty")
        self.assertEqual(code, 1)
        self.assertIn("sample_empty ran no test", output)
        self.assertEqual(run("sample_passing", "sample_empty")[0], 1)

    def test_an_unknown_name_fails_before_anything_runs(self) -> None:
        code, output = run("sample_passing", "sample_absent")
        self.assertEqual(code, 2)
        self.assertIn("no test source `sample_absent`", output)
        self.assertNotIn("PASS", output)

    def test_without_names_all_sources_run(self) -> None:
        code, output = run()
        self.assertEqual(code, 1)
        self.assertEqual(output.count("Tests"), 3)


if __name__ == "__main__":
    unittest.main()
