"""A project that takes the package from Conan."""

from conan import ConanFile
from conan.tools.cmake import CMake, cmake_layout


class Outside(ConanFile):
    """Builds the outside project, and runs it."""

    settings = "os", "arch", "compiler", "build_type"
    generators = "CMakeDeps", "CMakeToolchain"

    def requirements(self) -> None:
        """The package under test."""
        self.requires(self.tested_reference_str)

    def layout(self) -> None:
        """Build folder beside the sources."""
        cmake_layout(self)

    def build(self) -> None:
        """By CMake."""
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def test(self) -> None:
        """What it prints is compared by who runs this."""
        self.run(f"{self.cpp.build.bindir}/outside", env="conanrun")
