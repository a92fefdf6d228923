# Finds the Unity test framework and sets UNITY_SOURCE_DIR to the folder with unity.c and unity.h.
# Order: -DUNITY_ROOT= > an installed package > the release archive > Debian's package by a private apt state.
# Whatever is fetched has its hash checked and stays in the build folder.

set(UNITY_ROOT "" CACHE PATH "A Unity source tree (ThrowTheSwitch), if one is at hand")

set(unity_archive_sha256 b41a66d45a6b99758fb3202ace6178177014d52fc524bf1f72687d93e9867292)
set(unity_deb_sha256 166e45090937251892363d10860b5e7aa5353d5553fde2cbaba514760ba3785e)
set(unity_cache "${CMAKE_BINARY_DIR}/unity")

# unity_take(folder): use this tree if it is one.
macro(unity_take folder)
    if(NOT UNITY_SOURCE_DIR)
        foreach(place "${folder}/src" "${folder}")
            if(NOT UNITY_SOURCE_DIR AND EXISTS "${place}/unity.c" AND EXISTS "${place}/unity.h")
                set(UNITY_SOURCE_DIR "${place}")
            endif()
        endforeach()
    endif()
endmacro()

# Unpacks a file only when its hash is the expected one; a wrong one is removed.
function(unity_check_hash file expected ok)
    set(${ok} FALSE PARENT_SCOPE)
    if(EXISTS "${file}")
        file(SHA256 "${file}" found)
        if(found STREQUAL expected)
            set(${ok} TRUE PARENT_SCOPE)
        else()
            file(REMOVE "${file}")
        endif()
    endif()
endfunction()

function(unity_from_archive)
    set(archive "${unity_cache}/unity-2.6.1.tar.gz")
    message(STATUS "Unity: fetching the release archive")
    file(DOWNLOAD "https://github.com/ThrowTheSwitch/Unity/archive/refs/tags/v2.6.1.tar.gz" "${archive}"
         STATUS status TIMEOUT 60 INACTIVITY_TIMEOUT 15)
    unity_check_hash("${archive}" ${unity_archive_sha256} ok)
    if(ok)
        file(ARCHIVE_EXTRACT INPUT "${archive}" DESTINATION "${unity_cache}")
    endif()
endfunction()

function(unity_from_apt)
    find_program(EMA_APT_GET apt-get)
    find_program(EMA_DPKG_DEB dpkg-deb)
    mark_as_advanced(EMA_APT_GET EMA_DPKG_DEB)
    if(NOT EMA_APT_GET OR NOT EMA_DPKG_DEB)
        return()
    endif()
    # The machine's own mirror of the main archive, with the suite that carries the package. Its signature need not
    # be known here (trusted=yes): the package's hash is.
    execute_process(COMMAND "${EMA_APT_GET}" indextargets --format "$(SITE) $(RELEASE) $(COMPONENT)" "Created-By: Packages"
                    OUTPUT_VARIABLE targets ERROR_QUIET RESULT_VARIABLE failed)
    string(REGEX MATCHALL "[^\n]+" targets "${targets}")
    set(site "")
    foreach(target IN LISTS targets)
        if(NOT site AND NOT target MATCHES "security" AND target MATCHES "^([^ ]+) [^ ]+ main$")
            set(site "${CMAKE_MATCH_1}")
        endif()
    endforeach()
    if(failed OR NOT site)
        return()
    endif()
    message(STATUS "Unity: fetching Debian's package of it")
    set(state "${unity_cache}/apt")
    file(MAKE_DIRECTORY "${state}/lists/partial" "${state}/cache/archives/partial" "${state}/download")
    file(WRITE "${state}/sources.list" "deb [trusted=yes] ${site} trixie main\n")
    file(WRITE "${state}/apt.conf"
"Dir::Etc::sourcelist \"${state}/sources.list\";
Dir::Etc::sourceparts \"-\";
Dir::State::lists \"${state}/lists\";
Dir::Cache \"${state}/cache\";
Acquire::IndexTargets::deb::DEP-11::DefaultEnabled \"false\";
Acquire::IndexTargets::deb::Contents-deb::DefaultEnabled \"false\";
Acquire::Languages \"none\";
Acquire::Retries \"2\";
APT::Sandbox::User \"\";
Debug::NoLocking \"true\";
")
    set(apt ${CMAKE_COMMAND} -E env "APT_CONFIG=${state}/apt.conf" "${EMA_APT_GET}" -qq)
    execute_process(COMMAND ${apt} update OUTPUT_QUIET ERROR_QUIET TIMEOUT 300)
    execute_process(COMMAND ${apt} download cmock=2.5.3+git40-g379a9a8-2 WORKING_DIRECTORY "${state}/download"
                    OUTPUT_QUIET ERROR_QUIET TIMEOUT 120)
    file(GLOB debs "${state}/download/cmock_*.deb")
    foreach(deb IN LISTS debs)
        unity_check_hash("${deb}" ${unity_deb_sha256} ok)
        if(ok)
            execute_process(COMMAND "${EMA_DPKG_DEB}" -x "${deb}" "${unity_cache}/debian" OUTPUT_QUIET ERROR_QUIET)
        endif()
    endforeach()
    file(REMOVE_RECURSE "${state}")
endfunction()

set(UNITY_SOURCE_DIR "")
if(UNITY_ROOT)
    unity_take("${UNITY_ROOT}")
    if(NOT UNITY_SOURCE_DIR)
        message(FATAL_ERROR "UNITY_ROOT=${UNITY_ROOT} holds no unity.c: name the folder of a Unity source tree.")
    endif()
endif()
foreach(place /usr/share/cmock/vendor/unity /usr/share/unity /usr/local/share/unity
              "${unity_cache}/Unity-2.6.1" "${unity_cache}/debian/usr/share/cmock/vendor/unity")
    unity_take("${place}")
endforeach()
if(NOT UNITY_SOURCE_DIR)
    unity_from_archive()
    unity_take("${unity_cache}/Unity-2.6.1")
endif()
if(NOT UNITY_SOURCE_DIR)
    unity_from_apt()
    unity_take("${unity_cache}/debian/usr/share/cmock/vendor/unity")
endif()
if(NOT UNITY_SOURCE_DIR)
    message(FATAL_ERROR "The Unity test framework is not to be had from here: install the package cmock (Debian 13, Ubuntu 24.04),"
                        " or unpack Unity v2.6.1 and name it with -DUNITY_ROOT=, or build without the C tests: -DEMA_TESTS=OFF.")
endif()
message(STATUS "Unity: ${UNITY_SOURCE_DIR}")
