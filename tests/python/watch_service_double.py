"""A scripted WatchService with one script per stream."""

import concurrent.futures
import threading

import grpc

from steadymap._generated.v1 import watch_service_pb2, watch_service_pb2_grpc

Response = watch_service_pb2.WatchMapResponse


def created(revision, incarnation="one", continues_step=False):
    return Response(
        created=watch_service_pb2.WatchCreated(
            revision=revision,
            voxel_size_m=0.05,
            truncation_m=0.15,
            incarnation=incarnation,
            continues_step=continues_step,
        )
    )


def with_token(part, token):
    """Returns a part of a step with a resume token."""
    getattr(part, part.WhichOneof("kind")).resume_token = token
    return part


def snapshot(revision, *object_ids):
    response = Response(snapshot=watch_service_pb2.SnapshotChunk(revision=revision))
    for object_id in object_ids:
        response.snapshot.objects.add(id=object_id)
    return response


def delta(revision, previous_revision, *object_ids, removed=()):
    fragment = watch_service_pb2.DeltaFragment(
        revision=revision, previous_revision=previous_revision, commits=1, fragment=1, fragments=1
    )
    fragment.removed_object_ids.extend(removed)
    for object_id in object_ids:
        fragment.objects.add(id=object_id)
    return Response(delta=fragment)


def events(revision, *numbers):
    response = Response(events=watch_service_pb2.EventBatch(revision=revision))
    for number in numbers:
        response.events.events.add(number=number)
    return response


def progress(revision):
    token = b"token-%d" % revision
    return Response(progress=watch_service_pb2.WatchProgress(revision=revision, resume_token=token))


def resync(revision, reason="REVISION_COMPACTED"):
    return Response(resync=watch_service_pb2.WatchResync(revision=revision, reason=reason))


def goodbye(delay_ms):
    response = Response(goodbye=watch_service_pb2.WatchGoodbye())
    response.goodbye.reconnect_after.FromMilliseconds(delay_ms)
    return response


class WatchServiceDouble(watch_service_pb2_grpc.WatchServiceServicer):
    """Serves on a free port of loopback.

    A script contains responses and, at its end, the status to abort with; without a status the
    stream stays open until the watcher closes it.
    """

    def __init__(self, *scripts):
        self.requests = []
        self._scripts = iter(scripts)
        self._server = grpc.server(concurrent.futures.ThreadPoolExecutor(max_workers=4))
        watch_service_pb2_grpc.add_WatchServiceServicer_to_server(self, self._server)
        self.address = f"127.0.0.1:{self._server.add_insecure_port('127.0.0.1:0')}"
        self._server.start()

    def stop(self):
        self._server.stop(None).wait()

    def WatchMap(self, request, context):
        self.requests.append(request)
        for step in next(self._scripts, [grpc.StatusCode.NOT_FOUND]):
            if isinstance(step, grpc.StatusCode):
                context.abort(step, "as the script says")
            yield step
        gone = threading.Event()
        if context.add_callback(gone.set):
            gone.wait()
