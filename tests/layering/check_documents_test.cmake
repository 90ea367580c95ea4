# Writes references into trees of their own and expects check_documents.cmake to refuse those to
# what does not exist.
#
#   cmake -D WORK=<scratch folder> -P check_documents_test.cmake

set(CHECK "${CMAKE_CURRENT_LIST_DIR}/check_documents.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/expect.cmake")

# Makes the files that references may name.
function(make_tree)
  file(WRITE "${WORK}/README.md" "# The whole\n")
  file(WRITE "${WORK}/core/README.md"
       "# core: the map\n\n"
       "## Method (POCD)\n\n### What `v` means\n\n## Terms\n\n## Terms\n\n"
       "```\n# Fenced\n```\n\n    # Indented\n")
  file(WRITE "${WORK}/core/volume/voxel_leaf.h" "#pragma once\n")
  file(WRITE "${WORK}/proto/steadymap/v1/frame.proto" "syntax = \"proto3\"\;\n")
  file(WRITE "${WORK}/tests/python/upload_test.py" "import steadymap\n")
  file(WRITE "${WORK}/deploy/demo.sh" "#!/usr/bin/env bash\n")
endfunction()

# Documents, from the root and from the file's own folder.
expect(PASS core/step.h "/// As core/README.md has it.")
expect(PASS core/step.h "/// As README.md has it. All of it.")
expect(PASS core/volume/step.h "/// Nothing to read.")
expect(REFUSE core/step.h "/// As method.md has it (section 4).")
expect(REFUSE core/step.cpp "// See core/volume/README.md.")
expect(REFUSE server/main.cpp "  return 0\;  // see operations.md")
expect(REFUSE deploy/test.sh "# as tests/README.md says")
expect(PASS core/notes.md "The whole is in `README.md`, this part in `core/notes.md`.")

# Files and folders, from the root alone.
expect(PASS server/main.cpp "// The voxels of core/volume/voxel_leaf.h.")
expect(REFUSE server/main.cpp "// The voxels of core/volume/voxel.h.")
expect(REFUSE server/main.cpp "#include \"core/volume/voxel.h\"")
expect(PASS client/frame.py "\"\"\"See proto/steadymap/v1/frame.proto.\"\"\"")
expect(REFUSE client/frame.py "\"\"\"See proto/steadymap/v1/cloud.proto.\"\"\"")
expect(PASS README.md "Run `tests/python/upload_test.py`, then `deploy/demo.sh`.")
expect(REFUSE README.md "Run `tests/python/download_test.py`.")
expect(REFUSE README.md "Run `deploy/demonstration.sh`.")
expect(PASS CMakeLists.txt "add_library(a \${PROJECT_SOURCE_DIR}/core/volume/voxel_leaf.h)")
expect(REFUSE CMakeLists.txt "add_library(a \${PROJECT_SOURCE_DIR}/core/volume/voxel.h)")
expect(PASS core/README.md "The folder `core/volume/` holds leaves.")
expect(REFUSE core/README.md "The folder `core/grid/` holds leaves.")
expect(PASS core/README.md "What is built is in build/release/core/volume/voxel.h, or x/core/a.h.")

# Names in backquotes, wherever the file is.
expect(PASS server/main.cpp "// See `voxel_leaf.h` and `frame.proto`.")
expect(REFUSE server/main.cpp "// See `voxel.h`.")
expect(PASS server/main.cpp "// See <png.h>.")

# Links, from the document's own folder.
expect(PASS core/notes.md "See [the method](README.md) and [the voxels](volume/voxel_leaf.h).")
expect(PASS core/notes.md "See [the whole](../README.md) and [the folder](volume).")
expect(REFUSE core/notes.md "See [the voxels](core/volume/voxel_leaf.h).")
expect(REFUSE core/notes.md "See [the voxels](volume/voxel.h) [twice](README.md).")
expect(PASS core/notes.md "See [the paper](https://example.org/core/volume/voxel.md).")
expect(PASS core/notes.md "`[](int) { return 0\; }` is no link.")
expect(PASS core/notes.md "    f([](auto a) { return a\; })")
expect(PASS core/notes.md "```\nf([](auto a) { return a\; })\n```")

# Anchors.
expect(PASS core/step.h "/// As core/README.md#method-pocd has it.")
expect(PASS core/step.h "/// As core/README.md#what-v-means.")
expect(PASS core/step.h "/// As core/README.md#terms and core/README.md#terms-1.")
expect(REFUSE core/step.h "/// As core/README.md#terms-2 has it.")
expect(REFUSE core/step.h "/// As core/README.md#method has it.")
expect(REFUSE core/step.h "/// As core/README.md#fenced has it.")
expect(REFUSE core/step.h "/// As core/README.md#indented has it.")
expect(PASS core/notes.md "See [the terms](README.md#terms).")
expect(REFUSE core/notes.md "See [the terms](README.md#words).")
expect(PASS core/notes.md "# A [Linked](README.md) heading\n\nSee [above](#a-linked-heading).")
expect(REFUSE core/notes.md "# A heading\n\nSee [above](#another-heading).")

# What is not of the sources is not checked.
expect(PASS client/python/build/notes.md "See gone.md.")
expect(PASS client/python/steadymap/_generated/frame.py "# See gone.md.")
expect(PASS tests/layering/check_documents_test.cmake "expect(REFUSE core/gone.h gone.md)")
expect(PASS tests/data/notes.txt "See gone.md.")

expect_empty_tree_is_refused()
