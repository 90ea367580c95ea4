"""The service, seen from a program."""

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
from steadymap.upload import Uploader
from steadymap.upload_options import UploadOptions, UploadSummary
from steadymap.volumes import Section, take_section
from steadymap.watch import Watch, WatchOptions, watch_asynchronously
from steadymap.watch_items import WatchItem

_OBJECTS_PER_PAGE = 1000
_EVENTS_PER_PAGE = 10_000
_MAPS_PER_PAGE = 1000


def connect(address: str, timeout_s: float = 30.0) -> "Client":
    """A client of the daemon at `address` (`HOST:PORT`), plain text. Connects when first used.

    `timeout_s` bounds calls with one answer; exports take 20 times as long at most.
    """
    return Client(address, timeout_s)


class Client:
    """Creates, feeds and reads maps. Made by `connect`; a context manager that closes the channel.

    A map is named by its id in the tenant `default`, or by `tenants/TENANT/maps/MAP`. Points, boxes
    and poses are in the map's world frame, metres. Every error of the service is a
    `steadymap.errors.SteadymapError`; but for uploads and watches nothing is retried. Thread-safe.
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
        """Closes the channels; what still runs over them ends with an error."""
        self._connection.close()

    def create_map(self, map_name: str, options: MapOptions = MapOptions()) -> Map:
        """Creates a map. AlreadyExistsError if there is one of that name."""
        parent, map_id = split_map_name(map_name)
        request = map_service_pb2.CreateMapRequest(
            parent=parent, map_id=map_id, map=map_to_proto(options)
        )
        return map_from_proto(self._connection.call(self._maps.CreateMap, request))

    def get_map(self, map_name: str) -> Map:
        """The map as it is now. NotFoundError if there is none."""
        request = map_service_pb2.GetMapRequest(name=full_map_name(map_name))
        return map_from_proto(self._connection.call(self._maps.GetMap, request))

    def list_maps(self, tenant: str = "default") -> List[Map]:
        """A tenant's maps in the order of their names."""
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
        """Changes what is named here and leaves the rest; the map as it is then.

        Where somebody else changes the map at the same time, both changes are made, unless `etag`
        is given. A request whose answer is lost is sent again, for about 10 s, and counts once.

        Args:
            map_name: the map's name.
            labels: to add, or to give another value.
            remove_labels: keys to take away; one that the map lacks is no error.
            world_frame: in place of the present one; a string: its description alone.
            display_name: for people, at most 128 characters.
            byte_budget: most bytes of the map in memory. 0: no limit.
            add_classes: rows for the class table, which hold for the frames that come after. A row
                that is there already may be among them; InvalidArgumentError for one that differs
                from the row of its id.
            etag: of the only state that may be changed, as `Map.etag` has it; AbortedError /
                ETAG_MISMATCH where the map has another. None: whichever it has.
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
        """Deletes a map with its log and its history. NotFoundError if there is none."""
        self._connection.call(
            self._maps.DeleteMap, map_service_pb2.DeleteMapRequest(name=full_map_name(map_name))
        )

    def upload(
        self, map_name: str, frames: Iterable[Frame], options: UploadOptions = UploadOptions()
    ) -> UploadSummary:
        """Uploads frames and waits until all have reached `options.wait_for` or were refused.

        Broken connections and restarted servers are outlasted. A refused frame is no error of the
        upload: look at `refused` of the summary. Frames of a sequence, such as a list, that the
        service lost after it had acknowledged them are sent again.
        """
        if isinstance(frames, Sequence) and options.read_again is None:
            options = dataclasses.replace(options, read_again=frames.__getitem__)
        with self.uploader(map_name, options) as uploader:
            for frame in frames:
                uploader.push(frame)
            return uploader.finish()

    def uploader(self, map_name: str, options: UploadOptions = UploadOptions()) -> Uploader:
        """An upload session to push frames into as they come."""
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
        """The objects that pass every filter, by rising id.

        Args:
            map_name: the map's name.
            class_ids: of one of these classes; empty: of any.
            box: whose cuboid touches this box: lowest and highest corner, shape (2, 3), metres.
            min_stationarity: whose expected stationarity is not below this, in [0, 1].
            changed_since: that changed after this revision; 0: all.
            include_archived: those that are gone, too.
            include_tentative: those seen too seldom to be believed, too.
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
        """One object, whatever its standing. NotFoundError if there never was one of that id."""
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
        """The events that pass every filter, by rising number.

        Args:
            map_name: the map's name.
            types: of one of these types, such as `"removed"`; empty: of any.
            object_ids: of, or related to, one of these objects; empty: of any. Events of robots
                concern none: they pass where object_ids and class_ids are both empty.
            class_ids: of objects of one of these classes; empty: of any.
            first_number: from this number on; 0: from the first.
            changed_since: that came after this revision; 0: all.
            start_time_ns: of frames captured at or after this time, nanoseconds since 1970.
            end_time_ns: of frames captured before this time, likewise.
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

    def sample_distance(self, map_name: str, points_m: Any) -> DistanceSamples:
        """State of points of shape (N, 3), at most 100 000, and distance to the nearest surface."""
        request = sample_request(full_map_name(map_name), points_m)
        return samples_from_proto(self._connection.call(self._queries.SampleDistance, request))

    def cast_rays(
        self, map_name: str, origins_m: Any, directions: Any, max_range_m: float = 20.0
    ) -> RayHits:
        """First surface along rays, at most 100 000, and how far they are free.

        Args:
            map_name: the map's name.
            origins_m: shape (N, 3), or (3,) for all rays alike; metres.
            directions: shape (N, 3); any length but zero.
            max_range_m: rays end here, metres, in (0, 1000].
        """
        request = ray_request(full_map_name(map_name), origins_m, directions, max_range_m)
        return hits_from_proto(self._connection.call(self._queries.CastRays, request))

    def mesh(self, map_name: str, *, box: Any = None, object_ids: Sequence[int] = ()) -> Mesh:
        """The map's surface as triangles.

        Args:
            map_name: the map's name.
            box: surface within it: lowest and highest corner, shape (2, 3), metres; None: all.
            object_ids: of these objects, 0 being the background; empty: what the map shows.
        """
        request = export_request(full_map_name(map_name), ExportFormat.PLY, box, object_ids)
        chunks: List[bytes] = []
        messages = self._connection.stream(self._queries.ExportMap, request)
        summary = take_export(messages, chunks.append)
        return parse_ply(b"".join(chunks), summary.revision)

    def section(self, map_name: str, *, box: Any = None, object_ids: Sequence[int] = ()) -> Section:
        """The volumes of a part of the map, for `unpack_leaves`; arguments as for `mesh`."""
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
        """Writes the map to a file, which appears when it is whole.

        `file_format` None: by the ending of `path`. `box` and `object_ids` as for `mesh`.
        """
        target = Path(path)
        chosen = choose_format(target, file_format)
        request = export_request(full_map_name(map_name), chosen, box, object_ids)
        return write_export(self._connection.stream(self._queries.ExportMap, request), target)

    def watch(self, map_name: str, options: WatchOptions = WatchOptions()) -> Watch:
        """Follows the map as it changes: an iterator of Created, Snapshot, Delta, Events, Progress
        and Resync items. Broken connections and restarted servers are outlasted."""
        return Watch(self._connection.open_channel, full_map_name(map_name), options)

    def watch_async(
        self, map_name: str, options: WatchOptions = WatchOptions()
    ) -> AsyncIterator[WatchItem]:
        """The same for asyncio: `async for item in client.watch_async("hall")`."""
        name = full_map_name(map_name)
        return watch_asynchronously(self._connection.open_asynchronously, name, options)
