# SPDX-License-Identifier: MIT
"""The program with which README.md begins."""

import unittest
from pathlib import Path

README = Path(__file__).resolve().parents[1] / "README.md"


@unittest.skipUnless(README.exists(), "no README.md beside the tests")
class Readme(unittest.TestCase):
    def test_first_program(self):
        program = README.read_text().split("```python\n", 1)[1].split("```", 1)[0]
        names = {}
        exec(compile(program, str(README), "exec"), names)
        self.assertTrue(names["hits"].hit.any())
        self.assertEqual(names["picture"].t.shape, (480, 640))


if __name__ == "__main__":
    unittest.main()
