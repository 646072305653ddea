# Not run where this project is developed. build_dist.py makes a folder of this port, with the archive of the source beside this
# file: vcpkg install facebaker --overlay-ports=FOLDER
#
# For Windows the triplet's toolchain must be clang-cl (VCPKG_CHAINLOAD_TOOLCHAIN_FILE): cl has no vector types.
vcpkg_extract_source_archive(SOURCE_PATH ARCHIVE "${CURRENT_PORT_DIR}/facebaker-${VERSION}-source.tar.gz")

vcpkg_check_features(OUT_FEATURE_OPTIONS feature_options
  FEATURES openmp FB_OPENMP
  INVERTED_FEATURES bake FB_RUNTIME_ONLY)
vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS ${feature_options} -DFB_TOOL=OFF -DFB_SAMPLES=OFF -DFB_TESTS=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(PACKAGE_NAME FaceBaker CONFIG_PATH lib/cmake/FaceBaker)
vcpkg_fixup_pkgconfig()

file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share"
                    "${CURRENT_PACKAGES_DIR}/share/doc")
file(INSTALL "${CMAKE_CURRENT_LIST_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
