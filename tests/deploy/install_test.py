"""Tests of `cmake --install`: programs and package run from the installed tree."""

import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))

from daemon_process import DaemonProcess, program  # noqa: E402


def run(*command, **environment):
    """Runs a command without the PYTHONPATH that ctest sets. Returns its output."""
    inherited = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run(
        [str(word) for word in command],
        env={**inherited, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise AssertionError(f"{command} failed:\n{done.stdout}{done.stderr}")
    return done.stdout


def install(prefix, destination=""):
    """Installs this build under a prefix. Returns the output of cmake."""
    command = (program("CMAKE_COMMAND"), "--install", program("STEADYMAP_BUILD"))
    return run(*command, "--prefix", prefix, DESTDIR=str(destination))


class InstallTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def start_daemon(self, executable, *options):
        work = self.folder / "work"
        work.mkdir()
        daemon = DaemonProcess(work, executable, options)
        self.addCleanup(daemon.kill)
        return daemon

    def check_python(self, server, package_folder, **environment):
        script = f"""
import steadymap
with steadymap.connect("{server}") as client:
    print(steadymap.__file__, len(client.list_maps()))
"""
        file, maps = run("/usr/bin/python3", "-B", "-c", script, **environment).split()
        self.assertEqual(Path(file), package_folder / "steadymap/__init__.py")
        self.assertEqual(maps, "1")


class APackageOfTheSystem(InstallTest):
    def setUp(self):
        super().setUp()
        self.root = self.folder / "root"
        install("/usr", self.root)

    def test_holds_a_daemon_a_command_line_and_a_python_package_that_work(self):
        configuration = self.root / "etc/steadymap/steadymap.toml"
        daemon = self.start_daemon(self.root / "usr/bin/steadymapd", "--config", configuration)
        steadymap = self.root / "usr/bin/steadymap"
        run(steadymap, "--server", daemon.address, "map", "create", "hall")
        self.assertIn("hall", run(steadymap, "--server", daemon.address, "map", "list"))
        packages = self.root / "usr/lib/python3/dist-packages"
        self.check_python(daemon.address, packages, PYTHONPATH=str(packages))

    def test_has_every_file_that_its_unit_names(self):
        unit = (self.root / "usr/lib/systemd/system/steadymapd.service").read_text("utf-8")
        start = re.search(r"^ExecStart=(.*)$", unit, re.MULTILINE)[1]
        documentation = re.search(r"^Documentation=file://(.*)$", unit, re.MULTILINE)[1]
        named = re.findall(r"(?<![\w$}])/\S+", start) + [documentation]
        self.assertGreaterEqual(len(named), 3)
        for path in named:
            self.assertTrue((self.root / path.lstrip("/")).is_file(), path)

    def test_keeps_a_configuration_that_was_edited(self):
        configuration = self.root / "etc/steadymap/steadymap.toml"
        configuration.write_text('listen = "localhost:1"\n', encoding="utf-8")
        install("/usr", self.root)
        self.assertEqual(configuration.read_text("utf-8"), 'listen = "localhost:1"\n')

    def test_holds_nothing_of_the_build_tree(self):
        build = program("STEADYMAP_BUILD")
        for path in self.root.rglob("*"):
            self.assertFalse(path.is_symlink(), path)
            self.assertNotIn("__pycache__", path.name)
            if path.suffix in (".py", ".service", ".toml"):
                self.assertNotIn(build, path.read_text("utf-8"), path)


class TheFolderOfAUser(InstallTest):
    def test_holds_what_works_without_any_setting(self):
        home = self.folder / "home"
        prefix = home / ".local"
        install(prefix)
        daemon = self.start_daemon(prefix / "bin/steadymapd")
        run(prefix / "bin/steadymap", "--server", daemon.address, "map", "create", "hall")
        version = run("/usr/bin/python3", "-c", "import sys; print('%d.%d' % sys.version_info[:2])")
        packages = prefix / f"lib/python{version.strip()}/site-packages"
        self.check_python(daemon.address, packages, HOME=str(home))
        # systemd does not search this prefix, and the unit denies its daemon access to homes.
        self.assertEqual(list(prefix.rglob("*.service")), [])


if __name__ == "__main__":
    unittest.main()
