"""The runner of the fuzz targets fails when a target is absent, finds something, did not run, or has no kept inputs."""

from __future__ import annotations

import contextlib
import io
import tempfile
import unittest
from pathlib import Path

import run

GOOD = 'echo "#9 DONE cov: 12 ft: 30" >&2\necho "stat::number_of_executed_units: {count}" >&2\n'
BAD = 'echo "x.c:1: property does not hold: finite" >&2\nexit 77\n'


class RunTest(unittest.TestCase):
    """Programs that only say what libFuzzer would."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        for name in ("programs", "work", "corpus"):
            (self.root / name).mkdir()

    def target(self, name: str, script: str, kept: int = 2) -> None:
        """A program and its corpus."""
        program = self.root / "programs" / name
        program.write_text(f"#!/bin/sh\n{script}", encoding="utf-8")
        program.chmod(0o755)
        (self.root / "corpus" / name).mkdir()
        for place in range(kept):
            (self.root / "corpus" / name / f"input{place}").write_bytes(b"x")

    def call(self, *arguments: str) -> tuple[int, str]:
        """Exit code and everything that was said."""
        said = io.StringIO()
        folders = [f"--{name}={self.root / name}" for name in ("programs", "work", "corpus")]
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            code = run.main([*folders, "--seconds=1", *arguments])
        return code, said.getvalue()

    def test_good_targets_are_counted(self) -> None:
        self.target("a", GOOD.format(count=1000))
        self.target("b", GOOD.format(count=500))
        code, said = self.call("a", "b")
        self.assertEqual(code, 0, said)
        self.assertRegex(said, r"together\s+1500")

    def test_rounds_go_on_until_the_number_is_reached(self) -> None:
        self.target("a", GOOD.format(count=1000))
        code, said = self.call("a", "--executions=2500")
        self.assertEqual(code, 0, said)
        self.assertRegex(said, r"together\s+3000")

    def test_finding_fails_and_is_told(self) -> None:
        self.target("a", GOOD.format(count=1000))
        self.target("b", BAD)
        code, said = self.call("a", "b")
        self.assertEqual(code, 1)
        self.assertIn("b: ended with 77", said)
        self.assertIn("property does not hold: finite", said)

    def test_target_that_did_not_run_fails(self) -> None:
        self.target("a", "exit 0\n")
        self.assertEqual(self.call("a")[0], 1)
        self.target("b", GOOD.format(count=2))
        self.assertEqual(self.call("b")[0], 1)

    def test_absent_target_or_corpus_fails(self) -> None:
        self.assertEqual(self.call("nothing")[0], 1)
        self.target("a", GOOD.format(count=1000), kept=0)
        code, said = self.call("a")
        self.assertEqual(code, 1)
        self.assertIn("no kept inputs", said)


if __name__ == "__main__":
    unittest.main()
