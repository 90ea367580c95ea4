# Run by `cmake --install`: installs the configuration and, under a prefix that systemd searches,
# the unit, with the paths of that prefix. Requires STEADYMAP_DEPLOY, the folder with both.
set(CONFIGURATION "${CMAKE_INSTALL_PREFIX}/etc/steadymap")
if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  set(CONFIGURATION /etc/steadymap)
endif()

# An administrator's changes survive the next installation.
if(EXISTS "$ENV{DESTDIR}${CONFIGURATION}/steadymap.toml")
  message(STATUS "Kept: $ENV{DESTDIR}${CONFIGURATION}/steadymap.toml")
else()
  file(INSTALL "${STEADYMAP_DEPLOY}/steadymap.toml" DESTINATION "${CONFIGURATION}")
endif()

if(CMAKE_INSTALL_PREFIX MATCHES "^/usr(/local)?$")
  set(UNIT "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/lib/systemd/system/steadymapd.service")
  file(READ "${STEADYMAP_DEPLOY}/steadymapd.service" TEXT)
  string(REPLACE "/usr/" "${CMAKE_INSTALL_PREFIX}/" TEXT "${TEXT}")
  string(REPLACE "/etc/steadymap" "${CONFIGURATION}" TEXT "${TEXT}")
  file(WRITE "${UNIT}" "${TEXT}")
  file(CHMOD "${UNIT}" FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
  message(STATUS "Installing: ${UNIT}")
else()
  message(STATUS "No systemd unit: systemd does not search ${CMAKE_INSTALL_PREFIX}")
endif()
