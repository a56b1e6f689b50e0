# SPDX-License-Identifier: MIT
# `cmake --install` and `cpack`: the programs, studies, documents and the Python module; with help2man a man page, too.
include(GNUInstallDirs)
find_program(TRILAT_HELP2MAN help2man)
if(TRILAT_HELP2MAN)
  set(manual ${PROJECT_BINARY_DIR}/trilat.1)
  add_custom_command(OUTPUT ${manual} DEPENDS trilat VERBATIM
    COMMAND ${TRILAT_HELP2MAN} --no-info --name "trilateration with several Kinect v2 against OptiTrack"
            --output ${manual} $<TARGET_FILE:trilat>)
  add_custom_target(trilat_manual ALL DEPENDS ${manual})
  install(FILES ${manual} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endif()

# The keys of all documents, as the program reads them.
set(keys ${PROJECT_BINARY_DIR}/keys.md)
add_custom_command(OUTPUT ${keys} DEPENDS trilat COMMAND trilat schema --markdown > ${keys})
add_custom_target(trilat_keys ALL DEPENDS ${keys})
install(FILES ${keys} DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs/reference)

install(TARGETS trilat trilat-agent RUNTIME)
install(DIRECTORY pipeline/studies DESTINATION ${CMAKE_INSTALL_DATADIR}/trilat)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES README.md CHANGELOG.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)
install(DIRECTORY python/trilat DESTINATION lib/python3/dist-packages PATTERN __pycache__ EXCLUDE)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "the trilat authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "trilateration with several Kinect v2 against OptiTrack")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS gnuplot-nox)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libjs-three, python3-h5py, python3-numpy")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "python3-hdf5plugin, python3-pandas, python3-matplotlib")
include(CPack)
