# Plants files into trees of their own and expects check_rooms.cmake to tell right from wrong.
#
#   cmake -D WORK=<scratch folder> -P check_rooms_test.cmake

if(NOT DEFINED WORK)
  message(FATAL_ERROR "WORK must name a scratch folder")
endif()
set(CHECK "${CMAKE_CURRENT_LIST_DIR}/check_rooms.cmake")

# Expects a tree of one file to pass (`expected` is PASS) or to be refused by name. The file is `path`
# with the line `line`; a further argument is the path of an empty file beside it.
function(expect expected path line)
  file(REMOVE_RECURSE "${WORK}")
  file(WRITE "${WORK}/${path}" "#pragma once\n\n${line}\n")
  if(ARGN)
    file(WRITE "${WORK}/${ARGN}" "#pragma once\n")
  endif()
  execute_process(
    COMMAND ${CMAKE_COMMAND} -D "ROOT=${WORK}" -P "${CHECK}"
    RESULT_VARIABLE status
    OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  if(expected STREQUAL "PASS" AND NOT status EQUAL 0)
    message(SEND_ERROR "must be allowed: ${line} in ${path}\n${output}")
  elseif(expected STREQUAL "REFUSE")
    if(status EQUAL 0)
      message(SEND_ERROR "was not caught: ${line} in ${path}")
    elseif(NOT output MATCHES "${path}")
      message(SEND_ERROR "the message does not name ${path}:\n${output}")
    endif()
  endif()
endfunction()

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
expect(PASS core/volume/mesh.h "" tests/core/volume/mesh_test.cpp)
expect(PASS core/volume/mesh.h "" tests/core/volume/whatever_test.cpp)
expect(REFUSE tests/core/frame/mesh_test.cpp "" core/volume/mesh.h)
expect(REFUSE tests/core/nowhere/other_test.cpp "" core/volume/mesh.h)

# A tree without sources is a wrong path, not a clean tree.
file(REMOVE_RECURSE "${WORK}")
file(MAKE_DIRECTORY "${WORK}")
execute_process(
  COMMAND ${CMAKE_COMMAND} -D "ROOT=${WORK}" -P "${CHECK}"
  RESULT_VARIABLE status
  OUTPUT_QUIET ERROR_QUIET)
if(status EQUAL 0)
  message(SEND_ERROR "an empty tree passed")
endif()
file(REMOVE_RECURSE "${WORK}")
