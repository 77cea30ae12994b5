"""conan create cmake/packaging/conan: the headers of the repository that this file lies in, and with -o "fuse-flow/*:recordings=True" or
-o "fuse-flow/*:compiled=True" these libraries."""

import os
import re

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load

required_conan_version = ">=2.0"


class FuseFlowConan(ConanFile):
    name = "fuse-flow"
    license = "BSD-3-Clause"
    description = "Fuses the depth images of several calibrated cameras into one point cloud, frame by frame"
    topics = ("point-cloud", "depth-camera", "pcl", "3d-reconstruction")
    package_type = "static-library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"recordings": [True, False], "compiled": [True, False], "fPIC": [True, False]}
    default_options = {"recordings": False, "compiled": False, "fPIC": True}

    @property
    def _root(self):
        return os.path.normpath(os.path.join(self.recipe_folder, "..", "..", ".."))

    def set_version(self):
        text = load(self, os.path.join(self._root, "CMakeLists.txt"))
        self.version = re.search(r"project\(FuseFlow VERSION ([0-9.]+)", text).group(1)

    def export_sources(self):
        for folder in ("apps", "cmake", "distributed", "gpu", "impl", "include", "src"):
            copy(self, "*", os.path.join(self._root, folder), os.path.join(self.export_sources_folder, folder))
        for file in ("CMakeLists.txt", "LICENSE", "CHANGELOG.md"):
            copy(self, file, self._root, self.export_sources_folder)

    def requirements(self):
        self.requires("pcl/[>=1.12 <2]", transitive_headers=True, transitive_libs=True)
        self.requires("eigen/[>=3.4 <4]", transitive_headers=True)
        self.requires("flann/[>=1.9 <2]", transitive_headers=True)
        if self.options.recordings:
            for library in ("vtk/[>=9 <10]", "libjpeg/[>=9]", "libpng/[>=1.6 <2]", "libtiff/[>=4 <5]", "zlib/[>=1.2.11 <2]",
                            "yaml-cpp/[>=0.7]", "nlohmann_json/[>=3 <4]"):
                self.requires(library)

    def package_id(self):
        if not self.options.recordings and not self.options.compiled:
            self.info.clear()  # headers alone: one package for all compilers

    def validate(self):
        check_min_cppstd(self, 17)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        for part in ("APPS", "TESTS", "GPU_TESTS", "BENCH"):
            toolchain.cache_variables[f"FUSE_FLOW_BUILD_{part}"] = False
        toolchain.cache_variables["FUSE_FLOW_BUILD_RECORDINGS"] = bool(self.options.recordings)
        toolchain.cache_variables["FUSE_FLOW_BUILD_COMPILED"] = bool(self.options.compiled)
        for part in ("PYTHON", "CUDA", "MPI"):
            toolchain.cache_variables[f"FUSE_FLOW_{part}"] = "OFF"
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        CMake(self).install()

    def package_info(self):
        # FuseFlowConfig.cmake says all that is needed; Conan writes none beside it.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("lib", "cmake", "FuseFlow")]
        self.cpp_info.libs = []
