#!/usr/bin/env bash
# Installs missing packages, builds, and runs the whole test suite. The last lines printed are
# ctest's summary.
#
#   deploy/test.sh [PRESET]     PRESET: a configure preset with tests (default: ci)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
preset=${1:-ci}

step="starting"
begin() {
  step=$1
  echo "== test.sh: $step"
}
log=""
on_exit() {
  local status=$?
  if ((status != 0)); then
    [[ -n "$log" && -s "$log" ]] && tail -n 30 "$log" >&2
    echo "test.sh: failed while $step (exit status $status)" >&2
  fi
  [[ -z "$log" ]] || rm -f "$log"
}
trap on_exit EXIT

begin "installing missing packages"
deploy/install_dependencies.sh

begin "configuring preset $preset"
log=$(mktemp)
cmake --preset "$preset" >"$log" 2>&1
rm -f "$log"
log=""

begin "building into build/$preset"
cmake --build --preset "$preset"

begin "running the tests"
# Replaces this shell, so that ctest's summary is the last output and its status the exit status.
exec ctest --preset "$preset" --parallel "$(nproc)"
