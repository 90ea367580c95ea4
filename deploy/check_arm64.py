#!/usr/bin/env python3
"""Checks that core, server and client compile for arm64, with the cross compiler of Debian.

The kernels are compiled to objects, everything else is checked by the front end. The headers of
libraries are those of this machine: they do not depend on the processor.

    deploy/check_arm64.py BUILD     BUILD: a folder with compile_commands.json and the headers
                                    generated from proto/, configured for g++
"""

import json
import os
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

COMPILER = "aarch64-linux-gnu-g++"
PARTS = ("core", "server", "client")
KERNELS = "core/integration/tsdf_kernel"
# After the folders of the cross compiler, whose C library comes first.
HOST_HEADERS = ["-idirafter", "/usr/include", "-idirafter", "/usr/include/x86_64-linux-gnu"]


def is_checked(path):
    """True for the sources of PARTS, and for unity files made of them; not for AVX2."""
    return path.split(os.sep)[0] in PARTS and not path.endswith("_avx2.cpp")


def source_of(entry, root):
    """Returns the source of a compile command relative to the root or, of a unity file, to BUILD."""
    path = os.path.relpath(os.path.join(entry["directory"], entry["file"]), root)
    build = os.path.relpath(entry["directory"], root)
    return os.path.relpath(path, build) if path.startswith(build + os.sep) else path


def command_of(entry, is_kernel):
    """Returns the command of an entry, for the cross compiler."""
    words = shlex.split(entry["command"])
    output = words.index("-o")
    arguments = words[1:output] + words[output + 2 :]
    result = ["-o", os.devnull] if is_kernel else ["-fsyntax-only"]
    # A precompiled header that g++ left in BUILD is of no use here, and the header itself is.
    return [COMPILER, *arguments, "-Wno-invalid-pch", *HOST_HEADERS, *result]


def check(entry, source):
    """Compiles one entry. Returns its errors, empty if there are none."""
    result = subprocess.run(
        command_of(entry, source.startswith(KERNELS)),
        cwd=entry["directory"],
        capture_output=True,
        text=True,
        check=False,
    )
    return "" if result.returncode == 0 else f"{source}:\n{result.stderr}"


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: check_arm64.py BUILD")
    root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    with open(os.path.join(sys.argv[1], "compile_commands.json"), encoding="utf-8") as file:
        entries = json.load(file)
    checked = [(entry, source_of(entry, root)) for entry in entries]
    checked = [(entry, source) for entry, source in checked if is_checked(source)]
    if not checked:
        sys.exit(f"check_arm64.py: {sys.argv[1]} has no source of {', '.join(PARTS)}")
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        errors = [text for text in pool.map(lambda work: check(*work), checked) if text]
    print("\n".join(errors), end="", file=sys.stderr)
    print(f"check_arm64.py: {len(checked) - len(errors)} of {len(checked)} units compile")
    sys.exit(1 if errors else 0)


if __name__ == "__main__":
    main()
