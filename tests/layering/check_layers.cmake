# Checks which headers each folder includes (the layers): Debian puts every library
# under /usr/include, so link dependencies alone would let anything through. And that no two headers
# define a type of the same name: a program that links both would take one for the other.
#
#   cmake -D ROOT=<source folder> -P check_layers.cmake

if(NOT DEFINED ROOT)
  message(FATAL_ERROR "ROOT must name the source folder")
endif()

# Folder by folder: regular expressions over what follows #include, one of which must match, and
# ones that must not.
set(STANDARD_HEADER "<[a-z_0-9]+>")
set(POSIX_HEADER "<[a-z_0-9]+\\.h>|<sys/[a-z_]+\\.h>|<netinet/[a-z_]+\\.h>|<arpa/[a-z_]+\\.h>")
set(GENERATED_PROTO "\"(steadymap/v1|google/protobuf)/[a-z_]+\\.pb\\.h\"")
set(GENERATED_SERVICE "\"steadymap/v1/[a-z_]+\\.grpc\\.pb\\.h\"")

set(FOLDERS core proto client server)

set(core_MAY
    ${STANDARD_HEADER}
    "\"core/.*\""
    "<(Eigen|absl|openvdb|tbb|oneapi/tbb|pcl)/.*>"
    "<(png|jpeglib|zlib|zstd|immintrin|stdint|string|math)\\.h>")
# No files, clock, log or threads of its own.
set(core_MAY_NOT
    "<(fstream|filesystem|iostream|chrono|ctime|thread|future)>"
    "<absl/(time|synchronization)/.*>")

set(proto_MAY
    ${STANDARD_HEADER}
    ${GENERATED_PROTO}
    "\"(core|proto)/.*\""
    "<(Eigen|absl|google/protobuf)/.*>"
    # The status alone: the twin of absl's that leaves the process.
    "<grpcpp/support/status\\.h>")

set(client_MAY
    ${STANDARD_HEADER}
    ${POSIX_HEADER}
    ${GENERATED_PROTO}
    ${GENERATED_SERVICE}
    "\"(core|proto|client)/.*\""
    "<(Eigen|absl|google/protobuf|grpc|grpcpp|CLI|nlohmann|spdlog|OpenEXR)/.*>")

set(server_MAY ".*")
set(server_MAY_NOT "\"(client|tests)/.*\"")

# Answers whether `text` matches any of the expressions, as a whole.
function(matches_any text result)
  set(${result} FALSE PARENT_SCOPE)
  foreach(expression IN LISTS ARGN)
    if(text MATCHES "^(${expression})$")
      set(${result} TRUE PARENT_SCOPE)
      return()
    endif()
  endforeach()
endfunction()

set(violations 0)
set(checked 0)
foreach(folder IN LISTS FOLDERS)
  file(GLOB_RECURSE files "${ROOT}/${folder}/*.h" "${ROOT}/${folder}/*.cpp")
  foreach(file IN LISTS files)
    file(RELATIVE_PATH name "${ROOT}" "${file}")
    file(STRINGS "${file}" lines REGEX "^[ \t]*#[ \t]*include")
    math(EXPR checked "${checked} + 1")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE "^[ \t]*#[ \t]*include[ \t]*([<\"][^>\"]*[>\"]).*$" "\\1" header "${line}")
      matches_any("${header}" allowed ${${folder}_MAY})
      matches_any("${header}" forbidden ${${folder}_MAY_NOT})
      if(forbidden OR NOT allowed)
        message(NOTICE "${name} includes ${header}, which ${folder}/ may not")
        math(EXPR violations "${violations} + 1")
      endif()
    endforeach()
    if(NOT name MATCHES "\\.h$")
      continue()
    endif()
    # At the start of a line: types within types have their own space of names.
    set(definition "^(struct|class|enum class) ([A-Z][A-Za-z0-9]*)( final)?( :.*| {.*)?$")
    file(STRINGS "${file}" lines REGEX "${definition}")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE "${definition}" "\\2" type "${line}")
      if(DEFINED header_of_${type})
        message(NOTICE "${name} defines ${type}, which ${header_of_${type}} does, too")
        math(EXPR violations "${violations} + 1")
      endif()
      set(header_of_${type} "${name}")
    endforeach()
  endforeach()
endforeach()

if(checked EQUAL 0)
  message(SEND_ERROR "no source file under ${ROOT}: nothing was checked")
elseif(violations GREATER 0)
  message(SEND_ERROR "${violations} includes and types cross the layers")
else()
  message(STATUS "layers hold in ${checked} files")
endif()
