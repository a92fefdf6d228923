"""Makes the Python environment of the build folder from lock files, or finds it ready and does nothing.

Called by the build with the machine's own Python, so it uses the standard library alone. The machine's own pip
configuration decides where packages come from. The machine's own pip installs them if it can, since a pip for the
environment costs seconds that nothing else needs.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.metadata
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

WHAT = {"run": "the tools", "fleet": "clusters", "test": "their tests", "check": "their checks", "package": "the packages' checks"}


def fingerprint(locks: list[Path], package: Path) -> str:
    """Hash of everything the environment is made from: what is locked, the interpreter, the place of the package."""
    parts = (*(lock.read_bytes() for lock in locks), sys.version.encode(), sys.executable.encode(), str(package).encode())
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def quiet_run(command: list[str], log: Path) -> bool:
    """Run a command with its output in a log file; True when it ended well."""
    hidden = ("PYTHONPATH", "PYTHONHOME", "PIP_USER", "PIP_TARGET", "PIP_PREFIX")
    environment = {name: value for name, value in os.environ.items() if name not in hidden}
    with log.open("ab") as out:
        return subprocess.run(command, stdout=out, stderr=subprocess.STDOUT, env=environment, check=False).returncode == 0


def last_error(log: Path) -> str:
    """The last line in which pip says what went wrong."""
    lines = [line.strip() for line in log.read_text(errors="replace").splitlines() if line.strip()]
    errors = [line for line in lines if line.startswith("ERROR:")]
    return (errors or lines or ["no output"])[-1].removeprefix("ERROR: ")


def pip_of(python: Path) -> list[str]:
    """The command of pip for the environment of `python`: its own, else the machine's."""
    if (python.parent / "pip").exists():
        return [str(python), "-I", "-m", "pip"]
    return [sys.executable, "-P", "-m", "pip", "--python", str(python)]


def machine_has_pip() -> bool:
    """Whether the machine's pip installs into other environments, which it does from version 22.3 on."""
    try:
        major, minor, *_ = importlib.metadata.version("pip").split(".")
        return (int(major), int(minor)) >= (22, 3)
    except (importlib.metadata.PackageNotFoundError, ValueError):
        return False


def link_package(venv_python: Path, package: Path) -> None:
    """Put the folder of the package on the path, relative, so that sources are used in place and the tree may move."""
    query = [str(venv_python), "-I", "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    site = Path(subprocess.run(query, capture_output=True, text=True, check=True).stdout.strip())
    (site / "ema_tools.pth").write_text(os.path.relpath(package, site) + "\n", encoding="utf-8")


def main() -> int:
    """Entry point; 0 when the environment stands."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--venv", type=Path, required=True)
    parser.add_argument("--lock", type=Path, required=True, action="append", help="file of packages; may be given several times")
    parser.add_argument(
        "--versions", type=Path, help="another lock, which has the versions of the packages that the others name without one"
    )
    parser.add_argument("--package", type=Path, required=True)
    parser.add_argument("--stamp", type=Path, required=True)
    parser.add_argument("--kind", choices=tuple(WHAT), required=True)
    arguments = parser.parse_args()
    venv: Path = arguments.venv
    python = venv / "bin" / "python"
    locks: list[Path] = arguments.lock
    wanted = fingerprint(locks if arguments.versions is None else [*locks, arguments.versions], arguments.package)
    stamp: Path = arguments.stamp

    if python.exists() and stamp.exists() and stamp.read_text(encoding="utf-8") == wanted:
        stamp.touch()
        return 0

    log = venv.parent / f"venv-{arguments.kind}.log"
    log.unlink(missing_ok=True)
    start = time.monotonic()
    lines = [line for lock in locks for line in lock.read_text(encoding="utf-8").splitlines()]
    count = sum(1 for line in lines if line and not line.startswith(("#", "-")))
    what = WHAT[arguments.kind]
    print(f"Python packages of {what}: installing {count} into {venv.name}, once ...", flush=True)
    if arguments.kind not in ("fleet", "test"):
        shutil.rmtree(venv, ignore_errors=True)
        # The checks of the packages build wheels, with the pip of their environment.
        without = ["--without-pip"] if arguments.kind != "package" and machine_has_pip() else []
        if not quiet_run([sys.executable, "-m", "venv", *without, str(venv)], log):
            print(
                f"error: no virtual environment could be made: {last_error(log)}: install the package python3-venv; details in {log}",
                file=sys.stderr,
            )
            return 1
    # The lock is complete, so pip need not resolve; wheels only, so a missing one is said at once.
    install = [*pip_of(python), "install", "--quiet", "--no-input", "--no-deps", "--no-compile", "--disable-pip-version-check"]
    install += ["--only-binary", ":all:"]
    for lock in locks:
        install += ["--requirement", str(lock)]
    if arguments.versions is not None:
        install += ["--constraint", str(arguments.versions)]
    if not quiet_run(install, log):
        print(
            f"error: {', '.join(lock.name for lock in locks)}: {last_error(log)}: check the network and pip's configuration,"
            f" then run the same command again; details in {log}",
            file=sys.stderr,
        )
        return 1
    # Checks read the sources where they lie, and those of the packages must not find them.
    if arguments.kind == "run":
        link_package(python, arguments.package)
    stamp.write_text(wanted, encoding="utf-8")
    print(f"Python packages of {what}: ready after {time.monotonic() - start:.0f} s", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
