"""Changes of existing maps."""

import dataclasses
import secrets
import time
from typing import Any, Callable, Mapping, Optional, Sequence, Union

from steadymap._generated.v1 import map_pb2, map_service_pb2
from steadymap.backoff import Backoff, BackoffOptions
from steadymap.errors import AbortedError, SteadymapError, is_server_answer
from steadymap.maps import SemanticClass, WorldFrame, set_class, set_world_frame

# Bounds the retries if another client changes the map continuously.
_MAX_READS = 10

_BACKOFF = BackoffOptions(give_up_after_s=10.0)


@dataclasses.dataclass(frozen=True)
class MapChange:
    """Changes to a map; None and empty fields keep their values. See `Client.update_map`."""

    labels: Mapping[str, str]
    removed_labels: Sequence[str]
    world_frame: Optional[Union[WorldFrame, str]]
    display_name: Optional[str]
    byte_budget: Optional[int]
    classes: Sequence[SemanticClass]
    etag: Optional[str]


def change_map(
    change: MapChange,
    read: Callable[[], map_pb2.Map],
    send: Callable[[map_service_pb2.UpdateMapRequest], map_pb2.Map],
    sleep: Callable[[float], Any] = time.sleep,
) -> map_pb2.Map:
    """Reads the map, changes it and returns the changed map.

    Same rules as client/map/map_change.h: if another client changed the map in between, it is read
    again, unless the change has an etag; a request with a lost response is sent again with its
    request id and takes effect once. `sleep` replaces the wait and the clock.
    """
    for reads in range(1, _MAX_READS + 1):
        request = _request(change, read())
        if not request.update_mask.paths:
            raise ValueError("update_map: expected at least one change")
        try:
            return _send_until_answered(request, send, sleep)
        except AbortedError as error:
            is_outdated = error.reason == "ETAG_MISMATCH"
            if not is_outdated or change.etag is not None or reads == _MAX_READS:
                raise
    raise AssertionError("the last read returns or raises")


def _request(change: MapChange, present: map_pb2.Map) -> map_service_pb2.UpdateMapRequest:
    """Builds the request for the change of the state that was read."""
    request = map_service_pb2.UpdateMapRequest(request_id=f"change-{secrets.token_hex(16)}")
    changed, paths = request.map, request.update_mask.paths
    changed.name = present.name
    changed.etag = present.etag if change.etag is None else change.etag
    if change.labels or change.removed_labels:
        changed.labels.update(present.labels)
        for key in change.removed_labels:
            changed.labels.pop(key, None)
        changed.labels.update(change.labels)
        paths.append("labels")
    if change.world_frame is not None:
        frame = change.world_frame
        if isinstance(frame, str):
            changed.world_frame.CopyFrom(present.world_frame)
            changed.world_frame.description = frame
        else:
            set_world_frame(frame, changed)
        paths.append("world_frame")
    if change.display_name is not None:
        changed.display_name = change.display_name
        paths.append("display_name")
    if change.byte_budget is not None:
        changed.byte_budget = change.byte_budget
        paths.append("byte_budget")
    if change.classes:
        changed.config.CopyFrom(present.config)
        _add_classes(change.classes, changed.config)
        paths.append("config.classes")
    return request


def _add_classes(rows: Sequence[SemanticClass], config: map_pb2.MapConfig) -> None:
    # Overwrites a row with the same id, so that the server reports which row cannot be changed.
    table = {row.id: row for row in config.classes}
    for row in rows:
        set_class(row, table[row.id] if row.id in table else config.classes.add())


def _send_until_answered(
    request: map_service_pb2.UpdateMapRequest,
    send: Callable[[map_service_pb2.UpdateMapRequest], map_pb2.Map],
    sleep: Callable[[float], Any],
) -> map_pb2.Map:
    backoff = Backoff(_BACKOFF, None)
    while True:
        start_s = time.monotonic()
        try:
            return send(request)
        except SteadymapError as error:
            if is_server_answer(error):
                raise
            took_s = time.monotonic() - start_s if sleep is time.sleep else 0.0
            delay_s = backoff.next_delay_s(was_answered=False, asked_s=0.0, took_s=took_s)
            if delay_s is None:
                raise
        sleep(delay_s)
