"""The package from a user's view: installed, documented, with and without optional packages."""

import contextlib
import inspect
import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from daemon_process import DaemonTest, program
from wall_frame import wall_frame

import steadymap
from steadymap.images import encode_png

SOURCE = Path(program("STEADYMAP_SOURCE"))
EXAMPLE = SOURCE / "client/python/examples/upload_folder.py"


def run_python(*arguments, path=None):
    """Runs Python and returns its output; fails with its error output."""
    environment = dict(os.environ)
    if path is not None:
        environment["PYTHONPATH"] = str(path)
    command = [sys.executable, *map(str, arguments)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise AssertionError(f"{command} failed:\n{done.stdout}{done.stderr}")
    return done.stdout


def blocks_of_the_readme():
    """Returns the indented blocks of the README: commands and code."""
    text = (SOURCE / "README.md").read_text(encoding="utf-8")
    return [
        textwrap.dedent(block) for block in re.findall(r"(?:^(?: {4}.*)?\n)+", text, re.MULTILINE)
    ]


class TemporaryFolderTest(DaemonTest):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)


class AnInstalledPackage(TemporaryFolderTest):
    def copy_tree(self):
        """Copies the sources of an installation, because setuptools builds inside of them."""
        tree = self.folder / "tree"
        for part in ("client/python", "proto"):
            ignored = shutil.ignore_patterns("build", "*.egg-info", "__pycache__", "_generated")
            shutil.copytree(SOURCE / part, tree / part, ignore=ignored)
        return tree

    def test_works_without_the_tree_that_it_came_from(self):
        tree, target = self.copy_tree(), self.folder / "installed"
        options = ["--no-build-isolation", "--no-deps", "--no-index", "--quiet"]
        options += ["--disable-pip-version-check", "--target", target]
        run_python("-m", "pip", "install", *options, tree / "client/python")
        shutil.rmtree(tree)
        script = textwrap.dedent(
            f"""
            import steadymap
            with steadymap.connect("{self.daemon.address}") as client:
                client.create_map("installed")
                print(steadymap.__file__, len(client.list_maps()))
            """
        )
        file, maps = run_python("-c", script, path=target).split()
        self.assertEqual(Path(file), target / "steadymap/__init__.py")
        self.assertGreaterEqual(int(maps), 1)
        self.assertTrue((target / "steadymap/py.typed").exists())
        made = {path.name for path in (target / "steadymap/_generated/v1").glob("*.py")}
        self.assertIn("watch_service_pb2_grpc.py", made)

    def test_comes_about_by_the_commands_of_the_readme(self):
        (commands,) = [block for block in blocks_of_the_readme() if "pip install" in block]
        home = self.folder / "home"
        home.mkdir()
        # Debian's packages must be sufficient.
        environment = {**os.environ, "HOME": str(home), "PIP_NO_INDEX": "1"}
        environment.pop("PYTHONPATH")
        script = commands + "~/steadymap-python/bin/python -c 'import steadymap as s; print(s)'"
        done = subprocess.run(
            ["bash", "-e", "-c", script],
            cwd=self.copy_tree(),
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"{home}/steadymap-python/", done.stdout)


class TheReadme(DaemonTest):
    def test_has_an_example_that_works_as_written(self):
        (example,) = [block for block in blocks_of_the_readme() if "from steadymap import" in block]
        connect = steadymap.connect
        output = io.StringIO()
        # Only the address of this daemon differs from the example.
        with mock.patch("steadymap.connect", lambda address: connect(self.daemon.address)):
            with contextlib.redirect_stdout(output):
                exec(compile(example, "README.md", "exec"), {})
        lines = output.getvalue().splitlines()
        self.assertEqual(lines[0], "5 frames are in the map")
        self.assertEqual(lines[1], re.search(r"distance_m.*# (.*)", example)[1])
        self.assertEqual(lines[2], re.search(r"range_m.*# (.*)", example)[1])
        self.assertRegex(lines[3], r"\(\d{3,}, 3\)")
        self.assertTrue(lines[4].startswith("Created("), lines[4])


class TheExample(TemporaryFolderTest):
    def run_example(self, name, folder, *options):
        return run_python(EXAMPLE, "--server", self.daemon.address, *options, name, folder)

    def test_uploads_a_simulated_route_and_draws_its_objects(self):
        route, picture = self.folder / "route", self.folder / "objects.png"
        simulate = [program("STEADYMAP"), "simulate", "--route", "1-5", "--stride", "6", "--color"]
        subprocess.run([*simulate, "--write", str(route)], check=True, capture_output=True)
        output = self.run_example("depot", route, "--picture", picture)
        frames = len(list(route.glob("*/Depth/*.png")))
        self.assertGreater(frames, 50)
        self.assertIn(f"{frames} frames uploaded", output)
        self.assertNotIn("refused", output)
        self.assertGreater(self.client.get_map("depot").revision, frames)
        self.assertGreater(len(list(self.client.objects("depot"))), 5)
        self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))

    def test_uploads_a_recording_in_the_layout_of_7_scenes(self):
        depth = np.full((480, 640), 2000, np.uint16)
        for i in range(4):
            stem = self.folder / f"frame-{i:06d}"
            Path(f"{stem}.depth.png").write_bytes(encode_png(depth))
            pose = np.full((4, 4), np.nan) if i == 1 else np.eye(4)
            np.savetxt(f"{stem}.pose.txt", pose)
        output = self.run_example("kitchen", self.folder, "--policy", "static")
        self.assertIn("3 frames uploaded", output)
        # The camera's z axis is the world's y axis.
        samples = self.client.sample_distance("kitchen", (0.0, 1.95, 0.0))
        np.testing.assert_allclose(samples.distance_m, 0.05, atol=2e-3)


class ThePackage(DaemonTest):
    def test_says_something_about_everything_public(self):
        for name in steadymap.__all__:
            thing = getattr(steadymap, name)
            if not (inspect.isclass(thing) or inspect.isfunction(thing)):
                continue
            self.assertTrue(inspect.getdoc(thing), name)
            for member, value in vars(thing).items() if inspect.isclass(thing) else ():
                is_member = inspect.isfunction(value) or isinstance(value, (property, staticmethod))
                if is_member and not member.startswith("_"):
                    self.assertTrue(inspect.getdoc(value), f"{name}.{member}")
        for name in dir(steadymap.errors):
            if name.endswith("Error"):
                self.assertTrue(getattr(steadymap.errors, name).__doc__, name)

    def test_lives_beside_another_package_with_google_rpc(self):
        script = """
            from google.protobuf import descriptor_pb2, descriptor_pool
            file = descriptor_pb2.FileDescriptorProto()
            file.name, file.package = "google/rpc/status.proto", "google.rpc"
            file.message_type.add().name = "Status"
            descriptor_pool.Default().AddSerializedFile(file.SerializeToString())
            import steadymap
        """
        run_python("-c", textwrap.dedent(script))

    def test_uploads_without_what_is_optional(self):
        name = self.new_map()
        script = f"""
            import sys
            for module in ("crc32c", "zstandard", "matplotlib"):
                sys.modules[module] = None
            import steadymap
            from wall_frame import wall_frame
            options = steadymap.UploadOptions()
            assert options.encoding is steadymap.PixelEncoding.RAW, options.encoding
            with steadymap.connect("{self.daemon.address}") as client:
                assert client.upload("{name}", [wall_frame()] * 3).progress.integrated == 3
                options = steadymap.UploadOptions(encoding="zstd")
                try:
                    client.upload("{name}", [wall_frame()], options)
                except RuntimeError as error:
                    print(error)
        """
        output = run_python("-c", textwrap.dedent(script))
        self.assertIn("needs the Python package zstandard", output)

    def test_packs_with_what_is_installed(self):
        self.assertIs(steadymap.UploadOptions().encoding, steadymap.PixelEncoding.ZSTD)
        self.assertEqual(self.client.upload(self.new_map(), [wall_frame()]).refused, [])


if __name__ == "__main__":
    unittest.main()
