"""Responses to queries of a map's surface. Every response names the revision it was read at."""

import dataclasses
import enum
from typing import Any, Callable, Generic, Iterator, List, Tuple, TypeVar

import numpy as np

from steadymap._generated.v1 import query_service_pb2
from steadymap.geometry import as_points, read_only

_Entry = TypeVar("_Entry")


class Listing(Generic[_Entry], Iterator[_Entry]):
    """The entries of a list, fetched page by page during iteration.

    Attributes:
        revision: Revision of the page of the last returned entry; 0 before the first.
    """

    def __init__(self, fetch: Callable[[str], Tuple[int, List[_Entry], str]]) -> None:
        """`fetch` takes a page token and returns revision, entries and the next page's token."""
        self.revision = 0
        self._entries = self._iterate(fetch)

    def __next__(self) -> _Entry:
        return next(self._entries)

    def _iterate(self, fetch: Callable[[str], Tuple[int, List[_Entry], str]]) -> Iterator[_Entry]:
        token = ""
        while True:
            self.revision, entries, token = fetch(token)
            yield from entries
            if not token:
                return


class PointState(enum.IntEnum):
    """State of a point or a ray in a map, based on observations."""

    UNKNOWN = query_service_pb2.POINT_STATE_UNKNOWN
    """A point that was not observed, or not since an object was placed there; a ray that hits no
    surface and is not observed as free along its whole length."""
    FREE = query_service_pb2.POINT_STATE_FREE
    """A point in front of all surfaces or in observed free space; a ray that is free to its end."""
    SURFACE = query_service_pb2.POINT_STATE_SURFACE
    """A point at a surface or directly behind it; a ray that hits a surface from its front."""


@dataclasses.dataclass(frozen=True, eq=False)
class DistanceSamples:
    """State and signed distance of a map at N points.

    Attributes:
        revision: Revision of the map.
        state: uint8 (N,), values of PointState.
        distance_m: float64 (N,), metres; positive in front of the surface, negative behind it; NaN
            outside the truncation band of every observed surface.
        gradient: float64 (N, 3), world frame, unit length, away from the surface; zero if a
            neighbour is unknown, NaN if the distance is.
        object_id: uint64 (N,), owner of the volume; 0 is the background.
        class_id: uint32 (N,), class of that object; 0 for the background.
        weight: float64 (N,), evidence: 1 is one observation from 1 m; 0 without a distance.
    """

    revision: int
    state: np.ndarray
    distance_m: np.ndarray
    gradient: np.ndarray
    object_id: np.ndarray
    class_id: np.ndarray
    weight: np.ndarray


@dataclasses.dataclass(frozen=True, eq=False)
class RayHits:
    """First surfaces that N rays hit from their front.

    Attributes:
        revision: Revision of the map.
        state: uint8 (N,), values of PointState: SURFACE is a hit.
        free_until_m: float64 (N,), metres; length of the observed free part of the ray, without
            gaps from its origin; at most up to the surface or the greatest range.
        range_m: float64 (N,), distance from the ray's origin, metres; NaN without a hit.
        point_m: float64 (N, 3), world frame, metres; NaN without a hit.
        normal: float64 (N, 3), unit normal, towards the observed side; NaN without a hit.
        object_id: uint64 (N,), owner of the surface; 0 is the background.
        class_id: uint32 (N,), class of that object; 0 for the background.
    """

    revision: int
    state: np.ndarray
    free_until_m: np.ndarray
    range_m: np.ndarray
    point_m: np.ndarray
    normal: np.ndarray
    object_id: np.ndarray
    class_id: np.ndarray


def sample_request(map_name: str, points_m: Any) -> query_service_pb2.SampleDistanceRequest:
    """Builds the request for points of shape (N, 3)."""
    request = query_service_pb2.SampleDistanceRequest(map=map_name)
    for x, y, z in as_points(points_m, "points_m").tolist():
        request.points_m.add(x=x, y=y, z=z)
    return request


def ray_request(
    map_name: str, origins_m: Any, directions: Any, max_range_m: float
) -> query_service_pb2.CastRaysRequest:
    """Builds the request for rays of shape (N, 3); a single origin is used for all."""
    rays_directions = as_points(directions, "directions")
    rays_origins = as_points(origins_m, "origins_m")
    if len(rays_origins) == 1:
        rays_origins = np.broadcast_to(rays_origins, rays_directions.shape)
    if rays_origins.shape != rays_directions.shape:
        raise ValueError(
            "origins_m, directions: expected the same number of both, "
            f"got {len(rays_origins)} and {len(rays_directions)}"
        )
    request = query_service_pb2.CastRaysRequest(map=map_name, max_range_m=max_range_m)
    for origin, direction in zip(rays_origins.tolist(), rays_directions.tolist()):
        ray = request.rays.add()
        ray.origin_m.x, ray.origin_m.y, ray.origin_m.z = origin
        ray.direction.x, ray.direction.y, ray.direction.z = direction
    return request


def samples_from_proto(message: query_service_pb2.SampleDistanceResponse) -> DistanceSamples:
    """Converts the response to arrays."""
    samples = message.samples
    known = _column(samples, bool, lambda sample: sample.HasField("distance_m"))
    gradient = _vectors(samples, lambda sample: sample.gradient)
    distance_m = _column(samples, np.float64, lambda sample: sample.distance_m)
    distance_m[~known] = np.nan
    gradient[~known] = np.nan
    return DistanceSamples(
        revision=message.revision,
        state=read_only(_column(samples, np.uint8, lambda sample: sample.state)),
        distance_m=read_only(distance_m),
        gradient=read_only(gradient),
        object_id=read_only(_column(samples, np.uint64, lambda sample: sample.object_id)),
        class_id=read_only(_column(samples, np.uint32, lambda sample: sample.class_id)),
        weight=read_only(_column(samples, np.float64, lambda sample: sample.weight)),
    )


def hits_from_proto(message: query_service_pb2.CastRaysResponse) -> RayHits:
    """Converts the response to arrays."""
    hits = message.hits
    state = _column(hits, np.uint8, lambda entry: entry.state)
    range_m = _column(hits, np.float64, lambda entry: entry.range_m)
    point_m = _vectors(hits, lambda entry: entry.point_m)
    normal = _vectors(hits, lambda entry: entry.normal)
    for array in (range_m, point_m, normal):
        array[state != PointState.SURFACE] = np.nan
    return RayHits(
        revision=message.revision,
        state=read_only(state),
        free_until_m=read_only(_column(hits, np.float64, lambda entry: entry.free_until_m)),
        range_m=read_only(range_m),
        point_m=read_only(point_m),
        normal=read_only(normal),
        object_id=read_only(_column(hits, np.uint64, lambda entry: entry.object_id)),
        class_id=read_only(_column(hits, np.uint32, lambda entry: entry.class_id)),
    )


def _column(entries: Any, dtype: Any, value_of: Callable[[Any], Any]) -> np.ndarray:
    return np.fromiter(map(value_of, entries), dtype, count=len(entries))


def _vectors(entries: Any, vector_of: Callable[[Any], Any]) -> np.ndarray:
    vectors = [(v.x, v.y, v.z) for v in map(vector_of, entries)]
    return np.array(vectors, np.float64).reshape(-1, 3)
