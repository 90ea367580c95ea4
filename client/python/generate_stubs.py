"""Generates the private subpackage `steadymap._generated` from the project's .proto files.

    python3 generate_stubs.py PROTO_FOLDER OUTPUT_FOLDER [--protoc FILE] [--plugin FILE]

Run by setup.py and by CMake; its output is never committed.
"""

import argparse
import importlib.util
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import List, Optional

# `from steadymap.v1 import frame_pb2`: generated code uses the proto package as Python package.
GENERATED_IMPORT = re.compile(r"^(from|import) steadymap\.v1\b", re.MULTILINE)

PACKAGE_TEXT = '"""Generated from the .proto files; private to steadymap."""\n'


def find_compiler(protoc: Optional[str], plugin: Optional[str]) -> List[str]:
    """Returns the command of protoc with a gRPC plugin for Python: Debian's or grpcio-tools'."""
    protoc = protoc or shutil.which("protoc")
    plugin = plugin or shutil.which("grpc_python_plugin")
    if protoc and plugin:
        return [protoc, f"--plugin=protoc-gen-grpc_python={plugin}"]
    if importlib.util.find_spec("grpc_tools"):
        return [sys.executable, "-m", "grpc_tools.protoc"]
    raise SystemExit(
        "generate_stubs.py: needs protoc and grpc_python_plugin (Debian: protobuf-compiler and "
        "protobuf-compiler-grpc), or the Python package grpcio-tools"
    )


def find_protos(proto_folder: Path) -> List[str]:
    """Returns the paths of the public .proto files, relative to `proto_folder`."""
    names = sorted(
        source.relative_to(proto_folder).as_posix()
        for source in (proto_folder / "steadymap/v1").glob("*.proto")
    )
    if not names:
        raise SystemExit(f"generate_stubs.py: no .proto files under {proto_folder}")
    return names


def generate(
    proto_folder: Path,
    output_folder: Path,
    protoc: Optional[str] = None,
    plugin: Optional[str] = None,
) -> None:
    """Writes the stubs to `output_folder`, which becomes `steadymap/_generated`."""
    compiler = find_compiler(protoc, plugin)
    with tempfile.TemporaryDirectory() as scratch:
        made = Path(scratch)
        names = find_protos(proto_folder)
        outputs = [f"--python_out={made}", f"--grpc_python_out={made}"]
        subprocess.run([*compiler, f"-I{proto_folder}", *outputs, *names], check=True)
        shutil.rmtree(output_folder, ignore_errors=True)
        for source in sorted(made.rglob("*.py")):
            text = source.read_text(encoding="utf-8")
            text = GENERATED_IMPORT.sub(r"\1 steadymap._generated.v1", text)
            if source.name.endswith("_grpc.py") and "channel.unary" not in text:
                continue  # No services: the plugin wrote an empty file.
            target = output_folder / source.relative_to(made / "steadymap")
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, encoding="utf-8")
    for folder in (output_folder, *(f for f in output_folder.iterdir() if f.is_dir())):
        (folder / "__init__.py").write_text(PACKAGE_TEXT, encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("proto_folder", type=Path)
    parser.add_argument("output_folder", type=Path)
    parser.add_argument("--protoc")
    parser.add_argument("--plugin")
    arguments = parser.parse_args()
    generate(arguments.proto_folder, arguments.output_folder, arguments.protoc, arguments.plugin)


if __name__ == "__main__":
    main()
