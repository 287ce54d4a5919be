# SPDX-License-Identifier: MIT
"""Puts libmlrt into the wheel: built by the checkout's Makefile into a folder of its own, without debug information.

The wheel fits any Python 3 on this platform, since nothing in it is compiled against Python.
"""

import re
import shutil
import subprocess
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py

CHECKOUT = Path(__file__).resolve().parents[2]
HEADER = CHECKOUT / "include" / "mlrt.h"
LIBRARY = "libmlrt.so.0"


class BuildWithLibrary(build_py):
    def run(self) -> None:
        super().run()
        if self.editable_mode:  # the package then finds build/ of the checkout
            subprocess.run(["make", "-C", CHECKOUT, "library"], check=True)
            return
        folder = Path(self.get_finalized_command("build").build_temp).resolve() / "libmlrt"
        subprocess.run(["make", "-C", CHECKOUT, f"BUILD={folder}", "CFLAGS=", "library"], check=True)
        shutil.copy(folder / LIBRARY, Path(self.build_lib) / "mlrt" / LIBRARY)


class PlatformDistribution(Distribution):
    def has_ext_modules(self) -> bool:
        return True


class PlatformWheel(bdist_wheel):
    def get_tag(self) -> tuple[str, str, str]:
        return "py3", "none", super().get_tag()[2]


if not HEADER.exists():
    raise SystemExit("mlrt is built from a checkout of libmlrt: run pip in its folder bindings/python, or install a wheel")

setup(
    distclass=PlatformDistribution,
    version=re.search(r'MLRT_VERSION_STRING "(.*)"', HEADER.read_text()).group(1),
    cmdclass={"build_py": BuildWithLibrary, "bdist_wheel": PlatformWheel},
)
