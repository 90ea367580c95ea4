# Plants files into trees of their own. check_rooms.cmake must accept the allowed ones and refuse the
# others.
#
#   cmake -D WORK=<scratch folder> -P check_rooms_test.cmake

set(CHECK "${CMAKE_CURRENT_LIST_DIR}/check_rooms.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/expect.cmake")

# Includes go down only.
expect(PASS core/volume/tsdf_mesh.cpp "#include \"core/geometry/geometry.h\"")
expect(PASS core/volume/tsdf_mesh.cpp "#include \"core/volume/mesh.h\"")
expect(PASS core/volume/tsdf_mesh.cpp "#include <vector>")
expect(REFUSE core/geometry/geometry.h "#include \"core/volume/mesh.h\"")
expect(REFUSE core/volume/mesh.h "#include \"core/mapper.h\"")
expect(REFUSE server/store/disk/posix_file.cpp "  # include \"server/store/model/store.h\"")
expect(REFUSE client/upload/uploader.cpp "#include \"client/bench/simulator/simulation.h\"")
expect(REFUSE client/cli/query/query_command.cpp "#include \"client/bench/evaluation/report/evaluation.h\"")
# Each file is in a known room.
expect(PASS core/mapper.cpp "#include \"core/policy/map_updater.h\"")
expect(REFUSE core/new_idea.cpp "int x;")
expect(REFUSE server/new_room/file.h "int x;")
expect(REFUSE client/file.h "int x;")
# Tests mirror the rooms.
expect(PASS core/volume/mesh.h "" tests/core/volume/mesh_test.cpp "")
expect(PASS core/volume/mesh.h "" tests/core/volume/whatever_test.cpp "")
expect(REFUSE tests/core/frame/mesh_test.cpp "" core/volume/mesh.h "")
expect(REFUSE tests/core/nowhere/other_test.cpp "" core/volume/mesh.h "")

expect_empty_tree_is_refused()
