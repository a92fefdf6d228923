"""Tests of the checks in this folder: each passes a good example, fails on each bad one with the line that names it, and fails on an empty project."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import check_calls
import check_class_names
import check_compiles
import check_layers
import check_misra
import check_requirements
import check_symbols
import check_units
import stack  # check_calls has put its folder on the path

HERE = Path(__file__).parent
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
NM = shutil.which("nm")
CPPCHECK = shutil.which("cppcheck")
BINUTILS = bool(COMPILER and NM and sys.platform == "linux")


class Tree(unittest.TestCase):
    """A small project in a temporary folder."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name).resolve()

    def write(self, path: str, text: str) -> Path:
        """Make one file of the project."""
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        return file

    def verdict(self, script: str, *arguments: str) -> tuple[int, str]:
        """Exit code and output of a check, run as ctest does."""
        run = subprocess.run([sys.executable, str(HERE / script), *arguments], capture_output=True, text=True, check=False)
        return run.returncode, run.stdout + run.stderr

    def library(self, sources: list[Path], *flags: str) -> Path:
        """A static library, compiled from these files."""
        library = self.root / "libx.a"
        library.unlink(missing_ok=True)
        subprocess.run([str(COMPILER), "-std=c11", "-O2", *flags, "-c", *map(str, sources)], cwd=self.root, check=True)
        subprocess.run(["ar", "rc", str(library), *(f"{source.stem}.o" for source in sources)], cwd=self.root, check=True)
        return library


class Empty(Tree):
    """Every check that reads the project."""

    def test_an_empty_project_fails(self) -> None:
        for script in ("requirements", "layers", "units", "class_names", "compiles", *(["misra"] if CPPCHECK else [])):
            with self.subTest(script):
                what = ["headers"] if script == "compiles" else []
                code, output = self.verdict(f"check_{script}.py", *what, "--root", str(self.root))
                self.assertEqual(code, 1)
                self.assertRegex(output, r"found no \w+")


class Requirements(Tree):
    """check_requirements.py"""

    def problems(self, *rows: str) -> str:
        """Problems of a page with these rows."""
        self.write(
            "include/ema/ema_a.h",
            "#ifndef A\nvoid ema_a(int x);\nconst char* ema_b(int x);\nstatic inline int ema_c(int x)\n{\n    return x;\n}\n#endif\n",
        )
        self.write("tests/unit/test_a.c", "int main(void)\n{\n    RUN_TEST(test_first);\n    RUN_TEST(second);\n    return 0;\n}\n")
        self.write("tests/CMakeLists.txt", "add_test(NAME whole COMMAND x)\n")
        head = "| id | requirement | functions | tests |\n|---|---|---|---|\n"
        self.write("docs/REQUIREMENTS.md", head + "".join(f"| {row} |\n" for row in rows))
        return " ".join(check_requirements.check(self.root)[0])

    def test_good(self) -> None:
        self.assertEqual(self.problems("EMA-001 | x | `ema_a`, `ema_b` | `a:first`, `whole`", "EMA-002 | y |  | `a:second`"), "")
        self.assertEqual(self.problems("EMA-001 | x | `ema_a`, `ema_b` | `a:*`"), "")

    def test_gaps(self) -> None:
        both = "`ema_a`, `ema_b`"
        for said, rows in (
            ("EMA-002 is next", (f"EMA-001 | x | {both} | `a:first`", "EMA-003 | y |  | `whole`")),
            ("ema_d is no function", (f"EMA-001 | x | {both}, `ema_d` | `a:first`",)),
            ("no test stands behind it", (f"EMA-001 | x | {both} | `a:first`", "EMA-002 | y |  | by hand")),
            ("runs no test third", (f"EMA-001 | x | {both} | `a:third`",)),
            ("test_b.c is not there", (f"EMA-001 | x | {both} | `a:first`, `b:first`",)),
            ("part is no test", (f"EMA-001 | x | {both} | `a:first`, `part`",)),
            ("ema_b has no requirement", ("EMA-001 | x | `ema_a` | `a:first`",)),
            ("test_a.c stands behind no requirement", (f"EMA-001 | x | {both} | `whole`",)),
        ):
            with self.subTest(said):
                self.assertIn(said, self.problems(*rows))


class Layers(Tree):
    """check_layers.py"""

    def setUp(self) -> None:
        super().setUp()
        for path, text in (
            ("include/ema/ema_real.h", "typedef float ema_real;\n"),
            ("include/ema/ema_model.h", '#include "ema/ema_real.h"\n'),
            ("include/ema/ema_search.h", '#include "ema/ema_real.h"\n'),
            ("src/base/ema_math.h", '#include <math.h>\n#include "ema/ema_real.h"\n'),
            ("src/base/ema_note.c", '/*\n#include "ema/ema_model.h"\n*/\n'),
            ("src/blocks/ema_motor.h", '#include "base/ema_math.h"\n'),
            ("src/plant/ema_inner.h", ""),
            ("src/plant/ema_model.c", '#include "ema/ema_model.h"\n#include "blocks/ema_motor.h"\n#include <string.h>\n'),
            ("src/search/ema_search.c", '#include "ema/ema_search.h"\n#include "base/ema_math.h"\n'),
            ("src/ident/ema_ident.c", '#include "ema/ema_model.h"\n#include "ema/ema_search.h"\n'),
            ("port/host/main.c", '#include <stdio.h>\n#include "ema/ema_model.h"\n#include "csv.h"\n'),
            ("port/host/csv.h", ""),
            ("port/desk/desk.c", '#include "blocks/ema_motor.h"\n'),
        ):
            self.write(path, text)

    def test_good(self) -> None:
        """An include in a comment does not count, and the desk sees the blocks."""
        self.assertEqual(check_layers.check(self.root), ([], 13))

    def test_bad(self) -> None:
        """One more file each, and the one problem that it makes."""
        for path, text, said in (
            ("src/blocks/ema_pid.c", '#include "ema/ema_model.h"\n', "src/blocks/ema_pid.c: level blocks sees ema_model.h of level plant"),
            ("src/search/ema_anneal.c", '#include "blocks/ema_motor.h"\n', "level search sees ema_motor.h of level blocks"),
            ("src/base/ema_io.c", '#include "csv.h"\n', "src/base/ema_io.c:1: the module includes port/host"),
            (
                "port/host/blocks.c",
                '\n#include "blocks/ema_motor.h"\n',
                "port/host/blocks.c:2: a port includes the private header blocks/ema_motor.h",
            ),
            (
                "port/desk/inner.c",
                '#include "plant/ema_inner.h"\n',
                "port/desk/inner.c:1: a port includes the private header plant/ema_inner.h",
            ),
            ("include/ema/ema_extra.h", '#include "base/ema_math.h"\n', "a public header includes src/base"),
            ("src/base/ema_log.c", "#include <stdio.h>\n", "src/base/ema_log.c:1: <stdio.h> is not for the module"),
            ("src/base/ema_log.c", "#include <math.h>\n", "<math.h>"),
            ("src/base/ema_odd.c", '#include "nowhere.h"\n', "src/base/ema_odd.c:1: nowhere.h is no header of the project"),
            ("src/extra/ema_odd.c", "", "src has no level extra"),
        ):
            with self.subTest(said):
                file = self.write(path, text)
                problems, _ = check_layers.check(self.root)
                self.assertEqual(len(problems), 1, problems)
                self.assertIn(said, problems[0])
                file.unlink()

    def test_upward_through_another_header(self) -> None:
        """A header without a level of its own passes on what it includes."""
        self.write("include/ema/ema_all.h", '#include "ema/ema_model.h"\n')
        self.write("src/effects/ema_friction.c", '#include "ema/ema_all.h"\n')
        self.assertIn("level effects sees ema_model.h of level plant", check_layers.check(self.root)[0][0])

    def test_circle(self) -> None:
        """Two files of one level that include each other's headers, one of them by way of a third."""
        self.write("src/blocks/ema_gear.h", '#include "ema_wheel.h"\n')
        self.write("src/blocks/ema_wheel.h", "")
        self.write("src/blocks/ema_wheel.c", '#include "ema_wheel.h"\n#include "ema_tooth.h"\n')
        self.write("src/blocks/ema_tooth.h", '#include "ema_gear.h"\n')
        self.assertIn("ema_gear -> ema_wheel -> ema_tooth -> ema_gear: a circle", check_layers.check(self.root)[0][0])


class Symbols(Tree):
    """check_symbols.py, on objects really compiled."""

    def verdict_of(self, text: str) -> tuple[int, str]:
        """Exit code and output for a library of one file."""
        return self.verdict("check_symbols.py", "--nm", str(NM), str(self.library([self.write("x.c", text)], "-fno-builtin")))

    @unittest.skipUnless(BINUTILS, "needs a compiler and nm")
    def test_examples(self) -> None:
        """Good code passes; a library call, a global, a hidden static and an empty library fail, each by name."""
        good = (
            'void* memcpy(void*, const void*, unsigned long);\nstatic const char* const names[2] = {"a", "b"};\n'
            "const char* f(int i, int* p) { memcpy(p, &i, sizeof i); return names[i]; }\n"
        )
        self.assertEqual(self.verdict_of(good)[0], 0, self.verdict_of(good)[1])
        for text, said in {
            "void* malloc(unsigned long); void* f(void) { return malloc(3); }": "needs malloc",
            "double exp(double); double f(double x) { return exp(x); }": "needs exp",
            "float sqrtf(float); float f(float x) { return sqrtf(x); }": "needs sqrtf",
            "int counter; int f(void) { return counter++; }": "counter lies in .bss",
            "int level = 3; int f(void) { return level++; }": "level lies in .data",
            "int f(void) { static int calls; return calls++; }": "lies in .bss",
            "extern int x;\n": "defines no function",
        }.items():
            code, output = self.verdict_of(text)
            self.assertEqual(code, 1, text)
            self.assertIn(said, output)

    def test_problem_names_the_object(self) -> None:
        """The message carries the member of the library."""
        table = "Symbols from libema.a[ema_pid.c.o]:\n\nema_pid |0000| T | FUNC|0010| |.text\npow | | U | NOTYPE| | |*UND*\n"
        self.assertEqual(
            check_symbols.check_table(table, "libema.a"), (["libema.a(ema_pid.c.o): needs pow: keep it out of src, or inline it"], 1)
        )


class Calls(Tree):
    """check_calls.py, on sources really compiled."""

    def verdict_of(self, other: str = "") -> tuple[int, str]:
        """Exit code and output of the check; `other` is in the library alone."""
        library = self.library([*(self.root / "src").rglob("*.c"), self.write("other/c.c", f"extern int none;\n{other}")])
        places = ["--root", str(self.root), "--compiler", str(COMPILER), "--nm", str(NM)]
        return self.verdict("check_calls.py", *places, str(library), str(library))

    @unittest.skipUnless(BINUTILS and check_calls.has_graph(str(COMPILER)), "needs gcc and nm")
    def test_examples(self) -> None:
        """Good code passes; each forbidden thing fails and is named, a recursion also where an optimised build makes a loop of it."""
        self.write(
            "src/base/a.c", "int b(int i);\nint a(int i);\nstatic int one(int i) { return i + 1; }\nint a(int i) { return b(one(i)); }\n"
        )
        self.write("src/base/b.c", "int b(int i);\nint b(int i) { return 2 * i; }\n")
        code, output = self.verdict_of()
        self.assertEqual(code, 0, output)
        self.assertIn("calls: 6 functions, 0 wrong", output)
        code, output = self.verdict_of("int lost(int i);\nint lost(int i) { return i; }\n")
        self.assertEqual(code, 1)
        self.assertIn("lost: the library defines it, the call graph does not hold it", output)
        for text, said in {
            "int sum(int i, int s); int sum(int i, int s) { return i == 0 ? s : sum(i - 1, s + i); }": "sum -> sum: recursion",
            "int a(int i); int b(int i); int c(int i); int c(int i) { return i > 0 ? b(i) : 0; }": "b -> c -> b: recursion",
            "int e(int (*f)(int)); int e(int (*f)(int)) { return f(3); }": "e: calls through a pointer",
            "void g(char*); int e(int n); int e(int n) { char x[n]; x[0] = 1; return x[n - 1]; }": "a frame of unknown size",
            "double exp(double); double e(double x); double e(double x) { return exp(x); }": "e: calls exp",
            "void* malloc(unsigned long); void* e(void); void* e(void) { return malloc(8); }": "e: calls malloc",
        }.items():
            self.write("src/base/d.c", text)
            result = "c(i - 1)" if "int c(" in text else "2 * i"
            self.write("src/base/b.c", f"int b(int i);\nint c(int i);\nint b(int i) {{ return {result}; }}\n")
            code, output = self.verdict_of()
            self.assertEqual(code, 1, text)
            self.assertIn(said, output)
        shutil.rmtree(self.root / "src")
        self.assertIn("libx.a defines no function", self.verdict_of()[1])

    def test_graph(self) -> None:
        """A library that the graph does not hold; two rings in one graph; none in a graph whose paths meet again."""
        self.assertIn("a: the library defines it", "".join(check_calls.check_graph(stack.Graph(), {"a"})))
        self.assertEqual(check_calls.cycles({"a": {"b", "c"}, "b": {"d"}, "c": {"d"}}), [])
        self.assertEqual(check_calls.cycles({"a": {"b"}, "b": {"a", "c"}, "c": {"c"}}), [["a", "b"], ["c"]])


class Units(Tree):
    """check_units.py"""

    def setUp(self) -> None:
        super().setUp()
        self.names = self.write("names.txt", "# comment\nunit Nm\nunit rad_s\nplain gain factor\n")
        self.write(
            "include/ema/ema_a.h",
            "typedef struct { ema_real torque_Nm; ema_real gain; /* ema_real odd; */ int count; } a_t;\nema_real f(ema_real x);\n",
        )

    def problems(self) -> list[str]:
        """Problems of the project."""
        return check_units.check(self.root, self.names)[0]

    def test_good(self) -> None:
        """Units, a listed name; comments, whole numbers and arguments do not count."""
        self.assertEqual(check_units.check(self.root, self.names), ([], 2))

    def test_last_part_of_a_unit(self) -> None:
        """Newton metres per square root of radians per second are no radians per second."""
        self.write("include/ema/ema_b.h", "typedef struct { ema_real drag_Nm_per_rad_s; ema_real fade_per_sqrt_rad_s; } b_t;\n")
        self.assertEqual(["`rad_s` is only the last part" in problem for problem in self.problems()], [True, True])

    def test_bad_fields(self) -> None:
        """A bare name, the second of two, an array, a pointer, a nested structure; the line is right."""
        for field, name in (
            ("ema_real torque;", "torque"),
            ("ema_real a_Nm, speed;", "speed"),
            ("float level[3];", "level"),
            ("const ema_real* table;", "table"),
            ("struct { int n; ema_real inner; } s;", "inner"),
            ("ema_real Nm;", "Nm"),
        ):
            self.write("include/ema/ema_b.h", f"struct b {{\n    int n;\n    {field}\n}};\n")
            self.assertEqual([problem.split(" has")[0] for problem in self.problems()], [f"include/ema/ema_b.h:3: `{name}`"])

    def test_bad_rows(self) -> None:
        """The rows of the lists are held to the same rule; macros in headers are not fields."""
        self.write(
            "include/ema/ema_p.def",
            'EMA_PARAM(motor, torque_Nm, 1.0, 0.0, 2.0, "t")\nEMA_PARAM(motor, speed, 1.0, 0.0, 2.0, "t")\n'
            'EMA_EFFECT(x, TORQUE, 0, 1, "e", "s", "l",\n   EMA_P(size, 0.0, 0.0, 1.0, "t") EMA_P(b_rad_s, -1.0, 0.0, 1.0, "t"))\n',
        )
        self.write("include/ema/ema_c.h", "typedef struct {\n#define EMA_P(field, n) ema_real field;\n#undef EMA_P\n} c_t;\n")
        self.assertEqual(
            [problem.split(" has")[0] for problem in self.problems()],
            ["include/ema/ema_p.def:2: `speed`", "include/ema/ema_p.def:4: `size`"],
        )

    def test_stale_and_broken_list(self) -> None:
        """A name that nothing uses; a line without a reason."""
        self.names.write_text("unit Nm\nplain gain factor\nplain gone factor\n", encoding="utf-8")
        self.assertIn("names.txt: `gone` names nothing any more", self.problems()[0])
        self.names.write_text("unit Nm\nplain gain\n", encoding="utf-8")
        with self.assertRaisesRegex(ValueError, "names.txt:2"):
            self.problems()


@unittest.skipUnless(COMPILER, "needs a compiler")
class Compiles(Tree):
    """check_compiles.py"""

    def test_headers(self) -> None:
        """A header that leans on another one, and one without a guard."""
        self.write("include/ema/a.h", "#ifndef A_H\n#define A_H\n#include <stdint.h>\ntypedef struct { uint32_t n; } a_t;\n#endif\n")
        self.assertEqual(check_compiles.check_headers(self.root, str(COMPILER)), ([], 1))
        self.write("include/ema/b.h", "#ifndef B_H\n#define B_H\nuint32_t b(void);\n#endif\n")
        problems, count = check_compiles.check_headers(self.root, str(COMPILER))
        self.assertEqual((len(problems), count), (2, 2))
        self.assertIn("include/ema/b.h alone, EMA_REAL64=0", problems[0])
        self.write("include/ema/b.h", "typedef struct { int n; } b_t;\n")
        self.assertEqual(len(check_compiles.check_headers(self.root, str(COMPILER))[0]), 2)

    def snippets(self, **texts: str) -> list[str]:
        """Problems of documents that must show C, by name."""
        for name, text in texts.items():
            self.write(f"docs/{name}.md", text)
        return check_compiles.check_snippets(self.root, str(COMPILER), self.root, [], tuple(f"docs/{name}.md" for name in texts))[0]

    def test_snippets(self) -> None:
        """A block that no longer compiles, one that was lost, and one that no document must have."""
        self.write("include/ema/ema_effects.def", "")
        self.write("include/ema/a.h", "#include <stdint.h>\nint32_t a(int32_t n);\n")
        self.write("README.md", "no C\n")
        good = 'Text.\n\n```c\n#include "ema/a.h"\nint32_t b(void);\nint32_t b(void)\n{\n    return a(1);\n}\n```\n'
        self.assertEqual(self.snippets(page=good), [])
        for old, new in (("a(1)", "a(1, 2)"), ("a(1)", "c(1)"), ("ema/a.h", "ema/c.h"), ("a(1);", "a(1)")):
            problems = self.snippets(page=good.replace(old, new))
            self.assertEqual(len(problems), 2)
            self.assertRegex(problems[0], r"^docs/page\.md, EMA_REAL64=0: docs/page\.md:[4-9]")
        self.assertIn("no block of C", self.snippets(page=good.replace("```c", "```"))[0])
        self.assertEqual(len(self.snippets(page=good + "\n```C\nint;;\n```\n")), 2)
        self.assertIn("docs/page.md:12: C in an indented block", self.snippets(page=good + "\n    int n = a(1); /* not compiled */\n")[0])
        (self.root / "docs/page.md").unlink()
        self.assertIn("not there", check_compiles.check_snippets(self.root, str(COMPILER), self.root, [], ("docs/page.md",))[0][0])
        self.write("docs/other.md", good.replace("a(1)", "c(1)"))
        self.assertEqual(len(check_compiles.check_snippets(self.root, str(COMPILER), self.root, [], ())[0]), 2)

    def test_rows_of_effects(self) -> None:
        """A row is an effect of one's own beside the library's, also where the library has one of its name."""
        read = '#define EMA_EFFECT(name, field) typedef struct { int field; } ema_##name##_t;\n#include "ema/ema_effects.def"\n#undef EMA_EFFECT\n'
        self.write("include/ema/ema_effects.def", "EMA_EFFECT(drag, size)\n#ifdef EMA_OWN_EFFECTS\n#include EMA_OWN_EFFECTS\n#endif\n")
        self.write("src/effects/ema_effect_sites.h", f"#ifndef SITES_H\n#define SITES_H\n{read}#endif\n")
        self.write("src/base/ema_actuator.c", '#include "effects/ema_effect_sites.h"\nextern int ema_actuator_check;\n')
        row = "```c\nEMA_EFFECT(drag, force)\n```\n"
        code = '\n```c\n#include "effects/ema_effect_sites.h"\nint f(const ema_drag_t* drag);\nint f(const ema_drag_t* drag)\n{\n    return drag->force;\n}\n```\n'
        self.write("README.md", "no C\n")
        self.assertEqual(self.snippets(page=row + code), [])
        self.assertEqual(len(self.snippets(page=row + code.replace("->force", "->size"))), 2)
        self.assertGreaterEqual(len(self.snippets(page=row.replace("drag, force", "drag, force, 1"))), 2)


class Misra(Tree):
    """check_misra.py"""

    ROW = "| EMA-D1 | 10.4 | addon | Said so. |\n"
    GOOD = "#include <stdint.h>\nuint16_t a(uint16_t x);\nuint16_t a(uint16_t x)\n{\n    return (x > 1U) ? x : 2U;\n}\n"
    FAULT = GOOD.replace("1U", "1")

    def problems(self, source: str, rows: str = "", cppcheck: str | None = CPPCHECK) -> list[str]:
        """Problems of a tree of one source."""
        self.write("docs/MISRA.md", rows)
        self.write("src/base/a.c", source)
        problems, checked, _ = check_misra.check(self.root, str(cppcheck), 1)
        self.assertEqual(checked, 1)
        return problems

    @unittest.skipUnless(CPPCHECK, "needs cppcheck")
    def test_finding_and_mark(self) -> None:
        """A fault is seen, a mark with a row answers it, without the fault the mark is too much; a file that is no C is not clean."""
        unanswered = "src/base/a.c:5: against the required rule 10.4: mend it, or mark it with a deviation of docs/MISRA.md"
        self.assertEqual(self.problems(self.FAULT), [unanswered])
        self.assertEqual(self.problems(self.FAULT.replace("2U;", "2U; /* EMA-D1 */"), self.ROW), [])
        stale = "src/base/a.c:5: nothing is found against rule 10.4 any more: take the mark EMA-D1 off"
        self.assertEqual(self.problems(self.GOOD.replace("2U;", "2U; /* EMA-D1 */"), self.ROW), [stale])
        self.assertIn("src/base/a.c:3: syntaxError", self.problems("int a(void)\n{\n    return (;\n}\n")[0].replace(f"{self.root}/", ""))

    def test_tool_that_looks_at_nothing(self) -> None:
        """A cppcheck without addon: no file looked at, and none of the known faults found."""
        tool = self.write("cppcheck", "#!/bin/sh\nexit 0\n")
        tool.chmod(0o755)
        problems = self.problems(self.GOOD, cppcheck=str(tool))
        self.assertEqual(len(problems), 4, problems)
        self.assertIn("a file with known faults shows none against 10.4, 15.1, 21.15", problems[0])
        self.assertIn("src: a.c was not looked at", problems[1])

    def test_judge(self) -> None:
        """A mark answers its own rule in its own line; advisory rules need none; rows and marks belong together."""
        rows = {"EMA-D1": check_misra.Deviation("10.4", True), "EMA-D2": check_misra.Deviation("18.1", False)}
        place, other = check_misra.Line("src/a.c", 3), check_misra.Line("src/a.c", 9)
        marks = {place: {"EMA-D1"}, other: {"EMA-D2"}}
        found = {check_misra.Finding("src/a.c", 3, "10.4"), check_misra.Finding("src/a.c", 4, "15.5")}
        self.assertEqual(check_misra.judge(found, rows, marks), [])
        for rule, group in (("10.4", "required"), ("17.3", "mandatory"), ("99.9", "required")):
            unmarked = {check_misra.Finding("src/a.c", 9, rule)} | found
            self.assertIn(f"src/a.c:9: against the {group} rule {rule}", check_misra.judge(unmarked, rows, marks)[0])
        more = {place: {"EMA-D1"}, other: {"EMA-D2", "EMA-D3"}}
        self.assertIn("src/a.c:9: EMA-D3 is no deviation", check_misra.judge(found, rows, more)[0])
        fewer = {place: {"EMA-D1"}}
        self.assertEqual(check_misra.judge(found, rows, fewer), ["docs/MISRA.md: EMA-D2 is used nowhere any more: take its row out"])

    def test_marks(self) -> None:
        """A comment of its own is for the line below; lists are read as well."""
        self.write("src/base/a.c", "/* EMA-D1, EMA-D2 */\n#define A(x) x\nint b; /* EMA-D3 */\n")
        self.write("include/ema/a.def", "A(1) /* EMA-D1 */\n")
        marks = check_misra.read_marks(self.root)
        self.assertEqual(marks.pop(check_misra.Line("include/ema/a.def", 1)), {"EMA-D1"})
        self.assertEqual(marks.pop(check_misra.Line("src/base/a.c", 2)), {"EMA-D1", "EMA-D2"})
        self.assertEqual(marks, {check_misra.Line("src/base/a.c", 3): {"EMA-D3"}})

    def test_rows(self) -> None:
        """A row without its reason, one twice, and those for rules that can have none."""
        for text, message in (
            ("| EMA-D1 | 10.4 | addon | |\n", ":1: write"),
            (self.ROW + self.ROW, ":2: EMA-D1 stands there twice"),
            (self.ROW.replace("10.4", "17.3"), "17.3 is mandatory"),
            (self.ROW.replace("10.4", "15.5"), "15.5 is advisory"),
        ):
            with self.assertRaisesRegex(ValueError, message):
                check_misra.read_deviations(self.write("docs/MISRA.md", text))

    def test_tagless(self) -> None:
        """The rules on tags hold where there is one."""
        self.write("src/base/a.h", "enum {\nenum a {\n")
        findings = {check_misra.Finding("src/base/a.h", line, rule) for line in (1, 2) for rule in ("5.7", "10.4")}
        self.assertEqual(check_misra.without_tagless(self.root, findings), findings - {check_misra.Finding("src/base/a.h", 1, "5.7")})


class ClassNames(Tree):
    """check_class_names.py"""

    def test_each_name_once(self) -> None:
        """Both places are named, those inside another class too."""
        self.write("tools/ema_tools/fit/a.py", "class Fit:\n    class Step: ...\n")
        self.assertEqual(check_class_names.check(self.root), ([], 2))
        self.write("tools/ema_tools/select/b.py", "\nclass Step: ...\n")
        said = "tools/ema_tools/select/b.py:2: class Step stands at tools/ema_tools/fit/a.py:2, too: give one of them a name of its own"
        self.assertEqual(check_class_names.check(self.root), ([said], 3))


if __name__ == "__main__":
    unittest.main()
