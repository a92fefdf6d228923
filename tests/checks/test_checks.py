"""Each check passes a good example, fails on each bad one with the line that names it, and fails on nothing."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import check_calls
import check_class_names
import check_compiles
import check_format
import check_layers
import check_misra
import check_python
import check_requirements
import check_symbols
import check_tidy
import check_units
import check_words
import stack  # check_calls has put its folder on the path

HERE = Path(__file__).parent
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
NM = shutil.which("nm")
CPPCHECK = shutil.which("cppcheck")
FORMATTER = check_format.clang_format()
PYTHON_TOOLS = not check_python.missing("mypy", "ruff")
TIDY = next((path for name in check_tidy.TIDIES if (path := shutil.which(name))), None)


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

    def exit_code(self, script: str, *arguments: str) -> int:
        """Run a check as ctest does."""
        command = [sys.executable, str(HERE / script), *arguments]
        return subprocess.run(command, capture_output=True, check=False).returncode


class Requirements(Tree):
    """check_requirements.py"""

    def setUp(self) -> None:
        super().setUp()
        self.write(
            "include/ema/ema_a.h",
            "#ifndef A\nvoid ema_a(int x);\nconst char* ema_b(int x);\nstatic inline int ema_c(int x)\n{\n    return x;\n}\n#endif\n",
        )
        self.write("tests/unit/test_a.c", "int main(void)\n{\n    RUN_TEST(test_first);\n    RUN_TEST(second);\n    return 0;\n}\n")
        self.write("tests/CMakeLists.txt", "add_test(NAME whole COMMAND x)\n")

    def problems(self, *rows: str) -> str:
        """What is said of a page with these rows."""
        self.write(
            "docs/REQUIREMENTS.md",
            "| id | requirement | functions | tests |\n|---|---|---|---|\n" + "".join(f"| {row} |\n" for row in rows),
        )
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

    def test_nothing(self) -> None:
        self.assertEqual(self.exit_code("check_requirements.py", "--root", str(self.root)), 1)


class Layers(Tree):
    """check_layers.py"""

    def setUp(self) -> None:
        super().setUp()
        self.write("include/ema/ema_real.h", "typedef float ema_real;\n")
        self.write("include/ema/ema_model.h", '#include "ema/ema_real.h"\n')
        self.write("include/ema/ema_search.h", '#include "ema/ema_real.h"\n')
        self.write("src/base/ema_math.h", '#include <math.h>\n#include "ema/ema_real.h"\n')
        self.write("src/blocks/ema_motor.h", '#include "base/ema_math.h"\n')
        self.write("src/plant/ema_model.c", '#include "blocks/ema_motor.h"\n#include "ema/ema_model.h"\n#include <string.h>\n')
        self.write("src/search/ema_search.c", '#include "base/ema_math.h"\n#include "ema/ema_search.h"\n')
        self.write("src/ident/ema_ident.c", '#include "ema/ema_model.h"\n#include "ema/ema_search.h"\n')
        self.write("port/host/main.c", '#include <stdio.h>\n#include "ema/ema_model.h"\n#include "csv.h"\n')
        self.write("port/host/csv.h", "")

    def problem(self) -> str:
        """The one problem there is."""
        problems, _ = check_layers.check(self.root)
        self.assertEqual(len(problems), 1, problems)
        return problems[0]

    def test_good(self) -> None:
        """The rule as it is meant."""
        self.assertEqual(check_layers.check(self.root), ([], 12))
        self.assertEqual(self.exit_code("check_layers.py", "--root", str(self.root)), 0)

    def test_upward(self) -> None:
        """A block that includes the plant's header."""
        self.write("src/blocks/ema_pid.c", '#include "ema/ema_model.h"\n')
        self.assertIn("src/blocks/ema_pid.c: level blocks sees ema_model.h of level plant", self.problem())
        self.assertEqual(self.exit_code("check_layers.py", "--root", str(self.root)), 1)

    def test_upward_through_another_header(self) -> None:
        """The same behind a header that has no level of its own."""
        self.write("include/ema/ema_all.h", '#include "ema/ema_model.h"\n')
        self.write("src/effects/ema_friction.c", '#include "ema/ema_all.h"\n')
        self.assertIn("level effects sees ema_model.h of level plant", self.problem())

    def test_circle(self) -> None:
        """Two files of one level that include each other's headers, one of them by way of a third."""
        self.write("src/blocks/ema_gear.h", '#include "ema_wheel.h"\n')
        self.write("src/blocks/ema_wheel.h", "")
        self.write("src/blocks/ema_wheel.c", '#include "ema_wheel.h"\n#include "ema_tooth.h"\n')
        self.write("src/blocks/ema_tooth.h", '#include "ema_gear.h"\n')
        self.assertIn("ema_gear -> ema_wheel -> ema_tooth -> ema_gear: a circle", self.problem())

    def test_search_knows_no_actuator(self) -> None:
        """Search depends on base alone."""
        self.write("src/search/ema_anneal.c", '#include "blocks/ema_motor.h"\n')
        self.assertIn("level search sees ema_motor.h of level blocks", self.problem())

    def test_port_from_module(self) -> None:
        """Nothing in src knows a port."""
        self.write("src/base/ema_io.c", '#include "csv.h"\n')
        self.assertIn("src/base/ema_io.c:1: the module includes port/host", self.problem())

    def test_private_header_from_port(self) -> None:
        """A port uses public headers."""
        self.write("port/host/blocks.c", '\n#include "blocks/ema_motor.h"\n')
        self.assertIn("port/host/blocks.c:2: a port includes the private header blocks/ema_motor.h", self.problem())

    def test_the_desk_shows_blocks(self) -> None:
        """The desk sees the blocks, and nothing above them."""
        self.write("port/desk/desk.c", '#include "blocks/ema_motor.h"\n')
        self.assertEqual(check_layers.check(self.root), ([], 13))
        self.write("src/plant/ema_inner.h", "")
        self.write("port/desk/inner.c", '#include "plant/ema_inner.h"\n')
        self.assertIn("port/desk/inner.c:1: a port includes the private header plant/ema_inner.h", self.problem())

    def test_private_header_from_public(self) -> None:
        """A public header stands on public headers."""
        self.write("include/ema/ema_extra.h", '#include "base/ema_math.h"\n')
        self.assertIn("a public header includes src/base", self.problem())

    def test_system_header(self) -> None:
        """stdio in the module, and the square root outside its header."""
        self.write("src/base/ema_log.c", "#include <stdio.h>\n")
        self.assertIn("src/base/ema_log.c:1: <stdio.h> is not for the module", self.problem())
        self.write("src/base/ema_log.c", "#include <math.h>\n")
        self.assertIn("<math.h>", self.problem())

    def test_unknown_header_and_level(self) -> None:
        """A name that resolves nowhere, and a folder that the rule does not know."""
        self.write("src/base/ema_odd.c", '#include "nowhere.h"\n')
        self.assertIn("src/base/ema_odd.c:1: nowhere.h is no header of the project", self.problem())
        (self.root / "src/base/ema_odd.c").unlink()
        self.write("src/extra/ema_odd.c", "")
        self.assertIn("src has no level extra", self.problem())

    def test_comment_is_no_include(self) -> None:
        """An include in a comment counts for nothing."""
        self.write("src/base/ema_note.c", '/*\n#include "ema/ema_model.h"\n*/\n')
        self.assertEqual(check_layers.check(self.root), ([], 12))

    def test_nothing(self) -> None:
        """An empty project fails."""
        self.assertEqual(self.exit_code("check_layers.py", "--root", str(self.root / "include")), 1)


class Words(Tree):
    """check_words.py"""

    def module(self, text: str) -> list[str]:
        """Problems of one file of the module."""
        self.write("src/base/ema_x.c", text)
        return check_words.check_module(self.root)[0]

    def test_good(self) -> None:
        """Comments, strings, fields, names of files and the float64 branch may hold any word."""
        text = (
            '#include <time.h>\n/* malloc, double */ // printf\nconst char* t = "exp(x) on time";\n'
            "#if EMA_REAL64\ntypedef double ema_real;\n#else\ntypedef float ema_real;\n#endif\n"
            "int f(const ema_s* s) { return s->time + s->log.exp + ema_exp(timer); }\n"
        )
        self.assertEqual(self.module(text), [])
        self.assertEqual(self.exit_code("check_words.py", "--root", str(self.root)), 0)

    def test_every_word(self) -> None:
        """Each word of the list is found, with its line."""
        for words in check_words.MODULE_WORDS:
            for word in words.split():
                problems = self.module(f"\nint y = {word}(x);\n")
                self.assertEqual(len(problems), 1, word)
                self.assertTrue(problems[0].startswith(f"src/base/ema_x.c:2: `{word}`"), problems[0])
        self.assertEqual(self.exit_code("check_words.py", "--root", str(self.root)), 1)

    def test_compiler_header(self) -> None:
        """One header may use an attribute, no other extension."""
        self.write("src/base/ema_compiler.h", "#define EMA_NOINLINE __attribute__((noinline))\n")
        self.assertEqual(self.module("int x;\n"), [])
        self.write("src/base/ema_compiler.h", "__asm__(x);\n")
        self.assertEqual(len(self.module("int x;\n")), 1)

    def test_float32_branch(self) -> None:
        """The branch that the float32 build sees, and what follows it, is read."""
        self.assertEqual(len(self.module("#if EMA_REAL64\n#else\ndouble x;\n#endif\n")), 1)
        self.assertEqual(len(self.module("#if EMA_REAL64\n#endif\ndouble x;\n")), 1)

    def test_tree(self) -> None:
        """Notes to oneself and paths of one machine, in any text file, but not in the build folder."""
        self.write("docs/a.md", "fine\nTODO later\n")
        self.write("tools/a.py", "x = '/" + "work/main'\n")
        self.write("build/a.py", "x = '/" + "work/main'\n")
        problems = check_words.check_tree(self.root)
        self.assertEqual([problem.split(": ")[0] for problem in problems], ["docs/a.md:2", "tools/a.py:1"])

    def test_nothing(self) -> None:
        """An empty project fails."""
        self.assertEqual(self.exit_code("check_words.py", "--root", str(self.root)), 1)


class Symbols(Tree):
    """check_symbols.py, on objects really compiled."""

    def library(self, text: str) -> Path:
        """A static library of one file."""
        source = self.write("x.c", text)
        unit, library = self.root / "x.o", self.root / "libx.a"
        library.unlink(missing_ok=True)
        subprocess.run([str(COMPILER), "-std=c11", "-O2", "-fno-builtin", "-c", str(source), "-o", str(unit)], check=True)
        subprocess.run(["ar", "rc", str(library), str(unit)], check=True)
        return library

    def verdict(self, text: str) -> tuple[int, str]:
        """Exit code and output of the check."""
        command = [sys.executable, str(HERE / "check_symbols.py"), "--nm", str(NM), str(self.library(text))]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        return run.returncode, run.stdout + run.stderr

    @unittest.skipUnless(COMPILER and NM and sys.platform == "linux", "needs a compiler and nm")
    def test_examples(self) -> None:
        """Good code passes; a library call, a global and a hidden static fail, each by name."""
        good = (
            'void* memcpy(void*, const void*, unsigned long);\nstatic const char* const names[2] = {"a", "b"};\n'
            "const char* f(int i, int* p) { memcpy(p, &i, sizeof i); return names[i]; }\n"
        )
        self.assertEqual(self.verdict(good)[0], 0, self.verdict(good)[1])
        bad = {
            "void* malloc(unsigned long); void* f(void) { return malloc(3); }": "needs malloc",
            "double exp(double); double f(double x) { return exp(x); }": "needs exp",
            "float sqrtf(float); float f(float x) { return sqrtf(x); }": "needs sqrtf",
            "int counter; int f(void) { return counter++; }": "counter lies in .bss",
            "int level = 3; int f(void) { return level++; }": "level lies in .data",
            "int f(void) { static int calls; return calls++; }": "lies in .bss",
        }
        for text, expected in bad.items():
            code, output = self.verdict(text)
            self.assertEqual(code, 1, text)
            self.assertIn(expected, output)

    @unittest.skipUnless(COMPILER and NM and sys.platform == "linux", "needs a compiler and nm")
    def test_nothing(self) -> None:
        """A library without functions, and one that is not there."""
        self.assertEqual(self.verdict("extern int x;\n")[0], 1)
        self.assertEqual(self.exit_code("check_symbols.py", "--nm", str(NM), str(self.root / "none.a")), 1)

    def test_problem_names_the_object(self) -> None:
        """The message carries the member of the library."""
        table = "Symbols from libema.a[ema_pid.c.o]:\n\nema_pid |0000| T | FUNC|0010| |.text\npow | | U | NOTYPE| | |*UND*\n"
        self.assertEqual(
            check_symbols.check_table(table, "libema.a"), (["libema.a(ema_pid.c.o): needs pow: keep it out of src, or inline it"], 1)
        )


class Calls(Tree):
    """check_calls.py, on sources really compiled."""

    GOOD = "int b(int i);\nint a(int i);\nstatic int one(int i) { return i + 1; }\nint a(int i) { return b(one(i)); }\n"

    def setUp(self) -> None:
        super().setUp()
        self.write("src/base/b.c", "int b(int i);\nint b(int i) { return 2 * i; }\n")
        self.write("src/base/a.c", self.GOOD)

    def verdict(self, extra: str = "") -> tuple[int, str]:
        """Exit code and output of the check; `extra` stands in the library alone."""
        library = self.root / "liba.a"
        library.unlink(missing_ok=True)
        self.write("other/c.c", f"extern int none;\n{extra}")
        sources = [str(path) for path in (*(self.root / "src").rglob("*.c"), self.root / "other/c.c")]
        subprocess.run([str(COMPILER), "-std=c11", "-O2", "-c", *sources], cwd=self.root, check=True)
        subprocess.run(["ar", "rc", str(library), *(f"{Path(name).stem}.o" for name in sources)], cwd=self.root, check=True)
        command = [
            sys.executable,
            str(HERE / "check_calls.py"),
            "--root",
            str(self.root),
            "--compiler",
            str(COMPILER),
            "--nm",
            str(NM),
            str(library),
            str(library),
        ]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        return run.returncode, run.stdout + run.stderr

    @unittest.skipUnless(COMPILER and NM and sys.platform == "linux" and check_calls.has_graph(str(COMPILER)), "needs gcc and nm")
    def test_examples(self) -> None:
        """Good code passes; each forbidden thing fails and is named, a recursion also where an optimised build makes a loop of it."""
        self.assertEqual(self.verdict()[0], 0, self.verdict()[1])
        self.assertIn("calls: 6 functions, 0 wrong", self.verdict()[1])
        bad = {
            "int sum(int i, int s); int sum(int i, int s) { return i == 0 ? s : sum(i - 1, s + i); }": "sum -> sum: recursion",
            "int a(int i); int b(int i); int c(int i); int c(int i) { return i > 0 ? b(i) : 0; }": "b -> c -> b: recursion",
            "int e(int (*f)(int)); int e(int (*f)(int)) { return f(3); }": "e: calls through a pointer",
            "void g(char*); int e(int n); int e(int n) { char x[n]; x[0] = 1; return x[n - 1]; }": "a frame of unknown size",
            "double exp(double); double e(double x); double e(double x) { return exp(x); }": "e: calls exp",
            "void* malloc(unsigned long); void* e(void); void* e(void) { return malloc(8); }": "e: calls malloc",
        }
        for text, expected in bad.items():
            self.write("src/base/d.c", text)
            self.write(
                "src/base/b.c",
                "int b(int i);\nint c(int i);\nint b(int i) { return " + ("c(i - 1)" if "int c(" in text else "2 * i") + "; }\n",
            )
            code, output = self.verdict()
            self.assertEqual(code, 1, text)
            self.assertIn(expected, output)

    @unittest.skipUnless(COMPILER and NM and sys.platform == "linux" and check_calls.has_graph(str(COMPILER)), "needs gcc and nm")
    def test_nothing(self) -> None:
        """A graph without a function of the library, no sources, and a library without functions."""
        code, output = self.verdict("int lost(int i);\nint lost(int i) { return i; }\n")
        self.assertEqual(code, 1)
        self.assertIn("lost: the library defines it, the call graph does not hold it", output)
        shutil.rmtree(self.root / "src")
        self.assertIn("liba.a defines no function", self.verdict()[1])
        self.assertIn("a: the library defines it", "".join(check_calls.check_graph(stack.Graph(), {"a"})))

    def test_cycles(self) -> None:
        """Two rings in one graph, and none in a graph whose paths meet again."""
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
        found = self.problems()
        self.assertEqual(len(found), 2)
        self.assertTrue(all("`rad_s` is only the last part" in one for one in found))

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
            self.assertEqual(len(self.problems()), 1, field)
            self.assertTrue(self.problems()[0].startswith(f"include/ema/ema_b.h:3: `{name}` has no unit"), self.problems()[0])

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

    def test_nothing(self) -> None:
        """An empty project fails."""
        self.assertEqual(self.exit_code("check_units.py", "--root", str(self.root / "none"), "--names", str(self.names)), 1)


class Compiles(Tree):
    """check_compiles.py"""

    @unittest.skipUnless(COMPILER, "needs a compiler")
    def test_headers(self) -> None:
        """A header that leans on another one, and one without a guard."""
        good = "#ifndef A_H\n#define A_H\n#include <stdint.h>\ntypedef struct { uint32_t n; } a_t;\n#endif\n"
        self.write("include/ema/a.h", good)
        self.assertEqual(check_compiles.check_headers(self.root, str(COMPILER)), ([], 1))
        self.write("include/ema/b.h", "#ifndef B_H\n#define B_H\nuint32_t b(void);\n#endif\n")
        problems, count = check_compiles.check_headers(self.root, str(COMPILER))
        self.assertEqual((len(problems), count), (2, 2))
        self.assertIn("include/ema/b.h alone, EMA_REAL64=0", problems[0])
        self.write("include/ema/b.h", "typedef struct { int n; } b_t;\n")
        self.assertEqual(len(check_compiles.check_headers(self.root, str(COMPILER))[0]), 2)

    @unittest.skipUnless(any(shutil.which(name) for name in check_compiles.CLANGS), "needs clang")
    def test_clang(self) -> None:
        """A conversion of double to float that gcc lets pass without its own flag."""
        clang = next(name for name in check_compiles.CLANGS if shutil.which(name))
        self.write("src/base/a.c", "float a(float x);\nfloat a(float x) { return x * 0.5f; }\n")
        self.assertEqual(check_compiles.check_clang(self.root, clang), ([], 1))
        self.write("src/base/a.c", "float a(double x);\nfloat a(double x) { return x; }\n")
        self.assertEqual(len(check_compiles.check_clang(self.root, clang)[0]), 2)
        self.write("src/base/a.c", "double a(float x);\ndouble a(float x) { return x; }\n")
        self.assertEqual(len(check_compiles.check_clang(self.root, clang)[0]), 2)

    def snippets(self, **texts: str) -> list[str]:
        """Problems of documents that must show C, by name."""
        for name, text in texts.items():
            self.write(f"docs/{name}.md", text)
        return check_compiles.check_snippets(self.root, str(COMPILER), [], tuple(f"docs/{name}.md" for name in texts))[0]

    @unittest.skipUnless(COMPILER, "needs a compiler")
    def test_snippets(self) -> None:
        """A block that no longer compiles, one that was lost, and one that no document must have."""
        self.write("include/ema/ema_effects.def", "")
        self.write("include/ema/a.h", "#include <stdint.h>\nint32_t a(int32_t n);\n")
        self.write("README.md", "no C\n")
        good = 'Text.\n\n```c\n#include "ema/a.h"\nint32_t b(void);\nint32_t b(void)\n{\n    return a(1);\n}\n```\n'
        self.assertEqual(self.snippets(page=good), [])
        for bad in (
            good.replace("a(1)", "a(1, 2)"),
            good.replace("a(1)", "c(1)"),
            good.replace("ema/a.h", "ema/c.h"),
            good.replace("a(1);", "a(1)"),
        ):
            problems = self.snippets(page=bad)
            self.assertEqual(len(problems), 2)
            self.assertRegex(problems[0], r"^docs/page\.md, EMA_REAL64=0: docs/page\.md:[4-9]")
        self.assertIn("no block of C", self.snippets(page=good.replace("```c", "```"))[0])
        self.assertEqual(len(self.snippets(page=good + "\n```C\nint;;\n```\n")), 2)
        (self.root / "docs/page.md").unlink()
        self.assertIn("not there", check_compiles.check_snippets(self.root, str(COMPILER), [], ("docs/page.md",))[0][0])
        self.write("docs/other.md", good.replace("a(1)", "c(1)"))
        self.assertEqual(len(check_compiles.check_snippets(self.root, str(COMPILER), [], ())[0]), 2)

    @unittest.skipUnless(COMPILER, "needs a compiler")
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

    def test_nothing(self) -> None:
        """An empty project fails."""
        self.assertEqual(self.exit_code("check_compiles.py", "headers", "--root", str(self.root)), 1)


class Misra(Tree):
    """check_misra.py"""

    ROW = "| EMA-D1 | 10.4 | addon | Said so. |\n"
    GOOD = "#include <stdint.h>\nuint16_t a(uint16_t x);\nuint16_t a(uint16_t x)\n{\n    return (x > 1U) ? x : 2U;\n}\n"
    FAULT = GOOD.replace("1U", "1")

    def problems(self, cppcheck: str) -> list[str]:
        """Problems of the tree."""
        problems, checked, _ = check_misra.check(self.root, cppcheck, 1)
        self.assertEqual(checked, 1)
        return problems

    @unittest.skipUnless(CPPCHECK, "needs cppcheck")
    def test_finding_and_mark(self) -> None:
        """A fault in the source is seen, a mark with a row answers it, and without the fault the mark is too much."""
        self.write("docs/MISRA.md", "")
        self.write("src/base/a.c", self.FAULT)
        self.assertEqual(
            self.problems(str(CPPCHECK)),
            ["src/base/a.c:5: against the required rule 10.4: mend it, or mark it with a deviation of docs/MISRA.md"],
        )
        self.write("docs/MISRA.md", self.ROW)
        self.write("src/base/a.c", self.FAULT.replace("2U;", "2U; /* EMA-D1 */"))
        self.assertEqual(self.problems(str(CPPCHECK)), [])
        self.write("src/base/a.c", self.GOOD.replace("2U;", "2U; /* EMA-D1 */"))
        self.assertEqual(
            self.problems(str(CPPCHECK)), ["src/base/a.c:5: nothing is found against rule 10.4 any more: take the mark EMA-D1 off"]
        )

    @unittest.skipUnless(CPPCHECK, "needs cppcheck")
    def test_source_that_is_no_c(self) -> None:
        """What the tool cannot read is not clean."""
        self.write("docs/MISRA.md", "")
        self.write("src/base/a.c", "int a(void)\n{\n    return (;\n}\n")
        self.assertIn("src/base/a.c:3: syntaxError", self.problems(str(CPPCHECK))[0].replace(str(self.root) + "/", ""))

    def test_tool_that_looks_at_nothing(self) -> None:
        """A cppcheck without addon: no file looked at, and none of the known faults found."""
        self.write("docs/MISRA.md", "")
        self.write("src/base/a.c", self.GOOD)
        tool = self.write("cppcheck", "#!/bin/sh\nexit 0\n")
        tool.chmod(0o755)
        problems = self.problems(str(tool))
        self.assertEqual(len(problems), 4, problems)
        self.assertIn("a file with known faults shows none against 10.4, 15.1, 21.15", problems[0])
        self.assertIn("src: a.c was not looked at", problems[1])

    def test_judge(self) -> None:
        """A mark answers its own rule in its own line; advisory rules need none; rows and marks belong together."""
        rows = {"EMA-D1": check_misra.Deviation("10.4", True), "EMA-D2": check_misra.Deviation("18.1", False)}
        place, other = check_misra.Line("src/a.c", 3), check_misra.Line("src/a.c", 9)
        found = {check_misra.Finding("src/a.c", 3, "10.4"), check_misra.Finding("src/a.c", 4, "15.5")}
        self.assertEqual(check_misra.judge(found, rows, {place: {"EMA-D1"}, other: {"EMA-D2"}}), [])
        for rule, group in (("10.4", "required"), ("17.3", "mandatory"), ("99.9", "required")):
            self.assertIn(
                f"src/a.c:9: against the {group} rule {rule}",
                check_misra.judge({check_misra.Finding("src/a.c", 9, rule)} | found, rows, {place: {"EMA-D1"}, other: {"EMA-D2"}})[0],
            )
        self.assertIn(
            "src/a.c:9: EMA-D3 is no deviation", check_misra.judge(found, rows, {place: {"EMA-D1"}, other: {"EMA-D2", "EMA-D3"}})[0]
        )
        self.assertEqual(
            check_misra.judge(found, rows, {place: {"EMA-D1"}}), ["docs/MISRA.md: EMA-D2 is used nowhere any more: take its row out"]
        )

    def test_marks(self) -> None:
        """A comment of its own is for the line below; lists are read as well."""
        self.write("src/base/a.c", "/* EMA-D1, EMA-D2 */\n#define A(x) x\nint b; /* EMA-D3 */\n")
        self.write("include/ema/a.def", "A(1) /* EMA-D1 */\n")
        self.assertEqual(
            check_misra.read_marks(self.root),
            {
                check_misra.Line("include/ema/a.def", 1): {"EMA-D1"},
                check_misra.Line("src/base/a.c", 2): {"EMA-D1", "EMA-D2"},
                check_misra.Line("src/base/a.c", 3): {"EMA-D3"},
            },
        )

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

    @unittest.skipUnless(CPPCHECK, "needs cppcheck")
    def test_nothing(self) -> None:
        """An empty project fails."""
        self.assertEqual(self.exit_code("check_misra.py", "--root", str(self.root)), 1)


class Tidy(Tree):
    """check_tidy.py"""

    FILE = "int a(int x);\nint a(int x)\n{\n    return x + 1;\n}\n"

    def setUp(self) -> None:
        super().setUp()
        shutil.copy(HERE.parents[1] / ".clang-tidy", self.root)
        self.source = self.write("src/base/a.c", self.FILE)
        self.commands(self.source, self.source)

    def commands(self, *files: Path) -> None:
        """The list that CMake writes."""
        self.write(
            "build/compile_commands.json",
            json.dumps([{"directory": str(self.root), "file": str(file), "command": f"cc -std=c11 -c {file}"} for file in files]),
        )

    def problems(self) -> list[str]:
        """Problems of the tree."""
        problems, checked = check_tidy.check(self.root, self.root / "build", str(TIDY), 1)
        self.assertEqual(checked, 1)
        return problems

    @unittest.skipUnless(TIDY, "needs clang-tidy")
    def test_finding(self) -> None:
        """A clean file, a suspicious one, and one that is no C."""
        self.assertEqual(self.problems(), [])
        self.write("src/base/a.c", self.FILE.replace("x + 1", "sizeof(sizeof(x)) == 4U"))
        self.assertIn("src/base/a.c:4: suspicious usage of 'sizeof(sizeof(...))'", self.problems()[0])
        self.write("src/base/a.c", self.FILE.replace("x + 1", "x + y"))
        self.assertIn("src/base/a.c:4: use of undeclared identifier 'y'", self.problems()[0])

    @unittest.skipUnless(TIDY, "needs clang-tidy")
    def test_checks_that_see_nothing(self) -> None:
        """Settings that switch everything off are no clean bill."""
        self.write(".clang-tidy", "Checks: '-*,misc-static-assert'\n")
        self.assertIn("finds nothing in a file with a known fault", self.problems()[0])

    @unittest.skipUnless(TIDY, "needs clang-tidy")
    def test_file_that_is_not_built(self) -> None:
        """A file without the compile commands of both precisions."""
        self.commands(self.source)
        self.assertIn("src/base/a.c: 1 compile commands in", self.problems()[0])
        (self.root / "build/compile_commands.json").unlink()
        self.assertEqual(self.exit_code("check_tidy.py", "--root", str(self.root), "--build", str(self.root / "build")), 1)

    @unittest.skipUnless(TIDY, "needs clang-tidy")
    def test_nothing(self) -> None:
        """An empty project fails."""
        self.source.unlink()
        self.assertEqual(self.exit_code("check_tidy.py", "--root", str(self.root), "--build", str(self.root / "build")), 1)


class Python(Tree):
    """check_python.py"""

    FILE = "def ema_a(count: int) -> int:\n    return count + 1\n"

    def setUp(self) -> None:
        super().setUp()
        self.write("tools/pyproject.toml", "[tool.mypy]\nstrict = true\n\n[tool.ruff]\nline-length = 100\n")
        self.write("tools/ema_tools/__init__.py", "")
        self.source = self.write("tools/ema_tools/a.py", self.FILE)

    def problems(self) -> list[str]:
        """Problems of the tree."""
        return check_python.check(self.root, self.root / "build/mypy")[0]

    @unittest.skipUnless(PYTHON_TOOLS, "needs mypy and ruff")
    def test_finding(self) -> None:
        """Clean files, those with a fault that one of the tools sees, and one that is no Python."""
        self.write("cmake/b.py", "print(1)\n")
        self.write("tools/tests/test_a.py", "def test_a():\n    assert True\n")
        self.assertEqual(check_python.check(self.root, self.root / "build/mypy"), ([], 4))
        self.write("tools/ema_tools/a.py", self.FILE.replace("count + 1", "str(count)"))
        self.write("cmake/b.py", "def b(count):\n    return count\n")
        self.write("tools/tests/test_a.py", "import os\n")
        found = self.problems()
        self.assertEqual([one.split(" ")[0] for one in found], ["tools/tests/test_a.py:1:", "cmake/b.py:1:", "tools/ema_tools/a.py:2:"])
        for one, rule in zip(found, ("F401", "[no-untyped-def]", "[return-value]"), strict=True):
            self.assertIn(rule, one)
        self.write("tools/ema_tools/a.py", "def\n")
        self.assertIn("tools/ema_tools/a.py:1: ", self.problems()[0])

    @unittest.skipUnless(PYTHON_TOOLS, "needs mypy and ruff")
    def test_settings_that_see_nothing(self) -> None:
        """Settings that switch everything off are no clean bill, and what is left out is counted."""
        self.write("tools/pyproject.toml", "[tool.mypy]\nignore_errors = true\n\n[tool.ruff.lint]\nselect = ['W605']\n")
        found = self.problems()
        self.assertEqual([one.split(":")[0] for one in found], ["ruff", "mypy"])
        self.assertTrue(all("finds nothing in a file with a known fault" in one for one in found))
        self.write("tools/pyproject.toml", "[tool.mypy]\nno_such_setting\n")
        self.assertIn("ruff failed", self.problems()[0])

    def test_no_tool(self) -> None:
        """A tool that is not there is named."""
        self.assertEqual(check_python.missing("json", "no_such_tool"), ["no_such_tool"])

    def test_nothing(self) -> None:
        """An empty project fails."""
        self.source.unlink()
        (self.root / "tools/ema_tools/__init__.py").unlink()
        self.assertEqual(check_python.check(self.root, self.root / "build/mypy"), ([], 0))
        self.assertEqual(self.exit_code("check_python.py", "--root", str(self.root), "--build", str(self.root / "build")), 1)


@unittest.skipUnless(FORMATTER and PYTHON_TOOLS, "needs clang-format and ruff in its environment")
class Format(Tree):
    """check_format.py"""

    def setUp(self) -> None:
        super().setUp()
        self.write(".clang-format", "BasedOnStyle: LLVM\n")
        self.write("tools/pyproject.toml", "[tool.ruff]\nline-length = 100\n")
        self.write("tools/ema_tools/a.py", "a = 1\n")
        self.write("src/base/ema_a.c", "int ema_a(void);\n")
        self.write("port/cortex_m/example/ace_signatures.h", "int   as_written ;\n")

    def problems(self) -> list[str]:
        """Problems of the tree."""
        return check_format.check(self.root, str(FORMATTER))[0]

    def test_finding(self) -> None:
        """Files as the formatters leave them, and one of each kind that they would change."""
        self.assertEqual(check_format.check(self.root, str(FORMATTER)), ([], 2))
        self.write("src/base/ema_a.c", "int ema_a(void);\nint  ema_b(void);\n")
        self.write("tools/tests/test_a.py", "a = [1,2]\n")
        found = self.problems()
        self.assertEqual([one.split(" ")[0] for one in found], ["src/base/ema_a.c:2:", "tools/tests/test_a.py:"])

    def test_settings_that_see_nothing(self) -> None:
        """Settings that switch everything off are no clean bill."""
        self.write(".clang-format", "DisableFormat: true\n")
        self.write("tools/pyproject.toml", "[tool.ruff]\nline-length = 0\n")
        found = self.problems()
        self.assertEqual([one.split(":")[0] for one in found], ["clang-format", "ruff format"])
        self.assertTrue(all("finds nothing in a file with a known fault" in one for one in found))

    def test_nothing(self) -> None:
        """An empty project fails."""
        (self.root / "src/base/ema_a.c").unlink()
        self.assertEqual(check_format.check(self.root, str(FORMATTER)), ([], 0))
        self.assertEqual(self.exit_code("check_format.py", "--root", str(self.root)), 1)


class ClassNames(Tree):
    """check_class_names.py"""

    def setUp(self) -> None:
        super().setUp()
        self.write("tools/ema_tools/fit/a.py", "class Fit:\n    class Step: ...\n")

    def test_good(self) -> None:
        """Each name once."""
        self.assertEqual(check_class_names.check(self.root), ([], 2))
        self.assertEqual(self.exit_code("check_class_names.py", "--root", str(self.root)), 0)

    def test_twice(self) -> None:
        """Both places are named, those inside another class too."""
        self.write("tools/ema_tools/select/b.py", "\nclass Step: ...\n")
        problems, _ = check_class_names.check(self.root)
        self.assertEqual(
            problems,
            ["tools/ema_tools/select/b.py:2: class Step stands at tools/ema_tools/fit/a.py:2, too: give one of them a name of its own"],
        )
        self.assertEqual(self.exit_code("check_class_names.py", "--root", str(self.root)), 1)

    def test_nothing(self) -> None:
        """An empty project fails."""
        self.assertEqual(self.exit_code("check_class_names.py", "--root", str(self.root / "none")), 1)


if __name__ == "__main__":
    unittest.main()
