# SPDX-License-Identifier: MIT
"""Runs trimesh's own tests with mlrt.trimesh.RayMeshIntersector in place of both of trimesh's ray classes.

    python tests/trimesh_own.py FOLDER [pytest's arguments]

FOLDER is a checkout of trimesh (git clone --depth 1 --branch 5.2.0 https://github.com/mikedh/trimesh), or its unpacked source
distribution. That has no models; then the tests of rays, proximity, voxels and creation run with the stand-ins of trimesh_generic.py.
`make deps-python` installs what they need.

Prints each test in which the drop-in was asked something, and whether it passed. Tests that fail are run again with trimesh's own
classes, so that those that fail anyway can be told apart. Ends with 1 if there is a failure that is none of those. Without embreex
the tests meant for it are skipped.
"""

import functools
import importlib
import re
import sys
from pathlib import Path
from typing import Any

import pytest

from mlrt.trimesh import RayMeshIntersector

# Files with tests that use rays, directly or not; in others the drop-in is never asked.
ABOUT_RAYS = re.compile(r"\bray\b|ray_triangle|ray_pyembree|contains|thickness|reach\(|medial|volume_|proximity|signed_dist")

# Those of the source distribution.
FILES = ("test_ray.py", "test_proximity.py", "test_voxel.py", "test_creation.py")

QUERIES = ("intersects_id", "intersects_location", "intersects_first", "intersects_any", "contains_points")


class Record:
    """A plugin that notes outcomes, and how often the drop-in was asked."""

    def __init__(self) -> None:
        self.outcomes: dict[str, str] = {}
        self.asked: dict[str, int] = {}
        self._now = ""

    def count(self) -> None:
        self.asked[self._now] = self.asked.get(self._now, 0) + 1

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.when == "call" or report.outcome != "passed":
            self.outcomes[name_of(report.nodeid)] = report.outcome

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: Any) -> None:
        self._now = name_of(item.nodeid)


def name_of(node: str) -> str:
    return node.split("/")[-1]


def count_questions(record: Record) -> None:
    """Lets the drop-in tell the record of each question. It stays the class it is: trimesh's tests pickle it."""

    def wrap(original: Any) -> Any:
        @functools.wraps(original)
        def ask(*arguments: Any, **named: Any) -> Any:
            record.count()
            return original(*arguments, **named)

        return ask

    for query in QUERIES:
        setattr(RayMeshIntersector, query, wrap(getattr(RayMeshIntersector, query)))


def modules() -> list[Any]:
    found = [importlib.import_module("trimesh.ray.ray_triangle")]
    try:
        found.append(importlib.import_module("trimesh.ray.ray_pyembree"))
    except ImportError:
        print("no embreex: the tests meant for it are skipped")
    return found


def run(files: list[str], arguments: list[str], plugin: Record) -> None:
    pytest.main(["-q", "--no-header", "--tb=short", "-p", "no:cacheprovider", "-p", "no:randomly", *arguments, *files], plugins=[plugin])


def main(checkout: Path, arguments: list[str]) -> int:
    if not (checkout / "tests" / "test_ray.py").exists():
        print(f"{checkout}: neither a checkout of trimesh nor its source distribution: there is no tests/test_ray.py")
        return 2
    if (checkout / "models").is_dir():
        files = [str(file) for file in sorted((checkout / "tests").glob("test_*.py")) if ABOUT_RAYS.search(file.read_text())]
    else:
        files = [str(checkout / "tests" / name) for name in FILES]
        sys.modules["generic"] = importlib.import_module("trimesh_generic")
    record, own = Record(), Record()
    count_questions(record)
    replaced = [(module, module.RayMeshIntersector) for module in modules()]
    for module, _ in replaced:
        module.RayMeshIntersector = RayMeshIntersector
    run(files, arguments, record)
    for module, original in replaced:
        module.RayMeshIntersector = original
    failed = {name for name in record.outcomes if record.outcomes[name] == "failed"}
    if failed:
        run([f"{checkout / 'tests'}/{name}" for name in sorted(failed)], [], own)
    print("\n| test | questions | outcome |\n| --- | ---: | --- |")
    unexpected = 0
    for name, outcome in sorted(record.outcomes.items()):
        if outcome == "failed":
            anyway = own.outcomes.get(name) == "failed"
            unexpected += not anyway
            outcome = "fails, with trimesh's own classes as well" if anyway else "fails"
        if record.asked.get(name, 0) or (outcome != "passed" and outcome != "skipped"):
            print(f"| {name} | {record.asked.get(name, 0)} | {outcome} |")
    asked = [name for name in record.outcomes if record.asked.get(name, 0)]
    passed = [name for name in asked if record.outcomes[name] == "passed"]
    all_passed = sum(outcome == "passed" for outcome in record.outcomes.values())
    skipped = sum(outcome == "skipped" for outcome in record.outcomes.values())
    print(f"\n{len(passed)} of {len(asked)} tests that ask the drop-in pass")
    print(f"{all_passed} of {len(record.outcomes) - skipped} tests in {len(files)} files pass, {skipped} are skipped")
    return int(unexpected > 0 or not asked)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        raise SystemExit(__doc__)
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
