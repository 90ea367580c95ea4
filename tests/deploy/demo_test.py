"""Tests of the build targets of the demonstration."""

import os
import re
import subprocess
import unittest
from pathlib import Path

SOURCE = Path(os.environ["STEADYMAP_SOURCE"])
BUILD = Path(os.environ["STEADYMAP_BUILD"])


class TheBuildOfTheDemo(unittest.TestCase):
    def test_makes_the_python_package_that_the_readme_points_at(self):
        readme = (SOURCE / "README.md").read_text(encoding="utf-8")
        self.assertIn("PYTHONPATH=build/release/client/python", readme)
        demo = (SOURCE / "deploy/demo.sh").read_text(encoding="utf-8")
        targets = re.search(r"cmake --build --preset release --target (.*)", demo)[1].split()
        # All presets have the same targets, so this build represents the release build.
        inputs = ["ninja", "-C", str(BUILD), "-t", "inputs", *targets]
        made_from = subprocess.run(inputs, check=True, capture_output=True, text=True).stdout
        self.assertTrue("client/python/generate_stubs.py\n" in made_from, targets)


if __name__ == "__main__":
    unittest.main()
