"""Builds the package and the stubs of the wire format from ../../proto.

    pip install --no-build-isolation client/python

requires setuptools, wheel, and protoc with grpc_python_plugin (Debian: protobuf-compiler-grpc) or
grpcio-tools. All other settings are in pyproject.toml.
"""

import sys
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER))

from generate_stubs import generate  # noqa: E402  pylint: disable=wrong-import-position


class BuildWithStubs(build_py):
    """Adds the generated subpackage to the build."""

    def run(self) -> None:
        super().run()
        # An editable install imports from the source folder, so the stubs must be written there.
        target = FOLDER if self.editable_mode else Path(self.build_lib)
        generate(FOLDER.parents[1] / "proto", target / "steadymap" / "_generated")

    def get_outputs(self, include_bytecode: bool = True) -> list:
        """Adds the generated files to the outputs, so that the wheel contains all of them."""
        made = Path(self.build_lib, "steadymap", "_generated").rglob("*.py")
        return [*super().get_outputs(include_bytecode), *(str(file) for file in made)]


setup(cmdclass={"build_py": BuildWithStubs})
