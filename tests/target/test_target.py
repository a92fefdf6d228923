"""The checks of the target themselves: programs and answers that must not pass. Python's standard library alone."""

from __future__ import annotations

import struct
import tempfile
import unittest
from pathlib import Path

import emulate
import make_records
import same_answer

GOOD_UNITY = "test_x.c:1:test_y:PASS\n\n-----------------------\n3 Tests 0 Failures 0 Ignored \nOK\n"


class Emulated(unittest.TestCase):
    """What counts as a success of a Unity program."""

    def test_a_good_run(self) -> None:
        self.assertEqual(emulate.unity_verdict(emulate.Run(GOOD_UNITY, 0)), "")

    def test_bad_runs(self) -> None:
        bad = {"nothing printed": ("", 0), "cut short": ("test_x.c:1:test_y:PASS\n", 0), "no tests": (GOOD_UNITY.replace("3 Tests", "0 Tests"), 0),
               "a failure": (GOOD_UNITY.replace("0 Failures", "1 Failures"), 0), "exit code": (GOOD_UNITY, 97), "time": (GOOD_UNITY, emulate.TIMED_OUT)}
        for name, (output, code) in bad.items():
            with self.subTest(name):
                self.assertNotEqual(emulate.unity_verdict(emulate.Run(output, code)), "")

    def test_a_missing_program_is_named(self) -> None:
        with self.assertRaisesRegex(FileNotFoundError, "none.elf not found: build it first"):
            emulate.run("mps2-an386", Path("none.elf"), [])


def answer(**changed: str) -> str:
    """A complete answer as ema_answer prints it."""
    values = dict.fromkeys(same_answer.SHARED, "0") | {"rows": "10000", "model_steps": "2000000"} | changed
    lines = [f"{name} {values[name]}" for name, count in same_answer.SHARED.items() for _ in range(count)]
    return "\n".join([*lines, "slices 12"])


class Answers(unittest.TestCase):
    """What counts as an answer."""

    def test_a_good_answer(self) -> None:
        _, slices = same_answer.shared_part(answer(), "good")
        self.assertEqual(slices, 12)

    def test_bad_answers(self) -> None:
        bad = {"empty": "", "half": "\n".join(answer().splitlines()[:8]), "no slices": answer().replace("slices 12", ""), "rows": answer(rows="9999"),
               "no search": answer(model_steps="20000")}
        for name, output in bad.items():
            with self.subTest(name), self.assertRaises(same_answer.WrongAnswerError):
                same_answer.shared_part(output, name)

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
        path = self.recording("# a remark\ntime_s,position_mm,command_mm\n0,0.1,-2\n")
        bits = tuple(struct.unpack("<I", struct.pack("<f", value))[0] for value in (-2.0, 0.1))
        self.assertEqual(make_records.rows_of(path), [bits])

    def test_refused(self) -> None:
        for text, why in (("time_s,command_mm\n0,1\n", "no column position_mm"), ("command_mm,position_mm\n", "no rows")):
            with self.subTest(why), self.assertRaisesRegex(ValueError, why):
                make_records.rows_of(self.recording(text))


if __name__ == "__main__":
    unittest.main()
