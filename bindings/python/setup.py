# SPDX-License-Identifier: MIT
"""Puts libmlrt into the wheel: built by the checkout's Makefile into a folder of its own, without symbols nobody needs.

The wheel fits any Python 3 on this platform, since nothing in it is compiled against Python. Its platform tag names the glibc that
the library needs, which is that of the machine it is built on, or an older one if the compiler is told so:

    CC="python -m ziglang cc -target x86_64-linux-gnu.2.17" pip wheel --no-deps .

A source distribution has the C sources and the Makefile in libmlrt/.
"""

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

from setuptools import Distribution, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

HERE = Path(__file__).resolve().parent
IN_SDIST = HERE / "libmlrt"
SOURCES = IN_SDIST if IN_SDIST.is_dir() else HERE.parents[1]
HEADER = SOURCES / "include" / "mlrt.h"
LIBRARY = "libmlrt.so.0"


class BuildWithLibrary(build_py):
    def run(self) -> None:
        super().run()
        if self.editable_mode:  # the package then finds build/ of the checkout
            subprocess.run(["make", "-C", SOURCES, "library"], check=True)
            return
        build: Any = self.get_finalized_command("build")
        folder = Path(build.build_temp).resolve() / "libmlrt"
        shutil.rmtree(folder, ignore_errors=True)  # what another compiler made
        command = ["make", "-j2", "-C", SOURCES, f"BUILD={folder}", "CFLAGS=", "LDFLAGS=-s", f"{folder}/libmlrt.so"]
        subprocess.run(command, check=True)
        package = Path(self.build_lib) / "mlrt"
        shutil.copy(folder / LIBRARY, package / LIBRARY)
        shutil.copy(SOURCES / "LICENSE", package / "LICENSE")


class PlatformDistribution(Distribution):
    def has_ext_modules(self) -> bool:
        return True


def platform_tag(tag: str, library: bytes) -> str:
    """linux_* as manylinux_*, by the newest version of glibc's symbols that the library asks for."""
    versions = [(int(major), int(minor)) for major, minor in re.findall(rb"\0GLIBC_(\d+)\.(\d+)", library)]
    if not tag.startswith("linux_") or not versions:
        return tag
    major, minor = max(versions)
    return f"manylinux_{major}_{max(minor, 17)}_{tag.removeprefix('linux_')}"


class PlatformWheel(bdist_wheel):
    def get_tag(self) -> tuple[str, str, str]:
        folder: Any = self.bdist_dir
        library = Path(folder) / "mlrt" / LIBRARY
        tag = super().get_tag()[2]
        return "py3", "none", platform_tag(tag, library.read_bytes()) if library.exists() else tag


class SdistWithSources(sdist):
    def make_release_tree(self, base_dir: str, files: list[str]) -> None:
        super().make_release_tree(base_dir, files)
        target = Path(base_dir) / "libmlrt"
        for folder in ("include", "src"):
            shutil.copytree(SOURCES / folder, target / folder)
        for file in ("Makefile", "LICENSE"):
            shutil.copy(SOURCES / file, target / file)


if not HEADER.exists():
    raise SystemExit("mlrt is built from a checkout of libmlrt: run pip in its folder bindings/python, or install a wheel")

setup(
    distclass=PlatformDistribution,
    version=HEADER.read_text().partition('MLRT_VERSION_STRING "')[2].partition('"')[0],
    cmdclass={"build_py": BuildWithLibrary, "bdist_wheel": PlatformWheel, "sdist": SdistWithSources},
)
