"""Tests .ci/run with programs that only note their arguments: which steps run, the closing line, the exit code. Python's standard library alone."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Each notes its arguments and fails where they contain FAIL.
STUB = """#!/bin/sh
echo "$(basename "$0") $*" >>"$NOTES"
case "$(basename "$0")" in
arm-none-eabi-gcc) echo /somewhere/rdimon.specs ;;
clang*) echo "$RESOURCES" ;;
esac
if [ -n "$FAIL" ]; then case "$*" in *"$FAIL"*) exit 1 ;; esac fi
exit 0
"""
PROGRAMS = (
    *("cc", "cmake", "ctest", "make", "node", "npm", "chromium", "gcovr", "cppcheck", "clang-tidy", "wasm-ld", "apt-get"),
    *("clang", "clang-19", "llvm-cov-19", "llvm-profdata-19", "arm-none-eabi-gcc", "qemu-system-arm"),
)
# All that the script finds of the machine itself.
MACHINE = (
    *("bash", "sh", "git", "python3", "grep", "sed", "awk", "sort", "head", "ls", "cat", "mktemp", "find", "rm", "wc", "touch"),
    *("flock", "xargs", "dirname", "basename", "id"),
)
HOUR_S = 3600
NOW_S = 1_700_000_000


class Run(unittest.TestCase):
    """A small project with a history of its own."""

    def setUp(self) -> None:
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.root = Path(place.name) / "project"
        self.programs = Path(place.name) / "programs"
        self.resources = Path(place.name) / "resources"
        self.notes = Path(place.name) / "notes"
        self.write("tools/tests/test_near.py", "import ema_tools.near_module\n")
        self.write("tools/tests/test_far.py", "import ema_tools.other_module  # in_browser\n")
        self.write("build/venv/bin/python", STUB).chmod(0o755)
        self.write(".ci/run", (ROOT / ".ci/run").read_text(encoding="utf-8")).chmod(0o755)
        self.programs.mkdir()
        for name in PROGRAMS:
            (self.programs / name).write_text(STUB, encoding="utf-8")
            (self.programs / name).chmod(0o755)
        for name in MACHINE:
            (self.programs / name).symlink_to(shutil.which(name) or self.fail(f"{name} is not on this machine"))
        for kind in ("fuzzer", "profile"):
            library = self.resources / f"lib/linux/libclang_rt.{kind}-x86_64.a"
            library.parent.mkdir(parents=True, exist_ok=True)
            library.touch()
        self.git("init", "-q")
        self.commit(NOW_S - 13 * HOUR_S, "src/old.c")

    def write(self, name: str, text: str) -> Path:
        """Writes a file of the project."""
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return path

    def git(self, *words: str, time_s: int = NOW_S) -> None:
        """Runs git in the project."""
        who = {f"GIT_{role}_{key}": value for role in ("AUTHOR", "COMMITTER") for key, value in (("NAME", "a"), ("EMAIL", "a@b"))}
        when = {"GIT_AUTHOR_DATE": f"{time_s} +0000", "GIT_COMMITTER_DATE": f"{time_s} +0000"}
        subprocess.run(["git", *words], cwd=self.root, env={**os.environ, **who, **when}, check=True)

    def commit(self, time_s: int, *names: str) -> None:
        """Commits files of these names."""
        for name in names:
            self.write(name, f"{time_s}\n")
        self.git("add", "-f", ".")
        self.git("commit", "-q", "-m", "change", time_s=time_s)

    def run_ci(self, *arguments: str, root: Path | None = None, **settings: str) -> tuple[int, str, str]:
        """Runs the script. Returns its exit code, its last line, and the noted commands."""
        self.notes.write_text("", encoding="utf-8")
        environment = {
            "PATH": str(self.programs),
            "HOME": str(self.root),
            "NOTES": str(self.notes),
            "RESOURCES": str(self.resources),
            "FAIL": "",
            **settings,
        }
        done = subprocess.run([".ci/run", *arguments], cwd=root or self.root, env=environment, capture_output=True, text=True, check=False)
        return done.returncode, (done.stdout.splitlines() or [""])[-1], self.notes.read_text(encoding="utf-8")

    def test_a_change_of_the_documents_runs_the_usual_steps(self) -> None:
        self.commit(NOW_S, "docs/PAGE.md")
        code, last, notes = self.run_ci()
        self.assertEqual((code, last), (0, "8 passed, 0 failed, 0 skipped"))
        first, *others = [line.split()[-1] for line in notes.splitlines() if line.startswith("cmake --workflow")]
        self.assertEqual(first, "test")
        self.assertEqual(set(others), {"asan", "cortex-m4f", "analysis", "fuzz", "demo"})
        self.assertNotIn("--maxschedchunk", notes)

    def test_all_runs_everything(self) -> None:
        self.commit(NOW_S, "docs/PAGE.md")
        code, last, notes = self.run_ci("--all")
        self.assertEqual((code, last), (0, "15 passed, 0 failed, 0 skipped"))
        for preset in ("coverage", "mcdc", "clang", "packages"):
            self.assertIn(f"--workflow --preset {preset}", notes)
        for preset in ("cortex-m4f-release", "other-packages", "cortex-m33", "long", "release"):
            self.assertIn(f"ctest --preset {preset}", notes)

    def test_files_of_a_step_bring_it_in(self) -> None:
        self.commit(NOW_S, "tests/coverage/page.py", "pyproject.toml", "cmake/clang.cmake")
        _, last, notes = self.run_ci()
        self.assertEqual(last, "12 passed, 0 failed, 0 skipped")
        for preset in ("coverage", "mcdc", "clang", "packages"):
            self.assertIn(f"--workflow --preset {preset}", notes)

    def test_all_commits_of_twelve_hours_are_the_change(self) -> None:
        self.commit(NOW_S - 11 * HOUR_S, "tests/coverage/page.py")
        self.commit(NOW_S, "docs/PAGE.md")
        self.assertIn("--preset coverage", self.run_ci()[2])
        self.assertNotIn("--preset coverage", self.run_ci(EMA_CI_BASE="HEAD~1")[2])

    def test_in_a_shallow_clone_everything_is_the_change(self) -> None:
        self.commit(NOW_S - 13 * HOUR_S, "tests/coverage/page.py")
        self.commit(NOW_S, "docs/PAGE.md")
        self.assertNotIn("--preset coverage", self.run_ci()[2])
        clone = self.root.parent / "clone"
        subprocess.run(["git", "clone", "-q", "--depth", "1", self.root.as_uri(), str(clone)], check=True)
        self.assertIn("--preset coverage", self.run_ci(root=clone)[2])

    def test_long_tests_that_name_a_changed_file_come_first(self) -> None:
        self.commit(NOW_S, "tools/ema_tools/near_module.py")
        line = next(line for line in self.run_ci()[2].splitlines() if "--maxschedchunk" in line)
        self.assertTrue(line.endswith("tests/test_near.py tests/test_far.py"), line)
        self.commit(NOW_S, "tools/ema_tools/other_module.py")
        line = next(line for line in self.run_ci(EMA_CI_BASE="HEAD~1")[2].splitlines() if "--maxschedchunk" in line)
        self.assertTrue(line.endswith("tests/test_far.py tests/test_near.py"), line)

    def test_a_failure_of_any_step_is_the_last_line_and_the_exit_code(self) -> None:
        self.commit(NOW_S, "tools/ema_tools/near_module.py")
        for step, passed in (("preset test", 0), ("preset asan", None), ("preset fuzz", None), ("maxschedchunk", 6), ("preset demo", 7)):
            with self.subTest(step):
                code, last, _ = self.run_ci(FAIL=step)
                self.assertNotEqual(code, 0)
                self.assertRegex(last, r"^\d+ passed, 1 failed, 0 skipped$")
                if passed is not None:
                    self.assertEqual(last.split()[0], str(passed))

    def test_a_missing_program_is_a_skipped_step(self) -> None:
        self.commit(NOW_S, "docs/PAGE.md")
        for name in ("arm-none-eabi-gcc", "cppcheck"):
            (self.programs / name).unlink()
        code, last, notes = self.run_ci()
        self.assertEqual((code, last), (0, "6 passed, 0 failed, 2 skipped"))
        self.assertNotIn("cortex-m4f", notes)

    def test_an_unknown_argument_is_refused(self) -> None:
        code, last, notes = self.run_ci("--every")
        self.assertEqual((code, last, notes), (2, "usage: .ci/run [--all]", ""))


if __name__ == "__main__":
    unittest.main()
