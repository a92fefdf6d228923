"""The module as a package of Conan 2: `conan create .`."""

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy


class EmaRecipe(ConanFile):
    """Library in float32 and, where there is an operating system, in float64; CMake builds them."""

    name = "ema"
    version = "0.1.0"
    license = "MIT"
    description = "Onboard model of an electromechanical actuator and identification of its faults"
    topics = ("prognostics", "actuator", "embedded")
    package_type = "static-library"
    settings = "os", "arch", "compiler", "build_type"
    exports_sources = "CMakeLists.txt", "cmake/*", "include/*", "src/*", "LICENSE"

    def configure(self) -> None:
        """C has no C++ standard."""
        self.settings.rm_safe("compiler.cppstd")
        self.settings.rm_safe("compiler.libcxx")

    def layout(self) -> None:
        """Build folder beside the sources."""
        cmake_layout(self)

    def generate(self) -> None:
        """The library alone."""
        toolchain = CMakeToolchain(self)
        for option in ("EMA_TESTS", "EMA_HOST", "EMA_WERROR"):
            toolchain.cache_variables[option] = False
        toolchain.cache_variables["EMA_FLOAT64"] = self._has_float64()
        toolchain.generate()

    def build(self) -> None:
        """By CMake."""
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self) -> None:
        """What CMake installs, and the licence."""
        CMake(self).install()
        copy(self, "LICENSE", self.source_folder, f"{self.package_folder}/licenses")

    def package_info(self) -> None:
        """The targets that find_package(EMA) has elsewhere, too."""
        self.cpp_info.set_property("cmake_file_name", "EMA")
        single = self.cpp_info.components["ema"]
        single.set_property("cmake_target_name", "EMA::ema")
        single.libs = ["ema"]
        libraries = [single]
        if self._has_float64():
            double = self.cpp_info.components["ema64"]
            double.set_property("cmake_target_name", "EMA::ema64")
            double.libs = ["ema64"]
            double.defines = ["EMA_REAL64=1"]
            libraries.append(double)
        for library in libraries:
            if self.settings.os in ("Linux", "FreeBSD"):
                library.system_libs = ["m"]

    def _has_float64(self) -> bool:
        return self.settings.os != "baremetal"
