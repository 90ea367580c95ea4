#!/usr/bin/env bash
# Checks form: layers, references, shell scripts and Python all over, clang-format and clang-tidy on
# what changed; and, if a source changed, that everything compiles for arm64.
#
#   deploy/lint.sh [--all | --since COMMIT]
#
# Changed files: the differences from the merge base with main, or, on main itself, the commits of
# its last day, together with uncommitted changes. Without such a commit: all files. clang-tidy
# checks whole libraries and tests that contain changed files, newest first, for LINT_TIDY_SECONDS
# (default 300); then each changed file is compiled by itself, without headers that other files
# include, for LINT_COMPILE_SECONDS (default 120).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

fail() {
  echo "lint.sh: $*" >&2
  exit 1
}

base=""
everything=false
while (($#)); do
  case "$1" in
    --all) everything=true ;;
    --since)
      (($# >= 2)) || fail "--since needs a commit"
      base=$2
      shift
      ;;
    *) fail "unknown argument '$1'; usage: lint.sh [--all | --since COMMIT]" ;;
  esac
  shift
done

for tool in git cmake clang-format clang-tidy shellcheck black pyflakes3; do
  command -v "$tool" >/dev/null || fail "needs $tool: run deploy/install_dependencies.sh --lint"
done

find_base() {
  local main head
  head=$(git rev-parse --verify --quiet HEAD) || return 0
  for main in origin/main main; do
    local merge_base
    merge_base=$(git merge-base HEAD "$main" 2>/dev/null) || continue
    if [[ "$merge_base" != "$head" ]]; then
      echo "$merge_base"
      return 0
    fi
  done
  git rev-list -1 --before="$(($(git log -1 --format=%ct) - 24 * 60 * 60))" HEAD
}

# Newest change first: clang-tidy runs out of time at files that were checked before.
sources=('*.cpp' '*.h')
list_changed() {
  git diff --name-only HEAD -- "${sources[@]}"
  git ls-files --others --exclude-standard -- "${sources[@]}"
  if $everything; then
    git ls-files -- "${sources[@]}"
  else
    git log --format= --name-only ${base:+"$base.."}HEAD -- "${sources[@]}"
  fi
}

if ! $everything && [[ -z "$base" ]]; then base=$(find_base); fi
if [[ -n "$base" ]]; then
  git rev-parse --verify --quiet "$base^{commit}" >/dev/null || fail "no such commit: $base"
  echo "== lint.sh: changes since $(git log -1 --format='%h "%s"' "$base")"
else
  echo "== lint.sh: everything"
fi
mapfile -t changed < <(list_changed | awk '!seen[$0]++' | while read -r file; do
  if [[ -e "$file" ]]; then echo "$file"; fi
done)

status=0

echo "== lint.sh: layers"
cmake -D "ROOT=$PWD" -P tests/layering/check_layers.cmake || status=1
cmake -D "ROOT=$PWD" -P tests/layering/check_rooms.cmake || status=1

echo "== lint.sh: references"
cmake -D "ROOT=$PWD" -P tests/layering/check_documents.cmake || status=1

echo "== lint.sh: shellcheck"
mapfile -t scripts < <(git ls-files --cached --others --exclude-standard -- '*.sh' .ci/run)
shellcheck "${scripts[@]}" || status=1

echo "== lint.sh: Python"
mapfile -t python < <(git ls-files --cached --others --exclude-standard -- '*.py')
black --quiet --check --diff --config client/python/pyproject.toml "${python[@]}" || status=1
pyflakes3 "${python[@]}" || status=1

echo "== lint.sh: clang-format, ${#changed[@]} files"
if ((${#changed[@]})); then clang-format --dry-run -Werror "${changed[@]}" || status=1; fi

translation_units=()
for file in "${changed[@]}"; do
  if [[ "$file" == *.cpp ]]; then translation_units+=("$file"); fi
done
if ((${#translation_units[@]})); then
  log=$(mktemp)
  trap 'rm -f "$log"' EXIT

  # Compile commands for clang, and the headers generated from proto/, in separate build folders:
  # precompiled headers would hide missing includes. configure FOLDER [ARGUMENT]...
  configure() {
    if ! {
      cmake --preset clang -B "$1" -D CMAKE_DISABLE_PRECOMPILE_HEADERS=ON "${@:2}" &&
        cmake --build "$1" --target steadymap_proto steadymap_storage_proto
    } >"$log" 2>&1; then
      tail -n 30 "$log" >&2
      fail "the build for clang-tidy failed"
    fi
  }

  # Checks the files named on standard input, on all cores: check FOLDER CHECKS SECONDS. Must not be
  # the end of a pipe: `status` would be set in a subshell.
  check() {
    local deadline=$(($(date +%s) + $3))
    : >"$log"
    # shellcheck disable=SC2016  # the shell that xargs starts expands it
    xargs -d '\n' -n 1 -P "$(nproc)" bash -c '
      if (($(date +%s) < $3)); then
        clang-tidy -p "$1" --quiet --checks="$2" "$5" 2>/dev/null
      else
        echo "$5" >>"$4"
      fi' check "$1" "$2" "$deadline" "$log" || status=1
    [[ ! -s "$log" ]] ||
      echo "lint.sh: out of time, $(wc -l <"$log") not checked, from $(head -n 1 "$log") on"
  }

  # Headers take most of clang-tidy's time: checking a whole library costs little more than one
  # file.
  find_units() {
    local file units
    mapfile -t units < <(find build/lint-units -name 'unity_*.cxx')
    for file in "${translation_units[@]}"; do
      grep -lF "\"$PWD/$file\"" "${units[@]}" || echo "$file"
    done | awk '!seen[$0]++'
  }
  configure build/lint-units -D CMAKE_UNITY_BUILD=ON -D CMAKE_UNITY_BUILD_BATCH_SIZE=0
  mapfile -t units < <(find_units)
  echo "== lint.sh: clang-tidy, ${#units[@]} libraries and tests"
  check build/lint-units -bugprone-suspicious-include "${LINT_TIDY_SECONDS:-300}" \
    < <(printf '%s\n' "${units[@]}")

  # A clang-tidy check without findings, which also runs the compiler's own checks.
  echo "== lint.sh: each file by itself, ${#translation_units[@]} files"
  configure build/lint
  check build/lint '-*,clang-diagnostic-*,google-readability-todo' "${LINT_COMPILE_SECONDS:-120}" \
    < <(printf '%s\n' "${translation_units[@]}")
fi

if ((${#changed[@]})); then
  echo "== lint.sh: arm64"
  # In the folder of the test suite, which builds the same libraries next.
  cmake --preset ci >/dev/null
  cmake --build --preset ci --target steadymap_proto steadymap_storage_proto >/dev/null
  deploy/check_arm64.py build/ci || status=1
fi

((status == 0)) || fail "found the faults above"
echo "== lint.sh: clean"
