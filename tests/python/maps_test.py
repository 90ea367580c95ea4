"""Maps on a daemon."""

import unittest

from daemon_process import DaemonTest
from wall_frame import wall_frame

import steadymap
from steadymap import errors
from steadymap.maps import split_map_name


class Maps(DaemonTest):
    def test_are_created_with_the_servers_defaults(self):
        created = self.client.create_map("defaults")
        self.assertEqual(created.name, "tenants/default/maps/defaults")
        self.assertEqual(created.options.voxel_size_m, 0.05)
        self.assertEqual(created.options.policy, steadymap.UpdatePolicy.STATIC)
        self.assertEqual(len(created.options.classes), 16)
        self.assertEqual((created.revision, created.last_capture_time_ns), (0, None))
        self.assertEqual(self.client.get_map("defaults").incarnation, created.incarnation)

    def test_keep_their_options(self):
        options = steadymap.MapOptions(
            voxel_size_m=0.02,
            truncation_m=0.08,
            max_depth_m=4.0,
            policy="pocd",
            classes=[
                steadymap.SemanticClass(0, "rest", in_background=True),
                steadymap.SemanticClass(7, "box", "semi_static"),
                steadymap.SemanticClass(9, "person", steadymap.ClassMotion.DYNAMIC),
            ],
            display_name="The hall",
            byte_budget=1 << 30,
            parameters={"change_noise_m": 0.03, "max_evidence": 20.0},
        )
        self.client.create_map("options", options)
        self.assertEqual(self.client.get_map("options").options, options)

    def test_are_listed_by_tenant_and_deleted(self):
        for name in ("tenants/elsewhere/maps/b", "tenants/elsewhere/maps/a"):
            self.client.create_map(name)
        names = [entry.name for entry in self.client.list_maps("elsewhere")]
        self.assertEqual(names, ["tenants/elsewhere/maps/a", "tenants/elsewhere/maps/b"])
        self.client.delete_map("tenants/elsewhere/maps/a")
        self.assertEqual(len(self.client.list_maps("elsewhere")), 1)

    def test_of_the_same_name_are_refused(self):
        self.client.create_map("twice")
        with self.assertRaises(errors.AlreadyExistsError):
            self.client.create_map("twice")

    def test_that_are_not_there_are_not_found(self):
        for call in (self.client.get_map, self.client.delete_map, self.client.mesh):
            with self.assertRaises(errors.NotFoundError) as raised:
                call("nowhere")
            self.assertEqual(raised.exception.reason, "NOT_FOUND")
            self.assertIn("tenants/default/maps/nowhere", str(raised.exception))

    def test_with_options_out_of_range_name_the_field(self):
        with self.assertRaises(errors.InvalidArgumentError) as raised:
            self.client.create_map("coarse", steadymap.MapOptions(voxel_size_m=2.0))
        self.assertEqual(raised.exception.reason, "BAD_VALUE")
        self.assertEqual(raised.exception.field, "map.config.voxel_size_m")
        with self.assertRaises(errors.InvalidArgumentError) as raised:
            self.client.create_map(
                "quiet", steadymap.MapOptions(policy="pocd", parameters={"change_noise_m": 0.0})
            )
        self.assertEqual(raised.exception.field, "map.config.parameters[change_noise_m]")

    def test_with_names_that_are_none_are_refused(self):
        with self.assertRaises(errors.InvalidArgumentError) as raised:
            self.client.create_map("No Name")
        self.assertEqual(raised.exception.reason, "BAD_NAME")
        for wrong in ("a/b", "tenants/a/b/c", "tenants/a/maps/b/c"):
            with self.assertRaisesRegex(ValueError, "map: expected"):
                split_map_name(wrong)
        with self.assertRaisesRegex(TypeError, "map: expected a map's name"):
            self.client.get_map(7)

    def test_of_an_unknown_policy_are_refused_here(self):
        with self.assertRaisesRegex(
            ValueError, "'hopeful' is no UpdatePolicy: expected one of 'static', .*'pocd_paper'$"
        ):
            steadymap.MapOptions(policy="hopeful")

    def test_take_frames_from_an_iterable(self):
        self.client.create_map("one-frame")
        with self.assertRaisesRegex(TypeError, "expected an iterable of frames"):
            self.client.upload("one-frame", wall_frame())


class AClient(DaemonTest):
    def test_without_a_server_is_told_that_it_is_unavailable(self):
        # Port 1 of loopback has no listener.
        with steadymap.connect("127.0.0.1:1", timeout_s=5.0) as client:
            with self.assertRaises(errors.UnavailableError):
                client.list_maps()


if __name__ == "__main__":
    unittest.main()
