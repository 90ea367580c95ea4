# Run by `cmake --install`: installs the Python package into the folder that Debian's Python
# searches under the prefix, which is only known at installation. Requires STEADYMAP_PYTHON_VERSION,
# such as 3.11, STEADYMAP_PACKAGE_SOURCE and STEADYMAP_PACKAGE_STUBS.
if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  set(PACKAGES lib/python3/dist-packages)
elseif(CMAKE_INSTALL_PREFIX STREQUAL "/usr/local")
  set(PACKAGES lib/python${STEADYMAP_PYTHON_VERSION}/dist-packages)
else()
  set(PACKAGES lib/python${STEADYMAP_PYTHON_VERSION}/site-packages)
endif()
if(NOT EXISTS "${STEADYMAP_PACKAGE_STUBS}/__init__.py")
  message(FATAL_ERROR "The stubs of the Python package are missing: build the target "
                      "steadymap_python before the installation")
endif()
# A package of an earlier version may contain modules that no longer exist.
file(REMOVE_RECURSE "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/${PACKAGES}/steadymap")
file(
  INSTALL "${STEADYMAP_PACKAGE_SOURCE}/" "${STEADYMAP_PACKAGE_STUBS}"
  DESTINATION "${CMAKE_INSTALL_PREFIX}/${PACKAGES}/steadymap"
  PATTERN "__pycache__" EXCLUDE)
