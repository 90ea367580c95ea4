"""The client of a steadymapd daemon."""

import dataclasses
import os
from pathlib import Path
from typing import Any, AsyncIterator, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

from steadymap._generated.v1 import (
    map_service_pb2,
    map_service_pb2_grpc,
    query_service_pb2,
    query_service_pb2_grpc,
)
from steadymap.responses import (
    DistanceSamples,
    Listing,
    RayHits,
    hits_from_proto,
    ray_request,
    sample_request,
    samples_from_proto,
)
from steadymap.connection import Connection
from steadymap.exports import (
    ExportFormat,
    ExportSummary,
    choose_format,
    export_request,
    take_export,
    write_export,
)
from steadymap.frame import Frame
from steadymap.geometry import box_to_proto
from steadymap.map_change import MapChange, change_map
from steadymap.maps import (
    Map,
    MapOptions,
    SemanticClass,
    WorldFrame,
    full_map_name,
    map_from_proto,
    map_to_proto,
    split_map_name,
)
from steadymap.mesh import Mesh, parse_ply
from steadymap.objects import (
    Event,
    EventType,
    Object,
    event_from_proto,
    event_type_to_proto,
    object_from_proto,
)
from steadymap.robots import Robot, robot_from_proto
from steadymap.upload import Uploader
from steadymap.upload_options import UploadOptions, UploadSummary
from steadymap.volumes import Section, take_section
from steadymap.watch import Watch, WatchOptions, watch_asynchronously
from steadymap.watch_items import WatchItem

_OBJECTS_PER_PAGE = 1000
_EVENTS_PER_PAGE = 10_000
_MAPS_PER_PAGE = 1000


def connect(address: str, timeout_s: float = 30.0) -> "Client":
    """Returns a client of the daemon at `address` (`HOST:PORT`), plain text.

    Connects on first use. `timeout_s` bounds unary calls; exports may take 20 times as long.
    """
    return Client(address, timeout_s)


class Client:
    """Creates, uploads to and reads maps; returned by `connect`.

    As a context manager it closes its channels. A map is named by its id in the tenant `default`,
    or by `tenants/TENANT/maps/MAP`. Points, boxes and poses are in the map's world frame, metres.
    Every error of the service is a `steadymap.errors.SteadymapError`. Only uploads, watches and
    `update_map` are retried. Thread-safe.
    """

    def __init__(self, address: str, timeout_s: float) -> None:
        self._connection = Connection(address, timeout_s)
        channel = self._connection.channel
        self._maps = map_service_pb2_grpc.MapServiceStub(channel)
        self._queries = query_service_pb2_grpc.QueryServiceStub(channel)

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, kind: object, value: object, traceback: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the channels; running calls end with an error."""
        self._connection.close()

    def create_map(self, map_name: str, options: MapOptions = MapOptions()) -> Map:
        """Creates a map. AlreadyExistsError if a map of that name exists."""
        parent, map_id = split_map_name(map_name)
        request = map_service_pb2.CreateMapRequest(
            parent=parent, map_id=map_id, map=map_to_proto(options)
        )
        return map_from_proto(self._connection.call(self._maps.CreateMap, request))

    def get_map(self, map_name: str) -> Map:
        """Returns the current state of the map. NotFoundError if it does not exist."""
        request = map_service_pb2.GetMapRequest(name=full_map_name(map_name))
        return map_from_proto(self._connection.call(self._maps.GetMap, request))

    def list_maps(self, tenant: str = "default") -> List[Map]:
        """Returns a tenant's maps, sorted by name."""
        maps: List[Map] = []
        request = map_service_pb2.ListMapsRequest(
            parent=f"tenants/{tenant}", page_size=_MAPS_PER_PAGE
        )
        while True:
            page = self._connection.call(self._maps.ListMaps, request)
            maps.extend(map_from_proto(message) for message in page.maps)
            request.page_token = page.next_page_token
            if not request.page_token:
                return maps

    def update_map(
        self,
        map_name: str,
        *,
        labels: Optional[Mapping[str, str]] = None,
        remove_labels: Sequence[str] = (),
        world_frame: Optional[Union[WorldFrame, str]] = None,
        display_name: Optional[str] = None,
        byte_budget: Optional[int] = None,
        add_classes: Sequence[SemanticClass] = (),
        etag: Optional[str] = None,
    ) -> Map:
        """Changes the named properties, keeps all others, and returns the changed map.

        If another client changes the map at the same time, both changes take effect, unless `etag`
        is given. A request with a lost response is sent again, for about 10 s, and takes effect
        once.

        Args:
            map_name: The map's name.
            labels: Labels to add or overwrite.
            remove_labels: Keys to remove; unknown keys are ignored.
            world_frame: Replaces the current one; a string replaces only its description.
            display_name: Name for display, at most 128 characters.
            byte_budget: Memory limit of the map in bytes. 0: no limit.
            add_classes: Rows for the class table, valid for all later frames. Rows that already
                exist are allowed; InvalidArgumentError for a row that differs from the row with its
                id.
            etag: Required etag of the map, from `Map.etag`; AbortedError / ETAG_MISMATCH if the map
                has another one. None: any.
        """
        change = MapChange(
            labels=labels or {},
            removed_labels=remove_labels,
            world_frame=world_frame,
            display_name=display_name,
            byte_budget=byte_budget,
            classes=add_classes,
            etag=etag,
        )
        request = map_service_pb2.GetMapRequest(name=full_map_name(map_name))
        return map_from_proto(
            change_map(
                change,
                read=lambda: self._connection.call(self._maps.GetMap, request),
                send=lambda update: self._connection.call(self._maps.UpdateMap, update),
            )
        )

    def delete_map(self, map_name: str) -> None:
        """Deletes a map with its log and its history. NotFoundError if it does not exist."""
        self._connection.call(
            self._maps.DeleteMap, map_service_pb2.DeleteMapRequest(name=full_map_name(map_name))
        )

    def upload(
        self, map_name: str, frames: Iterable[Frame], options: UploadOptions = UploadOptions()
    ) -> UploadSummary:
        """Uploads frames and waits until all have reached `options.wait_for` or were refused.

        Survives broken connections and server restarts. A refused frame is no error of the upload;
        it is listed in `refused` of the summary. If the service loses frames that it had
        acknowledged, frames from a sequence, such as a list, are sent again.
        """
        if isinstance(frames, Frame):
            raise TypeError("frames: expected an iterable of frames, such as a list, got one frame")
        if isinstance(frames, Sequence) and options.read_again is None:
            options = dataclasses.replace(options, read_again=frames.__getitem__)
        with self.uploader(map_name, options) as uploader:
            for frame in frames:
                uploader.push(frame)
            return uploader.finish()

    def uploader(self, map_name: str, options: UploadOptions = UploadOptions()) -> Uploader:
        """Opens an upload session, to push frames as they are recorded."""
        return Uploader(self._connection.open_channel, full_map_name(map_name), options)

    def objects(
        self,
        map_name: str,
        *,
        class_ids: Sequence[int] = (),
        box: Any = None,
        min_stationarity: float = 0.0,
        changed_since: int = 0,
        include_archived: bool = False,
        include_tentative: bool = False,
    ) -> Listing[Object]:
        """Lists the objects that pass every filter, in ascending order of id.

        Args:
            map_name: The map's name.
            class_ids: Classes to select; empty: any.
            box: Selects objects with a cuboid that touches this box: lowest and highest corner,
                shape (2, 3), metres.
            min_stationarity: Lower limit of the expected stationarity, in [0, 1].
            changed_since: Selects objects changed after this revision; 0: all.
            include_archived: True to include removed objects.
            include_tentative: True to include objects with too few observations to be confirmed.
        """
        request = query_service_pb2.ListObjectsRequest(
            map=full_map_name(map_name),
            class_ids=class_ids,
            box=box_to_proto(box),
            min_stationarity=min_stationarity,
            changed_since=changed_since,
            include_archived=include_archived,
            include_tentative=include_tentative,
            page_size=_OBJECTS_PER_PAGE,
        )

        def fetch(token: str) -> Tuple[int, List[Object], str]:
            request.page_token = token
            page = self._connection.call(self._queries.ListObjects, request)
            return (
                page.revision,
                [object_from_proto(o) for o in page.objects],
                page.next_page_token,
            )

        return Listing(fetch)

    def get_object(self, map_name: str, object_id: int) -> Object:
        """Returns one object in any state. NotFoundError if the id was never used."""
        request = query_service_pb2.GetObjectRequest(
            map=full_map_name(map_name), object_id=object_id
        )
        return object_from_proto(self._connection.call(self._queries.GetObject, request).object)

    def events(
        self,
        map_name: str,
        *,
        types: Sequence[Union[EventType, str]] = (),
        object_ids: Sequence[int] = (),
        class_ids: Sequence[int] = (),
        first_number: int = 0,
        changed_since: int = 0,
        start_time_ns: Optional[int] = None,
        end_time_ns: Optional[int] = None,
    ) -> Listing[Event]:
        """Lists the events that pass every filter, in ascending order of number.

        Args:
            map_name: The map's name.
            types: Types to select, such as `"removed"`; empty: any.
            object_ids: Selects events of, or related to, these objects; empty: any. Events of
                robots have no object: they pass only if object_ids and class_ids are both empty.
            class_ids: Classes of the objects to select; empty: any.
            first_number: Smallest event number; 0: no limit.
            changed_since: Selects events recorded after this revision; 0: all.
            start_time_ns: Earliest capture time of the frames, included, nanoseconds since 1970.
            end_time_ns: Latest capture time of the frames, excluded, nanoseconds since 1970.
        """
        request = query_service_pb2.ListEventsRequest(
            map=full_map_name(map_name),
            types=[event_type_to_proto(value) for value in types],
            object_ids=object_ids,
            class_ids=class_ids,
            first_number=first_number,
            changed_since=changed_since,
            page_size=_EVENTS_PER_PAGE,
        )
        if start_time_ns is not None:
            request.start_time.FromNanoseconds(start_time_ns)
        if end_time_ns is not None:
            request.end_time.FromNanoseconds(end_time_ns)

        def fetch(token: str) -> Tuple[int, List[Event], str]:
            request.page_token = token
            page = self._connection.call(self._queries.ListEvents, request)
            return (page.revision, [event_from_proto(e) for e in page.events], page.next_page_token)

        return Listing(fetch)

    def robots(self, map_name: str) -> List[Robot]:
        """Returns the robots that a map of the policy POCD knows, by robot and sensor."""
        request = query_service_pb2.ListRobotsRequest(map=full_map_name(map_name))
        response = self._connection.call(self._queries.ListRobots, request)
        return [robot_from_proto(message) for message in response.robots]

    def sample_distance(self, map_name: str, points_m: Any) -> DistanceSamples:
        """Returns state and signed distance at points of shape (N, 3); at most 100 000 points."""
        request = sample_request(full_map_name(map_name), points_m)
        return samples_from_proto(self._connection.call(self._queries.SampleDistance, request))

    def cast_rays(
        self, map_name: str, origins_m: Any, directions: Any, max_range_m: float = 20.0
    ) -> RayHits:
        """Returns the first surface along at most 100 000 rays, and the length of their free part.

        Args:
            map_name: The map's name.
            origins_m: Shape (N, 3), or (3,) for a common origin; metres.
            directions: Shape (N, 3); any length but zero.
            max_range_m: Length of the rays, metres, in (0, 1000].
        """
        request = ray_request(full_map_name(map_name), origins_m, directions, max_range_m)
        return hits_from_proto(self._connection.call(self._queries.CastRays, request))

    def mesh(self, map_name: str, *, box: Any = None, object_ids: Sequence[int] = ()) -> Mesh:
        """Returns the map's surface as triangles.

        Args:
            map_name: The map's name.
            box: Selects the surface inside: lowest and highest corner, shape (2, 3), metres; None:
                all.
            object_ids: Objects to select, 0 is the background; empty: the whole current map.
        """
        request = export_request(full_map_name(map_name), ExportFormat.PLY, box, object_ids)
        chunks: List[bytes] = []
        messages = self._connection.stream(self._queries.ExportMap, request)
        summary = take_export(messages, chunks.append)
        return parse_ply(b"".join(chunks), summary.revision)

    def section(self, map_name: str, *, box: Any = None, object_ids: Sequence[int] = ()) -> Section:
        """Returns the volumes of a part of the map, for `unpack_leaves`.

        `box` and `object_ids` are those of `mesh`.
        """
        request = query_service_pb2.GetMapSectionRequest(
            map=full_map_name(map_name), box=box_to_proto(box), object_ids=object_ids
        )
        return take_section(self._connection.stream(self._queries.GetMapSection, request))

    def export(
        self,
        map_name: str,
        path: Union[str, "os.PathLike[str]"],
        file_format: Optional[Union[ExportFormat, str]] = None,
        *,
        box: Any = None,
        object_ids: Sequence[int] = (),
    ) -> ExportSummary:
        """Writes the map to a file, which appears once it is complete.

        `file_format` None: chosen by the extension of `path`. `box` and `object_ids` are those of
        `mesh`.
        """
        target = Path(path)
        chosen = choose_format(target, file_format)
        request = export_request(full_map_name(map_name), chosen, box, object_ids)
        return write_export(self._connection.stream(self._queries.ExportMap, request), target)

    def watch(self, map_name: str, options: WatchOptions = WatchOptions()) -> Watch:
        """Watches the changes of the map.

        Returns an iterator of Created, Snapshot, Delta, Events, Progress and Resync items. Survives
        broken connections and server restarts.
        """
        return Watch(self._connection.open_channel, full_map_name(map_name), options)

    def watch_async(
        self, map_name: str, options: WatchOptions = WatchOptions()
    ) -> AsyncIterator[WatchItem]:
        """Watches the changes with asyncio: `async for item in client.watch_async("hall")`."""
        name = full_map_name(map_name)
        return watch_asynchronously(self._connection.open_asynchronously, name, options)
