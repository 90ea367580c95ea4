#!/usr/bin/env bash
# Builds a map from scratch: installs missing packages, builds, starts a daemon with its own store,
# uploads frames, writes the map to demo-output/, and stops the daemon.
#
#   deploy/demo.sh                          a simulated robot on the TorWIC route 1-5
#   deploy/demo.sh --route ROUTE            another simulated route
#   deploy/demo.sh --dataset FORMAT PATH... a recording: torwic, seven-scenes, tum, co-fusion
#                                           or panoptic
set -euo pipefail

usage="usage: demo.sh [--route ROUTE | --dataset FORMAT PATH...]"
source=(simulate --route 1-5)
policy=pocd
case "${1:-}" in
  "") ;;
  --route)
    (($# == 2)) || { echo "demo.sh: $usage" >&2; exit 2; }
    source=(simulate --route "$2")
    ;;
  --dataset)
    (($# >= 3)) || { echo "demo.sh: $usage" >&2; exit 2; }
    source=(upload --format "$2")
    # Recordings without labels contain no objects.
    [[ "$2" != seven-scenes && "$2" != tum ]] || policy=static
    for path in "${@:3}"; do
      [[ -d "$path" ]] || { echo "demo.sh: $path: expected a folder, found none" >&2; exit 2; }
      source+=("$(realpath "$path")")
    done
    ;;
  *)
    echo "demo.sh: $usage" >&2
    exit 2
    ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."

step="starting"
begin() {
  step=$1
  echo "== demo.sh: $step"
}
work="" # Contains the store and the logs of the daemon and the build.
log=""  # Printed if the current step fails.
daemon=""
on_exit() {
  local status=$?
  if [[ -n "$daemon" ]]; then
    kill -KILL "$daemon" 2>/dev/null || true
    wait "$daemon" 2>/dev/null || true
  fi
  if ((status != 0)); then
    [[ -n "$log" && -s "$log" ]] && tail -n 30 "$log" >&2
    echo "demo.sh: failed while $step (exit status $status)" >&2
  fi
  [[ -z "$work" ]] || rm -rf "$work"
}
trap on_exit EXIT
trap 'exit 130' INT TERM
work=$(mktemp -d -t steadymap-demo.XXXXXX)

begin "installing missing packages"
deploy/install_dependencies.sh

begin "configuring preset release"
log=$work/configure.log
cmake --preset release >"$log" 2>&1
log=""

begin "building into build/release"
cmake --build --preset release --target steadymap steadymapd steadymap_python

begin "starting a daemon with a store in $work/data"
log=$work/steadymapd.log
build/release/server/steadymapd --listen 127.0.0.1:0 --data-dir "$work/data" \
  --port-file "$work/port" >"$log" 2>&1 &
daemon=$!
for ((tenths = 0; tenths < 100; ++tenths)); do
  [[ -s "$work/port" ]] && break
  if ! kill -0 "$daemon" 2>/dev/null; then
    daemon=""
    exit 1
  fi
  sleep 0.1
done
[[ -s "$work/port" ]] || { echo "demo.sh: the daemon did not listen within 10 s" >&2; exit 1; }
server=127.0.0.1:$(<"$work/port")
echo "steadymapd listens on $server"
steadymap() { build/release/client/cli/steadymap --server "$server" "$@"; }

begin "uploading: ${source[*]}"
steadymap map create demo --policy "$policy"
steadymap "${source[0]}" demo "${source[@]:1}"

begin "reading the map"
steadymap map get demo
steadymap events demo | tail -n 15

begin "writing demo-output/"
mkdir -p demo-output
for format in ply vdb glb; do
  steadymap export demo --format "$format" --output "demo-output/map.$format"
done
steadymap render demo --output demo-output/map.png

begin "stopping the daemon"
kill -TERM "$daemon"
status=0
wait "$daemon" || status=$?
daemon=""
if ((status != 0)); then
  echo "demo.sh: steadymapd ended with exit status $status" >&2
  exit 1
fi
log=""
echo "== demo.sh: done; see demo-output/map.png"
